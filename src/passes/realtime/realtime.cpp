#include "passes/realtime/realtime.h"

#include "shared/scene.h"

namespace parhelion::passes {

namespace {

struct LightPush {
    uint64_t view, block, rays, tiles, diffuse, specular, emission, distances;
    shared::RealtimeFrame frame;
};
struct LightInCachePush {
    uint64_t view, block, rays, tiles, cache, diffuse, specular, emission, distances;
    shared::RealtimeFrame frame;
};
struct CompositePush {
    uint64_t view, block, diffuse, specular, emission;
    float nits;
};

}  // namespace

Signals make_signals(const gpu::DevicePtr& device, uint64_t pixels) {
    const auto buffer = [&](const char* name, uint64_t bytes) { return gpu::Buffer(device, name, pixels * bytes); };
    return {.diffuse = buffer("realtime/diffuse", sizeof(shared::PackedLight)),
            .specular = buffer("realtime/specular", sizeof(shared::PackedLight)),
            .emission = buffer("realtime/emission", sizeof(shared::PackedLight)),
            .distances = buffer("realtime/distances", sizeof(uint32_t))};
}

void light(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const GBuffer& gbuffer, const gpu::Buffer& tiles, const gpu::Buffer* cache,
           const Signals& signals, const shared::RealtimeFrame& settings) {
    const std::string variant = std::string((scene.features() & shared::kSceneLayers) != 0 ? "+LAYERS" : "") + (cache != nullptr ? "+CACHE" : "");
    Pass pass = frame.trace("realtime/light", way, variant);
    pass.scene(scene.binding())
        .read("view", film.view)
        .read("identity", gbuffer.identity)
        .read("summary", gbuffer.summary)
        .read("tiles", tiles)
        .read_write("block", film.block)
        .read_write("rays", film.rays)
        .write("diffuse", signals.diffuse)
        .write("specular", signals.specular)
        .write("emission", signals.emission)
        .write("distances", signals.distances);
    if (cache != nullptr) pass.read_write("cache", *cache).push(LightInCachePush{.frame = settings});
    else pass.push(LightPush{.frame = settings});
    pass.over(gbuffer.identity.extent());
}

void composite(Frame& frame, const Film& film, const GBuffer& gbuffer, const Signals& signals, float exposure) {
    frame.compute("realtime/composite")
        .read("view", film.view)
        .read("summary", gbuffer.summary)
        .read("diffuse", signals.diffuse)
        .read("specular", signals.specular)
        .read("emission", signals.emission)
        .read_write("block", film.block)
        .push(CompositePush{.nits = 1.0f / exposure})
        .over(gbuffer.summary.extent());
}

}  // namespace parhelion::passes
