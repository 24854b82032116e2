#pragma once
// One pixel of a window, looked into: the surface there, the light that reaches it, one of its paths, and what the realtime renderer keeps of it.
#include <string>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "renderers/view.h"

namespace parhelion {

struct PixelReport {
    struct Section {
        std::string title;
        std::vector<std::pair<std::string, std::string>> rows;  // what, and its value in words
    };
    glm::uvec2 pixel{0};
    std::vector<Section> sections;
    bool meets_surface = false;
    glm::vec3 position_ws{0.0f};       // of the surface
    std::vector<glm::vec3> path_ws;    // vertices of the path of sample 0, the camera first; its last leg ends a while after it left the scene
    std::string text() const;          // all of it, a row a line
};

// What the reference says of a pixel of the view: the surface under its middle, the means of kProbeSamples samples by path class, and the path
// of the first. Runs frames of its own on `frame`, in which nothing is recorded yet.
constexpr uint32_t kProbeSamples = 64;
PixelReport probe_pixel(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const ViewDesc& view, glm::uvec2 pixel);

// What the realtime renderer did for a pixel in the frame that is recorded: debug layers of its film, which was cleared before it, and its
// reservoirs (null: it has none). Recorded after the renderer's passes; rows() is for after the frame has run.
class RealtimeProbe {
public:
    RealtimeProbe(Frame& frame, const View& view, const gpu::Buffer& reservoirs, glm::uvec2 pixel);
    std::vector<PixelReport::Section> sections(const SceneGpu& scene) const;

private:
    std::vector<std::string> channels_;
    gpu::Buffer values_, reservoir_;
};
// The layers that it reads.
std::vector<std::string> realtime_probe_layers();

}  // namespace parhelion
