#include "passes/reuse/reuse.h"

#include <algorithm>

#include "shared/scene.h"

namespace parhelion::passes {

namespace {

struct TemporalPush {
    uint64_t view, reservoirs, history;
    shared::ReuseFrame frame;
};
struct SpatialPush {
    uint64_t view, reservoirs, history;
    shared::ReuseFrame frame;
};
struct LightPush {
    uint64_t view, control, reservoirs, sums, pending, shadow_rays, shadow_list, block;
    shared::ReuseFrame frame;
};

const char* variant(const ReusePass& pass) { return (pass.scene.features() & shared::kSceneLayers) != 0 ? "+LAYERS" : ""; }

Pass kernel_of(const ReusePass& pass, const char* plain, const char* with_visibility) {
    return pass.with_visibility ? pass.frame.trace(with_visibility, pass.way, variant(pass)) : pass.frame.compute(plain, variant(pass));
}

}  // namespace

ReuseState make_reuse_state(const gpu::DevicePtr& device, gpu::Extent extent, uint32_t sets) {
    const uint64_t bytes = uint64_t{sets} * extent.width * extent.height * sizeof(shared::PackedReservoir);
    return {.reservoirs = gpu::Buffer(device, "reuse/reservoirs", bytes),
            .history = gpu::Buffer(device, "reuse/history", bytes),
            .identity_before = gpu::Image(device, "reuse/identity_before", {.format = gpu::Format::Rgba32Uint, .extent = extent})};
}

void reuse_before(const ReusePass& pass) {
    kernel_of(pass, "reuse/temporal", "reuse/temporal_seen")
        .scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read("identity", pass.gbuffer.identity)
        .read("identity_before", pass.state.identity_before)
        .read("motion", pass.gbuffer.motion)
        .read_write("reservoirs", pass.state.reservoirs)
        .read("history", pass.state.history)
        .push(TemporalPush{.frame = pass.settings})
        .over(pass.gbuffer.identity.extent());
}

void reuse_around(const ReusePass& pass) {
    kernel_of(pass, "reuse/spatial", "reuse/spatial_seen")
        .scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read("identity", pass.gbuffer.identity)
        .read("depth", pass.gbuffer.depth)
        .read("reservoirs", pass.state.reservoirs)
        .read_write("history", pass.state.history)
        .push(SpatialPush{.frame = pass.settings})
        .over(pass.gbuffer.identity.extent());
}

void light_pixels(const ReusePass& pass, const LightPaths& paths) {
    Pass kernel = pass.frame.compute("reuse/light", variant(pass));
    kernel.scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read("identity", pass.gbuffer.identity)
        .read_write("control", paths.machine.control)
        .read("reservoirs", pass.state.history)
        .read_write("sums", paths.sums)
        .read_write("pending", paths.pending)
        .write("shadow_rays", paths.machine.shadow_rays)
        .write("shadow_list", paths.machine.shadow_list)
        .read_write("block", pass.film.block)
        .push(LightPush{.frame = pass.settings});
    over_slots(kernel, paths.machine.shape.slots);
}

}  // namespace parhelion::passes
