// Light of single pixels that no neighbour has: shared out among the neighbours of the same surface, so that none is lost. Both signals of a
// group's pixels with two more on every side are in shared memory.
#ifndef PARHELION_RECONSTRUCTION_FIREFLIES_GLSL
#define PARHELION_RECONSTRUCTION_FIREFLIES_GLSL
#include "lib/color.glsl"
#include "shared/reconstruction.h"

const uint kRing = 2u, kSide = kChangeTile + 2u * kRing, kInner = kChangeTile + 2u;

shared vec3 lit_diffuse[kSide * kSide], lit_specular[kSide * kSide];
shared vec2 lit[kSide * kSide];     // their luminances
shared uint lit_id[kSide * kSide];  // of the surface
shared vec3 gifts[kInner * kInner]; // the shares of its two lights that a pixel gives each neighbour, and how many these are

uint neighbour(uint at, uint i) { return at + (i / 3u) * kSide + i % 3u - kSide - 1u; }  // 4: itself

// As much as it keeps of what stands out.
vec2 find_shares(vec2 own, vec2 limit, float count) { return mix(max(own - limit, vec2(0.0)) / (max(own, vec2(1e-30)) * (count + 1.0)), vec2(0.0), lessThanEqual(own, limit)); }

void find_gifts(uint inner, float limit) {
    const uint at = (inner / kInner + 1u) * kSide + inner % kInner + 1u, id = lit_id[at];
    vec2 most = vec2(0.0);
    float count = 0.0;
    for (uint i = 0u; i < 9u; ++i) {
        const uint other = neighbour(at, i);
        const bool same = i != 4u && lit_id[other] == id;
        most = max(most, same ? lit[other] : vec2(0.0));
        count += same ? 1.0 : 0.0;
    }
    const bool gives = id != 0u && limit > 0.0 && count > 0.0;
    gifts[inner] = vec3(gives ? find_shares(lit[at], limit * most, count) : vec2(0.0), count);
}

// The pixel's light once all have given and taken.
void share_out(uvec2 local, out vec3 diffuse, out vec3 specular) {
    const uint at = (local.y + kRing) * kSide + local.x + kRing, middle = (local.y + 1u) * kInner + local.x + 1u, id = lit_id[at];
    const vec3 own = gifts[middle];
    diffuse = lit_diffuse[at] * (1.0 - own.x * own.z);
    specular = lit_specular[at] * (1.0 - own.y * own.z);
    for (uint i = 0u; i < 9u; ++i) {
        const uint other = neighbour(at, i), inner = middle + (i / 3u) * kInner + i % 3u - kInner - 1u;
        const vec2 taken = i != 4u && lit_id[other] == id ? gifts[inner].xy : vec2(0.0);
        if (taken == vec2(0.0)) continue;
        diffuse += taken.x * lit_diffuse[other];
        specular += taken.y * lit_specular[other];
    }
}
#endif
