// What both kinds of temporal reuse know of the last frame. A pass that includes it declares its push constants first, with `view`, `history`
// and `frame`.
#ifndef PARHELION_REUSE_BEFORE_GLSL
#define PARHELION_REUSE_BEFORE_GLSL
#include "reuse/reservoirs.glsl"

// Whether the last frame could not have found the sample: its light was elsewhere, or did not shine. Of what lights points, and of suns that paths meet,
// nothing is known but whether anything at all has changed, or did some frames ago. Such samples are no part of the last frame's domain, on either side of a merge.
bool is_new(LightSampleRef y) {
    if (is_indirect(y.kind) || y.kind == kSampleOutside) return push.frame.changed != 0u;
    return shone(y, kBefore) <= 0.0;
}

// Rows of the last frame's instances and emitters become this one's, and light is as bright as it is now; what is gone or new brings nothing.
void translate(inout Reservoir r) {
    const uint kind = r.point.kind;
    if (kind == kSampleNone) return;
    if (kind == kSampleLight || kind == kSampleSky) r.point.reference = emitter_now(r.point.reference);
    else if (kind != kSampleOutside) r.point.reference = instance_now(r.point.reference);
    if ((kind != kSampleOutside && r.point.reference == kNone) || is_new(r.point)) {
        r.point = kNoSampleRef;
        r.weight = r.target = 0.0;
    } else if (kind == kSampleEmitter) r.point.radiance /= shone(r.point, kBefore);
}

// The pixel that saw the surface in the last frame, or one near it: near ones are exchanged, in another way each frame, so that what is repeated
// does not stay in place (Wyman and Panteleev 2021, section 4). False: there is none.
bool find_before(ViewData view, uvec2 id, vec2 moved, out ivec2 before) {
    before = ivec2(0);
    if (push.frame.reset != 0u || any(isinf(moved))) return false;
    before = ivec2(floor(vec2(id) + 0.5 + moved + (view.jitter - view.jitter_before)));
    const uint shift = pcg_hash(push.frame.frame_index);
    const ivec2 size = ivec2(view.width, view.height), offset = ivec2(uvec2(shift, shift >> 2) & 3u);
    if (any(lessThan(before, ivec2(0))) || any(greaterThanEqual(before, size))) return false;
    const ivec2 exchanged = ((before + offset) ^ 3) - offset;
    if (push.frame.permutation != 0u && all(greaterThanEqual(exchanged, ivec2(0))) && all(lessThan(exchanged, size))) before = exchanged;
    return true;
}

// What a pixel of the last frame knew.
Reservoir recall(ViewData view, ivec2 before) {
    Reservoir history = unpack_reservoir(push.history.v[reservoir_of(view, push.frame, uvec2(before))]);
    history.confidence = min(history.confidence, push.frame.most_confidence);
    history.point.flags &= ~kSampleSeen;
    translate(history);
    return history;
}
#endif
