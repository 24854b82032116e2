#version 460
// The film's mean so far as an image: exact sums plus the running block, over the count. For display; files are resolved on
// the host. Reads: sums, block (three channels, or one). Writes: hdr (of the beauty nits).
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
    uint rows_ahead;  // the first rows, which hold another number of samples
    uint first_channel, channel_count;
    float gain, gain_ahead, bias;
} push;

void main() {
    const uvec2 p = gl_GlobalInvocationID.xy;
    if (p.x >= push.width || p.y >= push.height) return;
    const uint plane = push.width * push.height, pixel = p.y * push.width + p.x;
    const float gain = p.y < push.rows_ahead ? push.gain_ahead : push.gain;
    vec3 shown;
    for (uint i = 0u; i < 3u; ++i) {
        const uint c = push.first_channel + min(i, push.channel_count - 1u), low = 3u * c * plane + pixel;
        const float sum = float_from_fixed(uvec3(push.sums.v[low], push.sums.v[low + plane], push.sums.v[low + 2u * plane]));
        shown[i] = (sum + push.block.v[c * plane + pixel]) * gain + push.bias;
    }
    imageStore(hdr, ivec2(p), vec4(shown, 1.0));
}
