#include "passes/realtime/realtime.h"

#include <span>
#include <string>

#include "shared/scene.h"

namespace parhelion::passes {

namespace {

template <size_t kAddresses>
struct LightPush {
    uint64_t addresses[kAddresses];  // filled in by the bindings
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
            .distances = buffer("realtime/distances", sizeof(uint32_t)),
            .list = gpu::Buffer(device, "realtime/list", (4 + pixels) * sizeof(uint32_t))};
}

namespace {

enum class Kernel { All, Plain, Listed };

void light_by(Kernel kernel, Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const GBuffer& gbuffer, const gpu::Buffer& tiles, const gpu::Buffer* cache,
              const Signals& signals, const shared::RealtimeFrame& settings) {
    const std::string variant = std::string(kernel == Kernel::Plain ? "+PLAIN" : kernel == Kernel::Listed ? "+LAYERS+LISTED" : "") + (cache != nullptr ? "+CACHE" : "");
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
    if (cache != nullptr) pass.read_write("cache", *cache);
    if (kernel != Kernel::All) pass.read_write("list", signals.list);
    constexpr size_t kAlways = 8;
    const size_t addresses = kAlways + (cache != nullptr) + (kernel != Kernel::All);
    if (addresses == kAlways) pass.push(LightPush<kAlways>{.frame = settings});
    else if (addresses == kAlways + 1) pass.push(LightPush<kAlways + 1>{.frame = settings});
    else pass.push(LightPush<kAlways + 2>{.frame = settings});
    if (kernel == Kernel::Listed) pass.over_indirect(signals.list, 0);
    else pass.over(gbuffer.identity.extent());
}

}  // namespace

void light(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const GBuffer& gbuffer, const gpu::Buffer& tiles, const gpu::Buffer* cache,
           const Signals& signals, shared::RealtimeFrame settings) {
    if ((scene.features() & shared::kSceneLayers) == 0) return light_by(Kernel::All, frame, scene, way, film, gbuffer, tiles, cache, signals, settings);
    constexpr uint32_t kTracingGroup = 64;  // scene/trace.glsl
    settings.listed_group = way == gpu::TraceWay::Pipeline ? 1 : kTracingGroup;
    constexpr uint32_t kEmpty[4] = {0, 1, 1, 0};
    frame.upload(signals.list, 0, std::as_bytes(std::span(kEmpty)));
    light_by(Kernel::Plain, frame, scene, way, film, gbuffer, tiles, cache, signals, settings);
    light_by(Kernel::Listed, frame, scene, way, film, gbuffer, tiles, cache, signals, settings);
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
