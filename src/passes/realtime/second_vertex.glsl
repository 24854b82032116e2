// A path's second vertex, where other pixels may join it; and what of a path's light may go to them. For Shade with REUSE.
#ifndef PARHELION_REALTIME_SECOND_VERTEX_GLSL
#define PARHELION_REALTIME_SECOND_VERTEX_GLSL
#include "realtime/offer.glsl"
#include "scene/receiver.glsl"

const LightReuse kNoReuse = LightReuse(vec3(1.0), vec3(0.0), 0u, 0u, 0u, 0u, 0u, 0.0);

// The first surface's share of light that comes from one direction, as the path left it.
vec3 first_share(LightReuse second, vec3 diffuse_share) {
    if ((second.bits & kReuseFirst) == 0u) return vec3(0.0);
    return (second.bits & kReuseRough) != 0u ? vec3(1.0) : diffuse_share;
}

// Takes out of a path's light what may be shared: `second_share` of it by the second vertex. What is left keeps its split by the first
// surface's lobes. Gives what is taken, by these.
LightSums take_shared(inout vec3 light, inout PathClass path_class, LightReuse second, vec3 second_share) {
    const vec3 of_first = first_share(second, path_class.diffuse_share), taken = of_first * second_share * light;
    if (taken == vec3(0.0)) return LightSums(vec3(0.0), vec3(0.0));
    const vec3 diffuse = path_class.diffuse_share * second_share * light;
    const vec3 left = light - taken, diffuse_left = path_class.diffuse_share * (1.0 - second_share) * light;
    // Exactly 1 where nothing else is.
    path_class.diffuse_share = mix(clamp(diffuse_left / max(left, vec3(1e-30)), vec3(0.0), vec3(1.0)), vec3(1.0), equal(path_class.diffuse_share, vec3(1.0)));
    light = max(left, vec3(0.0));
    return LightSums(diffuse, (second.bits & kReuseRough) != 0u ? max(taken - diffuse, vec3(0.0)) : vec3(0.0));
}

// The point that the path's second vertex is, with light of some kind.
LightSampleRef sample_at_second(LightReuse second, uint kind, vec3 direction, vec3 radiance) {
    LightSampleRef y = kNoSampleRef;
    y.kind = kind;
    y.flags = kSampleSeen | ((second.bits & kReuseFront) != 0u ? kSampleFront : 0u) | ((second.bits & kReuseGlossy) != 0u ? kSampleGlossy : 0u);
    y.reference = second.instance;
    y.geometry = second.bits & 0xFFFFu;
    y.number = second.number;
    y.place = second.place;
    y.direction = direction;
    y.radiance = radiance;
    return y;
}

LightSampleRef sample_of_direction(uint kind, uint emitter, vec3 direction, vec3 radiance) {
    LightSampleRef y = kNoSampleRef;
    y.kind = kind;
    y.flags = kSampleSeen;
    y.reference = emitter;
    y.direction = direction;
    y.radiance = radiance;
    return y;
}

LightSampleRef sample_of_light(LightPick pick, vec4 u) {
    LightSampleRef y = kNoSampleRef;
    y.kind = kSampleLight;
    y.flags = kSampleSeen;
    y.reference = pick.emitter;
    y.number = pick.triangle;
    y.place = pack_place(u.xy);
    return y;
}

bool is_packable(uint geometry) { return geometry < kMostSampleGeometries; }
#endif
