#include "passes/bench/bench.h"

namespace parhelion::passes {

namespace {

struct MakeRaysPush {
    uint64_t primary, diffuse, shadow;
    shared::Camera camera;
    glm::vec3 box_min, box_max;
    uint32_t width, height;
};

}  // namespace

void make_bench_rays(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const shared::Camera& camera, glm::vec3 box_min, glm::vec3 box_max, const BenchRays& rays) {
    frame.trace("bench/make_rays", way)
        .scene(scene.binding())
        .write("primary", rays.primary)
        .write("diffuse", rays.diffuse)
        .write("shadow", rays.shadow)
        .push(MakeRaysPush{.camera = camera, .box_min = box_min, .box_max = box_max, .width = rays.width, .height = rays.height})
        .over(rays.width, rays.height);
}

}  // namespace parhelion::passes
