#version 460
// Two pictures side by side: one to the left of a line, the other to its right. Either may be coarser than what it is shown in.
// Reads: left, right. Writes: ldr.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rgba8) uniform readonly image2D left;
layout(set = 1, binding = 1, rgba8) uniform readonly image2D right;
layout(set = 1, binding = 2, rgba8) uniform writeonly image2D ldr;
layout(push_constant, scalar) uniform Push {
    uint width, height;
    uint line;  // its column
} push;

void main() {
    const uvec2 p = gl_GlobalInvocationID.xy, size = uvec2(push.width, push.height);
    if (p.x >= push.width || p.y >= push.height) return;
    vec4 shown = vec4(1.0);
    if (p.x < push.line) shown = imageLoad(left, ivec2(p * uvec2(imageSize(left)) / size));
    else if (p.x > push.line) shown = imageLoad(right, ivec2(p * uvec2(imageSize(right)) / size));
    imageStore(ldr, ivec2(p), shown);
}
