#version 460
// The film's mean so far as an image: exact sums plus the running block, over the count. For display; files are resolved on
// the host. Reads: sums, block (the first three channels). Writes: hdr (nits).
#extension GL_GOOGLE_include_directive : require
#include "lib/fixed_point.glsl"
#include "shared/types.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FilmBlock { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer FilmSums { uint v[]; };
layout(set = 1, binding = 0, rgba32f) uniform writeonly image2D hdr;
layout(push_constant, scalar) uniform Push {
    FilmBlock block;
    FilmSums sums;
    uint width, height;
    float inv_count;
} push;

void main() {
    const uvec2 p = gl_GlobalInvocationID.xy;
    if (p.x >= push.width || p.y >= push.height) return;
    const uint plane = push.width * push.height, pixel = p.y * push.width + p.x;
    vec3 mean;
    for (uint c = 0u; c < 3u; ++c) {
        const uint low = 3u * c * plane + pixel;
        const float sum = float_from_fixed(uvec3(push.sums.v[low], push.sums.v[low + plane], push.sums.v[low + 2u * plane]));
        mean[c] = (sum + push.block.v[c * plane + pixel]) * push.inv_count;
    }
    imageStore(hdr, ivec2(p), vec4(mean, 1.0));
}
