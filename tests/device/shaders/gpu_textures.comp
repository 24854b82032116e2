#version 460
// Test shader: reads the scene set (header and texture table, index not uniform) and a sampled image of set 1.
#extension GL_EXT_nonuniform_qualifier : require
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 8) in;
layout(set = 0, binding = 2, scalar) readonly buffer Header { uint offset; } header;
layout(set = 0, binding = 3) uniform sampler2D textures[];
layout(set = 1, binding = 0) uniform sampler2D own;
layout(set = 1, binding = 1, scalar) writeonly buffer Texels { vec4 v[]; } texels;
void main() {
    const uint i = gl_GlobalInvocationID.x;
    texels.v[i] = textureLod(textures[nonuniformEXT(header.offset + i)], vec2(0.5), 0.0) + textureLod(own, vec2(0.5), 1.0);
}
