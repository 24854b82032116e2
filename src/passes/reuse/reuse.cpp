#include "passes/reuse/reuse.h"

#include <algorithm>
#include <utility>

#include "shared/scene.h"

namespace parhelion::passes {

namespace {

struct SeenPush {
    uint64_t view, reservoirs, history;
    shared::ReuseFrame frame;
};
struct ReusePush {
    uint64_t view, reservoirs, history, diffuse, specular;
    shared::ReuseFrame frame;
};
struct DuplicatesPush {
    uint64_t view, reservoirs, block;
    uint32_t set;
};
struct TellPush {
    uint64_t view, reservoirs, told;
    shared::ReuseFrame frame;
};
struct ChoosePush {
    uint64_t view, control, lists, reservoirs, told, chosen, sums, block, rays, diffuse, specular;
    shared::ReuseFrame frame;
    float exposure;
};
struct LightPush {
    uint64_t view, control, lists, reservoirs, chosen, sums, pending, shadow_rays, shadow_list, block;
    shared::ReuseFrame frame;
    uint32_t list;
};

bool has_layers(const ReusePass& pass) { return (pass.scene.features() & shared::kSceneLayers) != 0; }
const char* variant(const ReusePass& pass) { return has_layers(pass) ? "+LAYERS" : ""; }

// A kernel's list of pixels.
void light_by(const ReusePass& pass, const LightPaths& paths, const char* variant, uint32_t list) {
    const WavefrontState& machine = paths.machine;
    pass.frame.compute("reuse/light", variant)
        .scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read("identity", pass.gbuffer.identity)
        .read_write("control", machine.control)
        .read_write("lists", machine.lists)
        .read("reservoirs", pass.state.reservoirs)
        .read("chosen", paths.offers)
        .read_write("sums", paths.sums)
        .read_write("pending", paths.pending)
        .write("shadow_rays", machine.shadow_rays)
        .write("shadow_list", machine.shadow_list)
        .read_write("block", pass.film.block)
        .push(LightPush{.frame = pass.settings, .list = list})
        .over_indirect(machine.sizes, list * sizeof(shared::WavefrontSize));
}

}  // namespace

ReuseState make_reuse_state(const gpu::DevicePtr& device, gpu::Extent extent, uint32_t sets, uint32_t neighbours, bool exact) {
    const uint64_t bytes = uint64_t{sets} * extent.width * extent.height * sizeof(shared::PackedReservoir);
    const auto image = [&](const char* name, gpu::Format format) { return gpu::Image(device, name, {.format = format, .extent = extent}); };
    const uint64_t told = uint64_t{sets} * (std::max(neighbours, 1u) + 1) / 2 * extent.width * extent.height;
    ReuseState state{.reservoirs = gpu::Buffer(device, "reuse/reservoirs", bytes),
                     .before = gpu::Buffer(device, "reuse/before", bytes),
                     .told = gpu::Buffer(device, "reuse/told", told * sizeof(uint32_t))};
    if (exact) state.identity_before = image("reuse/identity_before", gpu::Format::Rgba32Uint);
    else {
        state.summary_before = image("reuse/summary_before", gpu::Format::Rgba32Uint);
        state.depth_before = image("reuse/depth_before", gpu::Format::R32Float);
    }
    return state;
}

void keep_last_frame(ReuseState& state, GBuffer& gbuffer) {
    std::swap(state.reservoirs, state.before);
    if (state.identity_before) std::swap(state.identity_before, gbuffer.identity);
    if (!state.summary_before) return;
    std::swap(state.summary_before, gbuffer.summary);
    std::swap(state.depth_before, gbuffer.depth);
}

void reuse_before(const ReusePass& pass) {
    const ReuseState& state = pass.state;
    Pass kernel = pass.exact ? pass.frame.trace("reuse/temporal_seen", pass.way, variant(pass)) : pass.frame.compute("reuse/temporal", variant(pass));
    kernel.scene(pass.scene.binding()).read("view", pass.film.view).read("motion", pass.gbuffer.motion).read_write("reservoirs", state.reservoirs).read("history", state.before);
    if (pass.exact) kernel.read("identity", pass.gbuffer.identity).read("identity_before", state.identity_before).push(SeenPush{.frame = pass.settings});
    else
        kernel.read("summary", pass.gbuffer.summary)
            .read("depth", pass.gbuffer.depth)
            .read("summary_before", state.summary_before)
            .read("depth_before", state.depth_before)
            .read_write("diffuse", pass.signals.diffuse)
            .read_write("specular", pass.signals.specular)
            .push(ReusePush{.frame = pass.settings});
    kernel.over(pass.gbuffer.identity.extent());
}

void show_duplicates(const ReusePass& pass) {
    pass.frame.compute("reuse/duplicates")
        .read("view", pass.film.view)
        .read("reservoirs", pass.state.reservoirs)
        .read_write("block", pass.film.block)
        .push(DuplicatesPush{.set = pass.settings.set})
        .over(pass.gbuffer.identity.extent());
}

void tell_partners(const ReusePass& pass) {
    Pass kernel = pass.frame.trace(pass.exact ? "reuse/exchange_seen" : "reuse/exchange", pass.way, variant(pass));
    kernel.scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read("summary", pass.gbuffer.summary)
        .read("depth", pass.gbuffer.depth)
        .read("reservoirs", pass.state.reservoirs)
        .write("told", pass.state.told);
    if (pass.exact) kernel.read("identity", pass.gbuffer.identity);
    kernel.push(TellPush{.frame = pass.settings}).over(pass.gbuffer.identity.extent());
}

void choose_samples(const ReusePass& pass, const LightPaths& paths) {
    Pass kernel = pass.frame.compute("reuse/choose");
    kernel.scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read("identity", pass.gbuffer.identity)
        .read("summary", pass.gbuffer.summary)
        .read_write("control", paths.machine.control)
        .read_write("lists", paths.machine.lists)
        .read("reservoirs", pass.state.reservoirs)
        .read("told", pass.state.told)
        .write("chosen", paths.offers)
        .read_write("sums", paths.sums)
        .read_write("block", pass.film.block)
        .read_write("rays", pass.film.rays)
        .read_write("diffuse", pass.signals.diffuse)
        .read_write("specular", pass.signals.specular)
        .push(ChoosePush{.frame = pass.settings, .exposure = pass.exposure});
    kernel.over_all(paths.machine.shape.slots);
}

void light_pixels(const ReusePass& pass, const LightPaths& paths) {
    light_by(pass, paths, has_layers(pass) ? "+PLAIN+LAYERS" : "", shared::kListClasses + shared::kShadePlain);
    if (has_layers(pass)) light_by(pass, paths, "+LAYERS", shared::kListClasses + shared::kShadeRest);
}

}  // namespace parhelion::passes
