#version 460
// Test shader: what the realtime renderer packs, unpacked again. Reads: values. Writes: unpacked (light, rgb9e5, direction of 32 bits, of
// 24 bits, log code, rgbe8, that packed once more).
#extension GL_GOOGLE_include_directive : require
#include "lib/log_code.glsl"
#include "lib/octahedral.glsl"
#include "lib/packed_light.glsl"
#include "lib/hash.glsl"
#include "lib/rgb9e5.glsl"
#include "lib/rgbe8.glsl"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Values { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Unpacked { vec3 v[]; };
layout(push_constant, scalar) uniform Push {
    Values values;
    Unpacked unpacked;
    uint count;
} push;

const uint kForms = 7u;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const vec3 x = push.values.v[i], n = normalize(x);
    push.unpacked.v[kForms * i] = unpack_light(pack_light(abs(x)));
    push.unpacked.v[kForms * i + 1u] = unpack_rgb9e5(pack_rgb9e5(abs(x)));
    push.unpacked.v[kForms * i + 2u] = unpack_direction(pack_direction(n));
    push.unpacked.v[kForms * i + 3u] = unpack_direction_24(pack_direction_24(n));
    push.unpacked.v[kForms * i + 4u] = log_values(log_code(abs(x)));
    const vec3 short_light = unpack_rgbe8(pack_rgbe8(abs(x), pcg4d(uvec4(i)).xyz));
    push.unpacked.v[kForms * i + 5u] = short_light;
    push.unpacked.v[kForms * i + 6u] = unpack_rgbe8(pack_rgbe8(short_light, uvec3(~0u)));
}
