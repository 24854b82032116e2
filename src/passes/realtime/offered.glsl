// What a path was offered, beside what it brought by itself: while reservoirs wait for each other a signal holds both, 32 bits each.
#ifndef PARHELION_REALTIME_OFFERED_GLSL
#define PARHELION_REALTIME_OFFERED_GLSL
#include "lib/hash.glsl"
#include "lib/packed_light.glsl"
#include "lib/rgbe8.glsl"

PackedLight pack_with_offered(vec3 own, vec3 offered, uvec4 random) { return PackedLight(pack_rgbe8(own, random.xyz), pack_rgbe8(offered, random.yzw)); }
vec3 own_light(PackedLight p) { return unpack_rgbe8(p.low); }
vec3 offered_light(PackedLight p) { return unpack_rgbe8(p.high); }
#endif
