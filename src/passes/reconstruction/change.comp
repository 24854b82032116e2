#version 460
// Where light has changed since the histories began: the mean of the last frame over tiles around, held against that of the histories.
// A change counts as far as it stands out of the standard error of so many pixels, over 3 by 3 or 5 by 5 tiles.
// Reads: tiles. Writes: changes (half2 a tile, diffuse and specular; 0: none, 1: for sure).
#extension GL_GOOGLE_include_directive : require
#include "shared/reconstruction.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Tiles { ChangeTile v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Changes { uint v[]; };
layout(push_constant, scalar) uniform Push {
    Tiles tiles;
    Changes changes;
    uvec2 size;     // in tiles
    float antilag;  // ReconstructionFrame::antilag
} push;

// Of what the frame brought, what the histories said, and the variance of the first.
float judge(vec3 sum) {
    const float change = abs(sum.x - sum.y), stands_out = change / max(sqrt(sum.z), 1e-12), share = change / max(max(sum.x, sum.y), 1e-12);
    return smoothstep(push.antilag, 2.0 * push.antilag, stands_out) * smoothstep(0.1, 0.25, share);
}

vec2 find_change(ivec2 middle, int radius) {
    vec3 diffuse = vec3(0.0), specular = vec3(0.0);
    float count = 0.0;
    for (int y = -radius; y <= radius; ++y)
        for (int x = -radius; x <= radius; ++x) {
            const ivec2 at = middle + ivec2(x, y);
            if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(push.size)))) continue;
            const ChangeTile t = push.tiles.v[uint(at.y) * push.size.x + uint(at.x)];
            diffuse += vec3(t.diffuse_now, t.diffuse_before, t.diffuse_variance);
            specular += vec3(t.specular_now, t.specular_before, t.specular_variance);
            count += t.count;
        }
    return count < 16.0 ? vec2(0.0) : vec2(judge(diffuse), judge(specular));
}

void main() {
    const uvec2 id = gl_GlobalInvocationID.xy;
    if (id.x >= push.size.x || id.y >= push.size.y) return;
    const vec2 change = push.antilag <= 0.0 ? vec2(0.0) : max(find_change(ivec2(id), 1), find_change(ivec2(id), 2));
    push.changes.v[id.y * push.size.x + id.x] = packHalf2x16(change);
}
