#include "passes/wavefront/replay.h"

#include <algorithm>

namespace parhelion::passes {

namespace {

struct DumpPush {
    uint64_t control, dump, lists_or_shadow_list, rays_or_shadow_rays;
    uint32_t list;
};
struct WavefrontReplayPush {
    uint64_t control, dump, hits;
    uint32_t list;
};

uint32_t list_of(WavefrontTraced what) { return what == WavefrontTraced::Rays ? shared::kListRays : shared::kListShadows; }
const char* defines(WavefrontTraced what) { return what == WavefrontTraced::Rays ? "" : "+SHADOWS"; }

}  // namespace

uint64_t most_rays(const WavefrontShape& shape, WavefrontTraced what) { return uint64_t{shape.slots} * (what == WavefrontTraced::Rays ? 1 : shape.round_length); }

void dump_rays(const WavefrontPass& pass, WavefrontTraced what, const gpu::Buffer& dump) {
    const WavefrontState& state = pass.state;
    Pass kernel = pass.frame.compute("wavefront/dump_rays", defines(what));
    kernel.read_write("control", state.control).write("dump", dump).push(DumpPush{.list = list_of(what)});
    if (what == WavefrontTraced::Rays) kernel.read_write("lists", state.lists).read_write("rays", state.rays);
    else kernel.read("shadow_list", state.shadow_list).read("shadow_rays", state.shadow_rays);
    kernel.over_all(most_rays(state.shape, what));
}

void replay_rays(const WavefrontPass& pass, WavefrontTraced what, const gpu::Buffer& dump, const gpu::Buffer& hits) {
    Pass kernel = pass.frame.trace("wavefront/replay_rays", pass.way, defines(what));
    kernel.scene(pass.scene.binding())
        .read("control", pass.state.control)
        .read("dump", dump)
        .write("hits", hits)
        .push(WavefrontReplayPush{.list = list_of(what)});
    if (pass.state.shape.indirect) kernel.over_indirect(pass.state.sizes, list_of(what) * sizeof(shared::WavefrontSize));
    else kernel.over_all(most_rays(pass.state.shape, what));
}

}  // namespace parhelion::passes
