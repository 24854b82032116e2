// Sort, Shade, Connect and Gather of the frame's paths.
#include <algorithm>
#include <span>
#include <string>

#include "passes/realtime/realtime.h"
#include "shared/reservoir.h"
#include "shared/scene.h"

namespace parhelion::passes {

namespace {

struct SortFirstPush {
    uint64_t view, control, lists;
    uint32_t layers;
};
struct SortPush {
    uint64_t control, lists, hits;
    uint32_t layers;
};
template <size_t kAddresses>
struct ShadePush {
    uint64_t addresses[kAddresses];  // filled in by the bindings
    shared::RealtimeFrame frame;
    uint32_t list, round;
};
struct ConnectPush {
    uint64_t view, control, shadow_list, shadow_rays, pending, sums, block, rays;
};
struct ConnectReusePush {
    ConnectPush connect;
    uint64_t offers, brings, reservoirs, offered;
    uint32_t frame_index, round, reservoir_sets;
};
struct GatherPush {
    uint64_t view, control, sums, diffuse, specular;
    float exposure;
};
struct GatherOfferedPush {
    uint64_t view, control, sums, diffuse, specular, offered;
    float exposure;
    uint32_t frame_index;
};

bool has_layers(const LightPass& pass) { return (pass.scene.features() & shared::kSceneLayers) != 0; }
uint32_t pixels(const LightPass& pass) { return pass.film.width * pass.band.row_count; }

// The addresses before the frame's settings are filled in by the bindings.
template <size_t kAddresses>
void push_shade(Pass& kernel, const LightPass& pass, uint32_t list) {
    kernel.push(ShadePush<kAddresses>{.frame = pass.settings, .list = list, .round = pass.round});
}

void shade_by(const LightPass& pass, const std::string& variant, uint32_t list) {
    const WavefrontState& machine = pass.paths.machine;
    Pass kernel = pass.frame.compute("realtime/shade", variant);
    kernel.scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read("identity", pass.gbuffer.identity)
        .read_write("control", machine.control)
        .read_write("lists", machine.lists)
        .read_write("rays", machine.rays)
        .read_write("paths", pass.paths.paths)
        .read_write("inside", pass.paths.inside)
        .read("hits", machine.hits)
        .read_write("sums", pass.paths.sums)
        .read_write("emission", pass.signals.emission)
        .read_write("block", pass.film.block)
        .write("shadow_list", machine.shadow_list)
        .write("shadow_rays", machine.shadow_rays)
        .read_write("pending", pass.paths.pending)
        .read_write("distances", pass.signals.distances)
        .read("tiles", pass.tiles);
    constexpr size_t kAddresses = 15, kOfCache = 1, kOfReuse = 5;
    // What pixels see does not end in the cache, whose update may still be under way.
    if (pass.cache != nullptr) pass.round == 0 ? kernel.untouched("cache", *pass.cache) : kernel.read_write("cache", *pass.cache);
    if (pass.reservoirs != nullptr) kernel.read_write("reservoirs", *pass.reservoirs).read_write("reuse", pass.paths.reuse).write("offers", pass.paths.offers).write("brings", pass.paths.brings).read_write("offered", pass.paths.offered);
    if (pass.cache != nullptr && pass.reservoirs != nullptr) push_shade<kAddresses + kOfCache + kOfReuse>(kernel, pass, list);
    else if (pass.reservoirs != nullptr) push_shade<kAddresses + kOfReuse>(kernel, pass, list);
    else if (pass.cache != nullptr) push_shade<kAddresses + kOfCache>(kernel, pass, list);
    else push_shade<kAddresses>(kernel, pass, list);
    kernel.over_indirect(machine.sizes, list * sizeof(shared::WavefrontSize));
}

}  // namespace

uint32_t usual_light_paths(const gpu::DeviceCaps& caps) {
    constexpr uint64_t kMost = 1u << 21, kPathBytes = 340, kShare = 16;
    return static_cast<uint32_t>(std::min(caps.memory_bytes / (kShare * kPathBytes), kMost));
}

LightPaths make_light_paths(const gpu::DevicePtr& device, uint32_t slots, const LightPathNeeds& needs) {
    const auto buffer = [&](const char* name, uint64_t count, uint64_t bytes) { return gpu::Buffer(device, std::string("realtime/") + name, count * bytes); };
    constexpr uint32_t kListPlaces = 2;  // wavefront/lists.glsl
    return {.machine = {.shape = {.slots = slots},
                        .control = buffer("control", 1, sizeof(shared::WavefrontControl)),
                        .sizes = buffer("sizes", shared::kSizeCount, sizeof(shared::WavefrontSize)),
                        .lists = buffer("lists", kListPlaces * uint64_t{slots}, sizeof(uint32_t)),
                        .rays = buffer("rays", slots, sizeof(shared::WavefrontRay)),
                        .hits = buffer("hits", slots, sizeof(shared::WavefrontHit)),
                        .shadow_rays = buffer("shadow_rays", slots, sizeof(shared::WavefrontShadowRay)),
                        .shadow_list = buffer("shadow_list", slots, sizeof(uint32_t))},
            .paths = buffer("paths", slots, sizeof(shared::LightPath)),
            .pending = buffer("pending", slots, sizeof(shared::LightPending)),
            .sums = buffer("sums", slots, sizeof(shared::LightSums)),
            .inside = buffer("inside", needs.layers ? slots : 1, sizeof(shared::LightPathInside)),
            .reuse = buffer("reuse", needs.reservoirs ? slots : 1, sizeof(shared::LightReuse)),
            .offers = buffer("offers", needs.reservoirs ? slots : 1, sizeof(shared::PackedReservoir)),
            .brings = buffer("brings", needs.reservoirs ? slots : 1, sizeof(shared::LightSums)),
            .offered = buffer("offered", needs.reservoirs ? slots : 1, sizeof(shared::LightSums))};
}

WavefrontPass LightPass::tracing() const { return {.frame = frame, .scene = scene, .way = way, .film = film, .state = paths.machine, .slots = paths.machine.shape.slots}; }

void begin_band(const LightPass& pass) {
    const WavefrontState& machine = pass.paths.machine;
    const shared::WavefrontControl control{.slice = pass.band, .pixel_count = pixels(pass), .slot_count = machine.shape.slots, .shadow_capacity = machine.shape.slots};
    pass.frame.upload(machine.control, 0, std::as_bytes(std::span(&control, 1)));
}

void sort_pixels(const LightPass& pass) {
    const WavefrontState& machine = pass.paths.machine;
    Pass kernel = pass.frame.compute("realtime/sort", "+FIRST");
    kernel.scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read("identity", pass.gbuffer.identity)
        .read_write("control", machine.control)
        .read_write("lists", machine.lists)
        .push(SortFirstPush{.layers = has_layers(pass)});
    kernel.over_all(pixels(pass));
}

void sort_paths(const LightPass& pass) {
    const WavefrontState& machine = pass.paths.machine;
    pass.frame.compute("realtime/sort")
        .scene(pass.scene.binding())
        .read_write("control", machine.control)
        .read_write("lists", machine.lists)
        .read("hits", machine.hits)
        .push(SortPush{.layers = has_layers(pass)})
        .over_indirect(machine.sizes, shared::kSizeHits * sizeof(shared::WavefrontSize));
}

void shade_paths(const LightPass& pass) {
    const std::string cache = pass.cache != nullptr ? "+CACHE" : "", layers = has_layers(pass) ? "+LAYERS" : "", reuse = pass.reservoirs != nullptr ? "+REUSE" : "";
    const bool plain_kernel = has_layers(pass) && pass.cache != nullptr;
    shade_by(pass, (plain_kernel ? "+PLAIN" : "") + layers + cache + reuse, shared::kListClasses + shared::kShadePlain);
    shade_by(pass, layers + cache + reuse, shared::kListClasses + shared::kShadeRest);
}

void connect_paths(const LightPass& pass) {
    const WavefrontState& machine = pass.paths.machine;
    const bool panes = (pass.scene.features() & shared::kScenePanes) != 0;
    Pass kernel = pass.frame.trace("realtime/connect", pass.way, std::string(panes ? "+PANES" : "") + (pass.reservoirs != nullptr ? "+REUSE" : ""));
    kernel.scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read_write("control", machine.control)
        .read("shadow_list", machine.shadow_list)
        .read("shadow_rays", machine.shadow_rays)
        .read_write("pending", pass.paths.pending)
        .read_write("sums", pass.paths.sums)
        .read_write("block", pass.film.block)
        .read_write("rays", pass.film.rays);
    if (pass.reservoirs == nullptr) kernel.push(ConnectPush{});
    else
        kernel.read("offers", pass.paths.offers)
            .read("brings", pass.paths.brings)
            .read_write("reservoirs", *pass.reservoirs)
            .read_write("offered", pass.paths.offered)
            .push(ConnectReusePush{.frame_index = pass.settings.frame_index, .round = pass.round, .reservoir_sets = pass.settings.reservoir_sets});
    kernel.over_indirect(machine.sizes, shared::kListShadows * sizeof(shared::WavefrontSize));
}

void gather_paths(const LightPass& pass) {
    Pass kernel = pass.frame.compute("realtime/gather", pass.adds ? "+ADD" : pass.keeps_offered ? "+OFFERED" : "");
    kernel.read("view", pass.film.view).read_write("control", pass.paths.machine.control).read("summary", pass.gbuffer.summary).read("sums", pass.paths.sums);
    if (pass.adds) kernel.read_write("diffuse", pass.signals.diffuse).read_write("specular", pass.signals.specular);
    else kernel.write("diffuse", pass.signals.diffuse).write("specular", pass.signals.specular);
    if (pass.keeps_offered && !pass.adds) kernel.read("offered", pass.paths.offered).push(GatherOfferedPush{.exposure = pass.settings.exposure, .frame_index = pass.settings.frame_index});
    else kernel.push(GatherPush{.exposure = pass.settings.exposure});
    kernel.over_all(pixels(pass));
}

}  // namespace parhelion::passes
