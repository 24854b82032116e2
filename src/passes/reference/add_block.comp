#version 460
// Ends a block of samples: adds its float sums to the exact film sums and clears it.
// Reads and writes: block, sums (three 96-bit limb planes a channel, see lib/fixed_point.glsl).
#extension GL_GOOGLE_include_directive : require
#include "lib/fixed_point.glsl"
#include "shared/types.h"

layout(local_size_x = 32, local_size_y = 2) in;  // in two dimensions: a device may take only 65,535 work groups along one
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FilmBlock { float v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FilmSums { uint v[]; };
layout(push_constant, scalar) uniform Push {
    FilmBlock block;
    FilmSums sums;
    uint first_row, row_count;  // that the slice covered
    uint width;
    uint plane;  // pixels of the film
    uint channel_count;
} push;

void main() {
    if (gl_GlobalInvocationID.x >= push.width || gl_GlobalInvocationID.y >= push.row_count) return;
    const uint pixel = (push.first_row + gl_GlobalInvocationID.y) * push.width + gl_GlobalInvocationID.x;
    for (uint c = 0u; c < push.channel_count; ++c) {
        const uint low = 3u * c * push.plane + pixel;
        const uvec3 old = uvec3(push.sums.v[low], push.sums.v[low + push.plane], push.sums.v[low + 2u * push.plane]);
        const uvec3 sum = fixed_add(old, fixed_from_float(push.block.v[c * push.plane + pixel]));
        push.sums.v[low] = sum.x;
        push.sums.v[low + push.plane] = sum.y;
        push.sums.v[low + 2u * push.plane] = sum.z;
        push.block.v[c * push.plane + pixel] = 0.0;
    }
}
