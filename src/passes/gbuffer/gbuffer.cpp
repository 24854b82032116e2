#include "passes/gbuffer/gbuffer.h"

#include "shared/scene.h"

namespace parhelion::passes {

namespace {

struct IdentityPush {
    uint64_t view;
    uint32_t frame_index;
};
struct FollowPush {
    uint64_t view, rays;
    uint32_t frame_index;
    float exposure;
};
struct SurfacesPush {
    uint64_t view, block;
    uint32_t frame_index;
    float exposure;
};

}  // namespace

GBuffer make_gbuffer(const gpu::DevicePtr& device, gpu::Extent extent) {
    const auto image = [&](const char* name, gpu::Format format) { return gpu::Image(device, name, {.format = format, .extent = extent}); };
    return {.identity = image("gbuffer/identity", gpu::Format::Rgba32Uint),
            .summary = image("gbuffer/summary", gpu::Format::Rgba32Uint),
            .motion = image("gbuffer/motion", gpu::Format::Rg32Float),
            .depth = image("gbuffer/depth", gpu::Format::R32Float)};
}

void trace_identity(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const GBuffer& gbuffer, uint32_t frame_index) {
    frame.trace("gbuffer/identity", way)
        .scene(scene.binding())
        .read("view", film.view)
        .write("identity", gbuffer.identity)
        .push(IdentityPush{.frame_index = frame_index})
        .over(gbuffer.identity.extent());
}

void summarise_surfaces(Frame& frame, const SceneGpu& scene, const Film& film, const GBuffer& gbuffer, uint32_t frame_index, float exposure) {
    frame.compute("gbuffer/surfaces", (scene.features() & shared::kSceneLayers) != 0 ? "+LAYERS" : "")
        .scene(scene.binding())
        .read("view", film.view)
        .read_write("identity", gbuffer.identity)
        .write("summary", gbuffer.summary)
        .write("motion", gbuffer.motion)
        .write("depth", gbuffer.depth)
        .read_write("block", film.block)
        .push(SurfacesPush{.frame_index = frame_index, .exposure = exposure})
        .over(gbuffer.identity.extent());
}

void follow_mirrors(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const GBuffer& gbuffer, uint32_t frame_index, float exposure) {
    frame.trace("gbuffer/follow", way, (scene.features() & shared::kSceneLayers) != 0 ? "+LAYERS" : "")
        .scene(scene.binding())
        .read("view", film.view)
        .read_write("identity", gbuffer.identity)
        .read_write("summary", gbuffer.summary)
        .read_write("rays", film.rays)
        .write("motion", gbuffer.motion)
        .write("depth", gbuffer.depth)
        .push(FollowPush{.frame_index = frame_index, .exposure = exposure})
        .over(gbuffer.identity.extent());
}

}  // namespace parhelion::passes
