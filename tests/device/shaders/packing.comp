#version 460
// Test shader: what the realtime renderer packs, unpacked again. Reads: values. Writes: unpacked (light, rgb9e5, direction of 32 bits, of
// 24 bits, log code).
#extension GL_GOOGLE_include_directive : require
#include "lib/log_code.glsl"
#include "lib/octahedral.glsl"
#include "lib/packed_light.glsl"
#include "lib/rgb9e5.glsl"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Values { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Unpacked { vec3 v[]; };
layout(push_constant, scalar) uniform Push {
    Values values;
    Unpacked unpacked;
    uint count;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const vec3 x = push.values.v[i], n = normalize(x);
    push.unpacked.v[5u * i] = unpack_light(pack_light(abs(x)));
    push.unpacked.v[5u * i + 1u] = unpack_rgb9e5(pack_rgb9e5(abs(x)));
    push.unpacked.v[5u * i + 2u] = unpack_direction(pack_direction(n));
    push.unpacked.v[5u * i + 3u] = unpack_direction_24(pack_direction_24(n));
    push.unpacked.v[5u * i + 4u] = log_values(log_code(abs(x)));
}
