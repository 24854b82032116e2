#version 460
// Frame tests: image blur by one texel to the right, one image to another. Reads: source. Writes: target.
#extension GL_GOOGLE_include_directive : require
#include "shared/types.h"
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, r32f) uniform readonly image2D source;
layout(set = 1, binding = 1, r32f) uniform writeonly image2D target;
layout(push_constant, scalar) uniform Push { uvec2 size; float gain; } push;
void main() {
    const ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(p), push.size))) return;
    const float left = imageLoad(source, ivec2(max(p.x - 1, 0), p.y)).x;
    imageStore(target, p, vec4((left + imageLoad(source, p).x) * push.gain + 1.0));
}
