#version 460
// Block texture test: every texel of one level of an image. Samples: picture. Writes: texels.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0) uniform sampler2D picture;
layout(set = 1, binding = 1, scalar) writeonly buffer Texels { vec4 v[]; } texels;
layout(push_constant, scalar) uniform Push { uint width; uint height; int level; } push;
void main() {
    const uvec2 p = gl_GlobalInvocationID.xy;
    if (p.x >= push.width || p.y >= push.height) return;
    texels.v[p.y * push.width + p.x] = texelFetch(picture, ivec2(p), push.level);
}
