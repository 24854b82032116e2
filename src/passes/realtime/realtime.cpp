#include "passes/realtime/realtime.h"

namespace parhelion::passes {

namespace {

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
