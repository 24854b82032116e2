#version 460
// Sampler tests: draws from an alias table. Reads: rows. Writes: drawn, an index an invocation.
#extension GL_GOOGLE_include_directive : require
#include "lib/alias.glsl"
#include "lib/hash.glsl"
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Drawn { uint v[]; };
layout(push_constant, scalar) uniform Push {
    AliasRows rows;
    Drawn drawn;
    uint row_count, count;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const uvec4 random = pcg4d(uvec4(i, 4u, 5u, 6u));
    push.drawn.v[i] = sample_alias(uint64_t(push.rows), push.row_count, vec2(uint_to_unit_float(random.x), uint_to_unit_float(random.y)));
}
