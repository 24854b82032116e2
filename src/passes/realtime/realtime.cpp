#include "passes/realtime/realtime.h"

#include "shared/scene.h"

namespace parhelion::passes {

namespace {

struct CompositePush {
    uint64_t view, block, diffuse, specular, emission;
    float nits;
};
struct DebugPush {
    uint64_t view, cache, block;
    uint32_t frame_index;
};

}  // namespace

Signals make_signals(const gpu::DevicePtr& device, uint64_t pixels) {
    const auto buffer = [&](const char* name, uint64_t bytes) { return gpu::Buffer(device, name, pixels * bytes); };
    return {.diffuse = buffer("realtime/diffuse", sizeof(shared::PackedLight)),
            .specular = buffer("realtime/specular", sizeof(shared::PackedLight)),
            .emission = buffer("realtime/emission", sizeof(shared::PackedLight)),
            .distances = buffer("realtime/distances", sizeof(uint32_t))};
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

void show_cache(Frame& frame, const SceneGpu& scene, const Film& film, const GBuffer& gbuffer, const gpu::Buffer& cache, uint32_t frame_index) {
    frame.compute("realtime/debug", (scene.features() & shared::kSceneLayers) != 0 ? "+LAYERS" : "")
        .scene(scene.binding())
        .read("view", film.view)
        .read("identity", gbuffer.identity)
        .read_write("cache", cache)
        .read_write("block", film.block)
        .push(DebugPush{.frame_index = frame_index})
        .over(gbuffer.identity.extent());
}

}  // namespace parhelion::passes
