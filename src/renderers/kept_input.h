#pragma once
// What reconstruction got of a frame (passes::ReconstructionInput), kept and read back: for other bodies than the built-in one.
// docs/reconstruction.md says what the images hold.
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "passes/reconstruction/reconstruction.h"

namespace parhelion {

enum class InputForm { Number, Exact, Whole };  // floats that half serves, floats that it does not, whole numbers

// A plane of the input, in order of shared::kInput...
struct InputPlane {
    std::string_view channel;  // "reconstruction.diffuse.R", ...
    InputForm form;
};
std::span<const InputPlane> input_planes();

struct InputReadback {
    gpu::Extent size;  // of the rendered picture
    shared::Camera camera{}, camera_before{};
    glm::vec2 jitter_px{0.0f};
    float exposure = 1.0f;
    bool cut = false;
    std::vector<uint32_t> words = {};  // [plane][pixel]

    std::span<const uint32_t> plane(size_t index) const { return std::span(words).subspan(index * size.width * size.height, size_t{size.width} * size.height); }
};

class KeptInput {
public:
    // Before reconstruction, which uses the signals up.
    void record(Frame& frame, const passes::ReconstructionInput& input, const shared::ViewData& view);
    InputReadback read(Frame& frame) const;  // of the frame that was recorded last

private:
    gpu::Buffer planes_;
    InputReadback about_;  // without words
};

}  // namespace parhelion
