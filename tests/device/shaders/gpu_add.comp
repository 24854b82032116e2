#version 460
// Test shader: adds a number to values behind an address, writes buffer and storage image.
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 64) in;
layout(buffer_reference, scalar) readonly buffer Values { uint v[]; };
layout(set = 1, binding = 0, scalar) writeonly buffer Sums { uint v[]; } sums;
layout(set = 1, binding = 1, rgba32f) uniform writeonly image2D picture;
layout(push_constant, scalar) uniform Push { Values values; uint count; uint add; };
void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= count) return;
    sums.v[i] = values.v[i] + add;
    imageStore(picture, ivec2(i % 16, i / 16), vec4(i, add, 0, 1));
}
