#pragma once
// Passes that measure tracing by itself.
#include "frame/frame.h"
#include "scene_gpu/scene_gpu.h"
#include "shared/reference.h"
#include "shared/view.h"

namespace parhelion::passes {

// What make_rays draws: width x height rays of each kind (shared::DumpedRay), row by row.
struct BenchRays {
    gpu::Buffer primary, diffuse, shadow;
    uint32_t width = 0, height = 0;
};

// Camera rays, and from what they meet a cosine-distributed one and one to a point of the box [min, max], metres.
void make_bench_rays(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const shared::Camera& camera, glm::vec3 box_min, glm::vec3 box_max, const BenchRays& rays);

// Traces width x height rays and does nothing else. `hits`: shared::Hit a ray, or with `any_hit` a uint32_t, 1 where the ray is free.
void trace_bench_rays(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const gpu::Buffer& rays, bool any_hit, const gpu::Buffer& hits, uint32_t width, uint32_t height);

}  // namespace parhelion::passes
