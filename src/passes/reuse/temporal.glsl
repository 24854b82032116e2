// A pixel's new reservoir and the one that its surface had in the last frame become one. Whoever includes it says what is hidden:
//     bool is_seen(ViewData view, Shifted shifted, uint moment)
// Reads: scene, view, identity, identity_before, motion, history. Reads and writes: reservoirs (its own).
#ifndef PARHELION_REUSE_TEMPORAL_GLSL
#define PARHELION_REUSE_TEMPORAL_GLSL
#include "reuse/reservoirs.glsl"
#include "scene/motion.glsl"

layout(set = 1, binding = 0, rgba32ui) uniform readonly uimage2D identity;
layout(set = 1, binding = 1, rgba32ui) uniform readonly uimage2D identity_before;
layout(set = 1, binding = 2, rg32f) uniform readonly image2D motion;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer History { PackedReservoir v[]; };
layout(push_constant, scalar) uniform Push {
    ViewBlock view;
    Reservoirs reservoirs;
    History history;
    ReuseFrame frame;
} push;

bool is_seen(ViewData view, Shifted shifted, uint moment);

// Rows of the last frame's instances and emitters become this one's; what is gone brings nothing.
void translate(inout Reservoir r) {
    const uint kind = r.point.kind;
    if (kind == kSampleNone) return;
    if (kind == kSampleLight || kind == kSampleSky) r.point.reference = emitter_now(r.point.reference);
    else if (kind != kSampleOutside) r.point.reference = instance_now(r.point.reference);
    if (kind != kSampleOutside && r.point.reference == kNone) {
        r.point = kNoSampleRef;
        r.weight = r.target = 0.0;
    }
}

// The pixel that saw the surface in the last frame, or one near it: near ones are exchanged, in another way each frame, so that what is repeated
// does not stay in place (Wyman and Panteleev 2021, section 4). False: there is none.
bool find_before(ViewData view, uvec2 id, out ivec2 before) {
    const vec2 moved = imageLoad(motion, ivec2(id)).xy;
    before = ivec2(0);
    if (any(isinf(moved))) return false;
    before = ivec2(floor(vec2(id) + 0.5 + moved + (view.jitter - view.jitter_before)));
    const ivec2 size = ivec2(view.width, view.height), offset = ivec2(push.frame.permutation & 3u, push.frame.permutation >> 2 & 3u);
    if (any(lessThan(before, ivec2(0))) || any(greaterThanEqual(before, size))) return false;
    const ivec2 exchanged = ((before + offset) ^ 3) - offset;
    if (push.frame.permutation != 0xFFFFFFFFu && all(greaterThanEqual(exchanged, ivec2(0))) && all(lessThan(exchanged, size))) before = exchanged;
    return true;
}

// What the last frame knew of the surface; false: nothing. `before`: the pixel that did.
bool recall(ViewData view, uvec2 id, out ivec2 before, out uvec4 which, out Reservoir history) {
    history = kEmptyReservoir;
    which = uvec4(kHitMiss);
    before = ivec2(0);
    if (push.frame.reset != 0u || !find_before(view, id, before)) return false;
    which = imageLoad(identity_before, before);
    if (which.x == kHitMiss || instance_now(which.x & kHitInstanceMask) == kNone) return false;
    history = unpack_reservoir(push.history.v[reservoir_at(view, push.frame, uvec2(before))]);
    history.confidence = min(history.confidence, push.frame.most_confidence);
    history.point.flags &= ~kSampleSeen;
    translate(history);
    return true;
}

// One loop, so that what is long is compiled once: the pixel's own sample, what the last frame knew here, and the own sample there.
const uint kOwnHere = 0u, kOtherHere = 1u, kOwnThere = 2u;

void reuse_before(uvec2 id) {
    const ViewData view = push.view.data;
    if (id.x >= view.width || id.y >= view.height) return;
    uvec4 which = imageLoad(identity, ivec2(id)), which_before;
    if (which.x == kHitMiss) return;
    const uint at = reservoir_at(view, push.frame, id), ray_key = reuse_ray_key(view, id, push.frame, 0u);
    Reservoir own = unpack_reservoir(push.reservoirs.v[at]), history;
    ivec2 before;
    const bool recalls = recall(view, id, before, which_before, history);
    Receiver receiver;
    vec3 n_ws, stood_ws;
    float targets[3] = float[](0.0, 0.0, 0.0);
    bool same = recalls;
    for (uint i = kOwnHere; i <= (same ? kOwnThere : kOwnHere); ++i) {
        const uint moment = i == kOwnThere ? kBefore : kNow;
        if (i != kOtherHere)
            receiver = receiver_at(view, i == kOwnHere ? key_of(view, id, push.frame.frame_index) : key_of(view, uvec2(before), push.frame.frame_index - 1u), i == kOwnHere ? which : which_before,
                                   bsdf_share(push.frame), moment);
        if (i == kOwnHere) {
            vec3 stands_ws;
            find_moments(receiver.shading.s, stands_ws, stood_ws);
            n_ws = receiver.shading.n_geometric_ws;
        }
        if (i == kOwnThere) same = are_similar(n_ws, receiver.shading.n_geometric_ws, stood_ws, receiver.shading.s.position_ws, receiver.shading.s.t);
        const Shifted shifted = shift(view, i == kOtherHere ? history.point : own.point, receiver, moment, ray_key);
        targets[i] = i == kOwnHere || is_seen(view, shifted, moment) ? target_of(shifted) : 0.0;
    }
    // The weights of what the frame's path offered have been added up; now the reservoir gets its W.
    own.target = targets[kOwnHere];
    own.weight = own.target > 0.0 ? own.weight / own.target : 0.0;
    if (own.target <= 0.0) own.point.kind = kSampleNone;
    if (same) merge_reservoirs(own, history, targets[kOtherHere], targets[kOwnThere], reuse_numbers(view, id, push.frame, 0u).x);
    store_reservoir(push.reservoirs, at, own);
}
#endif
