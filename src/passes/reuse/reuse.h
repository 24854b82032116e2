#pragma once
// Reuse of samples between pixels and frames: passes over a view's reservoirs (shared/reservoir.h), after its paths have offered theirs.
#include "passes/realtime/realtime.h"
#include "shared/reservoir.h"

namespace parhelion::passes {

// A set's pixels follow those of the set before it.
struct ReuseState {
    gpu::Buffer reservoirs;  // PackedReservoir[sets * pixels]: what this frame's paths offer; after temporal reuse what the next frame starts from
    gpu::Buffer before;      // the same: what the last frame left
    gpu::Buffer told;        // uint[sets * neighbours / 2 * pixels]: what partners' samples bring (reuse/partner.glsl)
    gpu::Image identity_before;               // GBuffer's of the last frame, for exact reuse,
    gpu::Image summary_before, depth_before;  // and for the other
};
ReuseState make_reuse_state(const gpu::DevicePtr& device, gpu::Extent extent, uint32_t sets, uint32_t neighbours, bool exact);
// A new frame: what reservoirs and G-buffer hold becomes the last frame's.
void keep_last_frame(ReuseState& state, GBuffer& gbuffer);

struct ReusePass {
    Frame& frame;
    const SceneGpu& scene;
    gpu::TraceWay way;
    const Film& film;
    const GBuffer& gbuffer;
    const Signals& signals;   // with what the paths were offered, if settings.keeps_offered; choose_samples adds what is left of that
    const ReuseState& state;
    bool exact;  // samples are weighed by what they bring, and by two rays each time; else by about that
    shared::ReuseFrame settings;
    float exposure = 1;
};

void reuse_before(const ReusePass& pass);  // temporal
void show_duplicates(const ReusePass& pass);  // of what the next frame starts from: the layer debug.duplicates
void tell_partners(const ReusePass& pass);  // spatial: what pixels around must know
// What a band's pixels make of it: lists of those that are to be lit, and ChosenSample[slots] in the place of the paths' offers.
void choose_samples(const ReusePass& pass, const LightPaths& paths);
// Their shadow rays and what these bring, for connect_paths and gather_paths of a LightPass that adds. A kernel for plain materials, and one for the rest.
void light_pixels(const ReusePass& pass, const LightPaths& paths);

}  // namespace parhelion::passes
