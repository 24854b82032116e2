#version 460
// Triangles of one colour each, read by address. Reads: corners. Writes: what the fragment shader asks for.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_scalar_block_layout : require

struct Corner {
    vec3 position;  // x, y in [-1, 1], y down; depth
    vec4 color;
};
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Corners { Corner v[]; };
layout(push_constant, scalar) uniform Push {
    Corners corners;
    uint gain;
} push;

layout(location = 0) flat out vec4 color;
layout(location = 1) flat out uint row;

void main() {
    const Corner corner = push.corners.v[gl_VertexIndex];
    color = corner.color * float(push.gain);
    row = gl_InstanceIndex;
    gl_Position = vec4(corner.position, 1.0);
}
