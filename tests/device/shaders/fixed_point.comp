#version 460
// Test shader: exact sums of pairs of floats. Reads: pairs. Writes: sums (a, b, a + b as three limbs each).
#extension GL_GOOGLE_include_directive : require
#include "lib/fixed_point.glsl"
#include "shared/types.h"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Pairs { uvec2 v[]; };  // bits of floats
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Sums { uvec3 v[]; };
layout(push_constant, scalar) uniform Push {
    Pairs pairs;
    Sums sums;
    uint count;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const vec2 pair = uintBitsToFloat(push.pairs.v[i]);
    const uvec3 a = fixed_from_float(pair.x), b = fixed_from_float(pair.y);
    push.sums.v[3u * i] = a;
    push.sums.v[3u * i + 1u] = b;
    push.sums.v[3u * i + 2u] = fixed_add(a, b);
}
