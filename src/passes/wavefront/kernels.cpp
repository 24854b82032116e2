// Generate, Extend, Sort, Shade, Connect, Finalize and Deposit.
#include <algorithm>
#include <string>

#include "passes/wavefront/wavefront.h"
#include "shared/scene.h"

namespace parhelion::passes {

namespace {

struct GeneratePush {
    uint64_t view, control, lists, rays, paths, extras, slots, status;
};
struct WavefrontExtendPush {
    uint64_t control, lists, rays, hits;
};
struct WavefrontSortPush {
    uint64_t control, lists, hits;
    uint32_t only_plain;
};
struct WavefrontShadePush {
    uint64_t view, control, lists, shadow_list, rays, hits, paths, extras, slots, status, vertices, shadow_rays, splits, firsts;
    uint32_t has_firsts, list, round, round_length;
};
struct WavefrontConnectPush {
    uint64_t control, shadow_list, shadow_rays, vertices, splits;
};
struct ConnectPanesPush {
    uint64_t view, control, shadow_list, shadow_rays, vertices, splits, rays;
};
struct FinalizePush {
    uint64_t control, slots, vertices, splits, class_sums, samples, sample_classes;
    uint32_t round_length;
};

struct DepositPush {
    uint64_t view, block, control, samples, firsts, sample_classes;
    uint32_t has_firsts;
};

bool has_layers(const WavefrontPass& pass) { return (pass.scene.features() & shared::kSceneLayers) != 0; }
std::string variant(const WavefrontPass& pass) {
    return std::string(has_layers(pass) ? "+LAYERS" : "") + (pass.ray_cones ? "+RAY_CONES" : "");
}

struct Class {
    uint32_t number;
    const char* define;
    uint32_t feature;  // without which no material of the scene is of this class; 0: it always may be
    bool textures;
};
constexpr Class kClasses[] = {{shared::kClassPlain, "+PLAIN", 0, true},
                              {shared::kClassCoated, "+COATED", shared::kSceneCoats, true},
                              {shared::kClassTransmissive, "+TRANSMISSIVE", shared::kSceneTransmits, true},
                              {shared::kClassEmitter, "+EMITTER", shared::kSceneEmitters, true},
                              {shared::kClassMiss, "+MISS", 0, false}};
bool exists(const WavefrontPass& pass, const Class& c) { return c.feature == 0 || (pass.scene.features() & c.feature) != 0; }

// Over the entries of a list, or over all that it can have.
void over(const WavefrontPass& pass, Pass& kernel, uint32_t size, uint64_t most) {
    if (pass.state.shape.indirect) return kernel.over_indirect(pass.state.sizes, size * sizeof(shared::WavefrontSize));
    kernel.over_all(most);
}

void shade_class(const WavefrontPass& pass, const std::string& defines, uint32_t list, uint32_t size) {
    const WavefrontState& state = pass.state;
    Pass kernel = pass.frame.compute("wavefront/shade", defines);
    kernel.scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read_write("control", state.control)
        .read_write("lists", state.lists)
        .write("shadow_list", state.shadow_list)
        .read_write("rays", state.rays)
        .read("hits", state.hits)
        .read_write("paths", state.paths)
        .read_write("extras", state.extras)
        .read_write("slots", state.slots)
        .read_write("status", state.status)
        .read_write("vertices", state.vertices)
        .write("shadow_rays", state.shadow_rays)
        .read_write("splits", state.splits)
        .read_write("firsts", state.firsts)
        .push(WavefrontShadePush{.has_firsts = state.shape.firsts, .list = list, .round = pass.round, .round_length = state.shape.round_length});
    over(pass, kernel, size, pass.slots);
}

// What both kernels of Connect work on, and how many rays that may be.
Pass& bind_shadow_rays(const WavefrontPass& pass, Pass& kernel) {
    return kernel.scene(pass.scene.binding())
        .read("control", pass.state.control)
        .read("shadow_list", pass.state.shadow_list)
        .read("shadow_rays", pass.state.shadow_rays)
        .read_write("vertices", pass.state.vertices)
        .read_write("splits", pass.state.splits);
}
void over_shadow_rays(const WavefrontPass& pass, Pass& kernel) {
    over(pass, kernel, shared::kListShadows, uint64_t{pass.slots} * pass.state.shape.round_length);
}

}  // namespace

void generate(const WavefrontPass& pass) {
    const WavefrontState& state = pass.state;
    pass.frame.compute("wavefront/generate", variant(pass))
        .scene(pass.scene.binding())
        .read("view", pass.film.view)
        .read_write("control", state.control)
        .read_write("lists", state.lists)
        .read_write("rays", state.rays)
        .read_write("paths", state.paths)
        .read_write("extras", state.extras)
        .read_write("slots", state.slots)
        .read_write("status", state.status)
        .push(GeneratePush{})
        .over(pass.slots);
}

void extend(const WavefrontPass& pass) {
    const WavefrontState& state = pass.state;
    Pass kernel = pass.frame.trace("wavefront/extend", pass.way);
    kernel.scene(pass.scene.binding())
        .read("control", state.control)
        .read("lists", state.lists)
        .read("rays", state.rays)
        .write("hits", state.hits)
        .push(WavefrontExtendPush{});
    over(pass, kernel, shared::kListRays, pass.slots);
}

void sort_hits(const WavefrontPass& pass) {
    const bool only_plain = (pass.scene.features() & (shared::kSceneCoats | shared::kSceneTransmits | shared::kSceneEmitters)) == 0;
    Pass kernel = pass.frame.compute("wavefront/sort");
    kernel.scene(pass.scene.binding())
        .read_write("control", pass.state.control)
        .read_write("lists", pass.state.lists)
        .read("hits", pass.state.hits)
        .push(WavefrontSortPush{.only_plain = only_plain});
    over(pass, kernel, shared::kSizeHits, pass.slots);
}

void shade(const WavefrontPass& pass) {
    if (!pass.state.shape.classes) return shade_class(pass, variant(pass), shared::kListRays, shared::kSizeHits);
    for (const Class& c : kClasses) {
        if (!exists(pass, c)) continue;
        const std::string define = std::string(c.define) + (has_layers(pass) ? "+LAYERS" : "") + (pass.ray_cones && c.textures ? "+RAY_CONES" : "");
        shade_class(pass, define, shared::kListClasses + c.number, shared::kListClasses + c.number);
    }
}

void connect(const WavefrontPass& pass) {
    const bool panes = (pass.scene.features() & shared::kScenePanes) != 0;
    Pass kernel = pass.frame.trace("wavefront/connect", pass.way, panes ? "+PANES" : "");
    bind_shadow_rays(pass, kernel).push(WavefrontConnectPush{});
    over_shadow_rays(pass, kernel);
    if (!panes) return;
    Pass through = pass.frame.trace("wavefront/connect_panes", pass.way);
    bind_shadow_rays(pass, through).read("view", pass.film.view).read_write("rays", pass.film.rays).push(ConnectPanesPush{});
    over_shadow_rays(pass, through);
}

void finalize(const WavefrontPass& pass) {
    const WavefrontState& state = pass.state;
    pass.frame.compute("wavefront/finalize")
        .read_write("control", state.control)
        .read_write("slots", state.slots)
        .read_write("vertices", state.vertices)
        .read_write("splits", state.splits)
        .read_write("class_sums", state.class_sums)
        .read_write("samples", state.samples)
        .read_write("sample_classes", state.sample_classes)
        .push(FinalizePush{.round_length = state.shape.round_length})
        .over(pass.slots);
}

void deposit(Frame& frame, const WavefrontState& state, const Film& film, uint32_t pixels) {
    frame.compute("wavefront/deposit")
        .read("view", film.view)
        .read_write("block", film.block)
        .read_write("control", state.control)
        .read_write("samples", state.samples)
        .read_write("firsts", state.firsts)
        .read_write("sample_classes", state.sample_classes)
        .push(DepositPush{.has_firsts = state.shape.firsts})
        .over_all(pixels);
}

}  // namespace parhelion::passes
