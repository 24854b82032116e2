#version 460
// Makes a list of draws of one triangle each, for indirect draws. Reads: nothing. Writes: draws, count.
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 32) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Draws { uvec4 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Count { uint v; };
layout(push_constant, scalar) uniform Push {
    Draws draws;
    Count count;
    uint drawn, room;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i == 0u) push.count.v = push.drawn;
    if (i < push.room) push.draws.v[i] = i < push.drawn ? uvec4(3u, 1u, 3u * i, 10u + i) : uvec4(0u);
}
