#include "passes/bench/bench.h"

namespace parhelion::passes {

namespace {

struct TraceRaysPush {
    uint64_t rays, hits;
    uint32_t width, height;
};

}  // namespace

void trace_bench_rays(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const gpu::Buffer& rays, bool any_hit, const gpu::Buffer& hits, uint32_t width, uint32_t height) {
    frame.trace("bench/trace_rays", way, any_hit ? "+ANY_HIT" : "")
        .scene(scene.binding())
        .read("rays", rays)
        .write("hits", hits)
        .push(TraceRaysPush{.width = width, .height = height})
        .over(width, height);
}

}  // namespace parhelion::passes
