#include "passes/reference/reference.h"

namespace parhelion::passes {

namespace {

struct ReplayPush {
    uint64_t dump, hits;
    uint32_t width, height;
};

}  // namespace

void replay_rays(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const gpu::Buffer& dump, const gpu::Buffer& hits, uint32_t width, uint32_t height) {
    frame.trace("reference/replay_rays", way)
        .scene(scene.binding())
        .read("dump", dump)
        .write("hits", hits)
        .push(ReplayPush{.width = width, .height = height})
        .over(width, height);
}

}  // namespace parhelion::passes
