#pragma once
// Traces given rays on the device by the scene's own functions, in any of the three ways (tests/device/shaders/visible.trace).
#include "support/render_fixture.h"

namespace parhelion::testing {

struct TestRay {
    glm::vec3 origin_ws, direction_ws;
};
struct TestFound {
    uint32_t instance;  // all ones: nothing was hit
    uint32_t primitive;
    uint32_t visible_now, visible_before;
    uint32_t deforms;  // the hit's bit for instances that skin or weights deform

    friend bool operator==(const TestFound&, const TestFound&) = default;
    bool hit() const { return instance != 0xFFFFFFFFu; }
};

// The ray's index is its alpha key. `mask`: of all these rays.
inline std::vector<TestFound> trace_rays(Stage& stage, gpu::TraceWay way, const std::vector<TestRay>& rays, uint32_t mask = 0xFFu) {
    struct Push {
        uint64_t rays = 0, found = 0;
        uint32_t count, mask;
    };
    Frame& frame = stage.frame;
    const gpu::Buffer input(frame.device(), "test/rays", rays.size() * sizeof(TestRay)), output(frame.device(), "test/found", rays.size() * sizeof(TestFound));
    frame.upload(input, 0, std::as_bytes(std::span(rays)));
    stage.scene_gpu.finish(frame);
    frame.trace("device/visible", way).scene(stage.scene_gpu.binding()).read("rays", input).write("found", output).push(Push{.count = static_cast<uint32_t>(rays.size()), .mask = mask}).over(static_cast<uint32_t>(rays.size()));
    const gpu::Buffer copy = frame.read_back(output);
    frame.run();
    const auto found = copy.mapped_as<TestFound>();
    return {found.begin(), found.end()};
}

}  // namespace parhelion::testing
