#version 460
// Display values from radiance: exposure, tone curve, sRGB transfer. Reads: hdr (nits). Writes: ldr.
#extension GL_GOOGLE_include_directive : require
#include "lib/tonemap.glsl"
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 1, binding = 0, rgba32f) uniform readonly image2D hdr;
layout(set = 1, binding = 1, rgba8) uniform writeonly image2D ldr;
layout(push_constant, scalar) uniform Push {
    uint width, height;
    float exposure_scale;
    uint curve;  // 0 linear, 1 ACES, 2 AgX
} push;

void main() {
    const uvec2 p = gl_GlobalInvocationID.xy;
    if (p.x >= push.width || p.y >= push.height) return;
    const vec3 exposed = imageLoad(hdr, ivec2(p)).rgb * push.exposure_scale;
    imageStore(ldr, ivec2(p), vec4(tonemap_to_srgb(exposed, push.curve), 1.0));
}
