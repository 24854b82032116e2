#pragma once
// The built-in reconstruction: its passes in order, and what they keep from frame to frame.
#include <array>

#include "passes/reconstruction/reconstruction.h"

namespace parhelion {

using ReconstructionOptions = passes::ReconstructionOptions;

class Reconstruction {
public:
    // Throws a usage Error for options that are out of range.
    Reconstruction(const gpu::DevicePtr& device, gpu::Extent rendered, gpu::Extent picture, const ReconstructionOptions& options);

    // Where the frame of an index looks through its pixels, from their centres.
    glm::vec2 jitter_px(uint32_t frame_index) const;
    // The frame's picture, as one more sample of the input's film.
    void record(Frame& frame, const passes::ReconstructionInput& input, uint32_t frame_index);

private:
    gpu::Extent rendered_;
    ReconstructionOptions options_;
    std::array<passes::ReconstructionHistory, 2> histories_;
    gpu::Buffer normals_;
    gpu::Sampler sampler_;
    uint32_t now_ = 0;
    bool has_history_ = false;
    glm::vec2 jitter_before_px_{0.0f};
    float exposure_before_ = 1.0f;
};

}  // namespace parhelion
