// Reservoirs unpacked, and how two become one.
#ifndef PARHELION_LIB_RESERVOIR_GLSL
#define PARHELION_LIB_RESERVOIR_GLSL
#include "lib/hash.glsl"
#include "lib/octahedral.glsl"
#include "lib/rgbe8.glsl"
#include "shared/reservoir.h"

struct LightSampleRef {
    uint kind, flags;
    uint reference, geometry, number, place;
    vec3 direction;  // of directions, and of reconnections where the light at the point comes from
    vec3 radiance;
};
const LightSampleRef kNoSampleRef = LightSampleRef(kSampleNone, 0u, 0u, 0u, 0u, 0u, vec3(0.0), vec3(0.0));

struct Reservoir {
    LightSampleRef point;
    uint confidence;
    float weight;
    float target;
};
const Reservoir kEmptyReservoir = Reservoir(kNoSampleRef, 0u, 0.0, 0.0);

bool is_direction(uint kind) { return kind == kSampleSky || kind == kSampleOutside; }
bool is_indirect(uint kind) { return kind == kSampleReconnection || kind == kSampleRadiosity; }
bool is_point(uint kind) { return kind == kSampleEmitter || is_indirect(kind); }  // of a triangle

PackedSample pack_sample(LightSampleRef s, uint confidence) {
    PackedSample p;
    p.reference = s.reference;
    p.number = s.number;
    p.place = s.place;
    if (is_direction(s.kind)) {
        const vec2 square = octahedral_square(s.direction);
        p.number = floatBitsToUint(square.x);
        p.place = floatBitsToUint(square.y);
    }
    p.bits = s.geometry | min(confidence, kMostConfidence) << 16 | s.kind << 24 | s.flags << 27;
    p.direction = s.kind == kSampleReconnection ? pack_direction(s.direction) : 0u;
    p.radiance = pack_rgbe8(s.radiance, pcg4d(uvec4(p.place, p.number, p.direction, 0x52474238u)).xyz);  // every sample has a place of its own
    return p;
}
LightSampleRef unpack_sample(PackedSample p) {
    LightSampleRef s;
    s.kind = p.bits >> 24 & 7u;
    s.flags = p.bits >> 27 & 7u;
    s.reference = p.reference;
    s.geometry = p.bits & 0xFFFFu;
    s.number = p.number;
    s.place = p.place;
    s.direction = is_direction(s.kind) ? octahedral_direction(vec2(uintBitsToFloat(p.number), uintBitsToFloat(p.place))) : unpack_direction(p.direction);
    s.radiance = unpack_rgbe8(p.radiance);
    return s;
}
uint packed_confidence(PackedSample p) { return p.bits >> 16 & 0xFFu; }

// Word by word into a buffer: whole structs through an address are more than compilers take.
#define STORE_SAMPLE(to, from) \
    to.reference = from.reference; \
    to.number = from.number; \
    to.place = from.place; \
    to.bits = from.bits; \
    to.direction = from.direction; \
    to.radiance = from.radiance;

// Of a picture of so many pixels, whose second set follows the first one.
uint reservoir_at(uint pixels, uint set, uint pixel) { return set * pixels + pixel; }

PackedReservoir pack_reservoir(Reservoir r) { return PackedReservoir(pack_sample(r.point, r.confidence), r.weight, r.target); }
Reservoir unpack_reservoir(PackedReservoir p) { return Reservoir(unpack_sample(p.point), packed_confidence(p.point), p.weight, p.target); }

// Two numbers of [0, 1) in 16 bits each, at the middle of their steps; and a number as it comes back.
uint pack_place(vec2 u) {
    const uvec2 steps = uvec2(clamp(u, vec2(0.0), vec2(0.9999)) * 65536.0);
    return steps.x | steps.y << 16;
}
vec2 unpack_place(uint place) { return (vec2(place & 0xFFFFu, place >> 16) + 0.5) / 65536.0; }
// Weights of a triangle's second and third corner: never outside of it.
vec2 unpack_barycentrics(uint place) {
    const vec2 b = unpack_place(place);
    return b / max(1.0, b.x + b.y);
}

// The balance heuristic between two reservoirs, each as often as its confidence says: share of `own`, whose target is the sample's where it
// comes from, against what the sample would be for the other one. Both in one measure. Lin et al. 2022, section 5.6.
float reservoir_share(float own_confidence, float own_target, float other_confidence, float other_target) {
    const float own = own_confidence * own_target, other = other_confidence * other_target;
    return own > 0.0 ? 1.0 / (1.0 + other / own) : 0.0;
}

// What `own` becomes when it is offered the sample of `other`, whose target at own's surface is `other_here`; `own_there` is the target of
// own's sample at the other's surface. Says whether the other's sample is kept. u in [0, 1).
bool merge_reservoirs(inout Reservoir own, Reservoir other, float other_here, float own_there, float u) {
    const float own_weight = reservoir_share(float(own.confidence), own.target, float(other.confidence), own_there) * own.target * own.weight;
    const float other_weight = reservoir_share(float(other.confidence), other.target, float(own.confidence), other_here) * other_here * other.weight;
    const float sum = own_weight + other_weight;
    own.confidence = min(own.confidence + other.confidence, kMostConfidence);
    const bool takes = other_weight > 0.0 && u * sum < other_weight;
    if (takes) {
        own.point = other.point;
        own.target = other_here;
    }
    own.weight = own.target > 0.0 ? sum / own.target : 0.0;
    return takes;
}

// Several reservoirs that `own` is offered, each held against it alone (pairwise MIS: Bitterli 2022, "Correlations and Reuse for Fast and Accurate Physically
// Based Light Transport", section 9.1): neither is asked what a third one's sample would bring. `around`: the sum of their confidences.
struct Offered {
    LightSampleRef point;
    float target, sum;  // of the sample kept, at own's surface; of all weights
    float own_share;    // what is left of own's sample
};
const Offered kNothingOffered = Offered(kNoSampleRef, 0.0, 0.0, 0.0);
// Says whether the sample is kept of those offered.
bool offer_reservoir(inout Offered offered, Reservoir own, Reservoir other, float around, float other_here, float own_there, float u) {
    const float part = float(other.confidence) / around;
    offered.own_share += part * reservoir_share(float(own.confidence), own.target, around, own_there);
    const float weight = part * reservoir_share(around, other.target, float(own.confidence), other_here) * other_here * other.weight;
    offered.sum += weight;
    const bool keeps = weight > 0.0 && u * offered.sum < weight;
    if (keeps) {
        offered.point = other.point;
        offered.target = other_here;
    }
    return keeps;
}
// Says whether it is kept.
bool take_offered(inout Reservoir own, Offered offered, float u) {
    const float sum = offered.own_share * own.target * own.weight + offered.sum;
    const bool takes = offered.sum > 0.0 && u * sum < offered.sum;
    if (takes) {
        own.point = offered.point;
        own.target = offered.target;
    }
    own.weight = own.target > 0.0 ? sum / own.target : 0.0;
    return takes;
}
#endif
