// Light of single pixels that no neighbour has: shared out among the neighbours of the same surface, so that none is lost. Both signals of a
// group's pixels with two more on every side are in shared memory.
#ifndef PARHELION_RECONSTRUCTION_FIREFLIES_GLSL
#define PARHELION_RECONSTRUCTION_FIREFLIES_GLSL
#include "lib/color.glsl"
#include "shared/reconstruction.h"

const uint kRing = 2u, kSide = kChangeTile + 2u * kRing, kInner = kChangeTile + 2u;

shared vec3 lit_diffuse[kSide * kSide], lit_specular[kSide * kSide];
shared uint lit_id[kSide * kSide];
shared vec3 gift_diffuse[kInner * kInner], gift_specular[kInner * kInner];

uint neighbour(uint at, uint i) { return at + (i / 3u) * kSide + i % 3u - kSide - 1u; }  // 4: itself

uint count_neighbours(uint at) {
    uint count = 0u;
    for (uint i = 0u; i < 9u; ++i) count += i != 4u && lit_id[neighbour(at, i)] == lit_id[at] ? 1u : 0u;
    return count;
}

// What a pixel gives each neighbour, and keeps of what stands out: as much.
vec3 gift(vec3 own, float most, float limit, uint count) {
    const float l = luminance(own);
    return count == 0u || l <= limit * most ? vec3(0.0) : own * ((l - limit * most) / (l * float(count + 1u)));
}

void find_gifts(uint inner, float limit) {
    const uint at = (inner / kInner + 1u) * kSide + inner % kInner + 1u;
    float most_diffuse = 0.0, most_specular = 0.0;
    for (uint i = 0u; i < 9u; ++i) {
        const uint other = neighbour(at, i);
        if (i == 4u || lit_id[other] != lit_id[at]) continue;
        most_diffuse = max(most_diffuse, luminance(lit_diffuse[other]));
        most_specular = max(most_specular, luminance(lit_specular[other]));
    }
    const uint count = lit_id[at] == 0u || limit == 0.0 ? 0u : count_neighbours(at);
    gift_diffuse[inner] = gift(lit_diffuse[at], most_diffuse, limit, count);
    gift_specular[inner] = gift(lit_specular[at], most_specular, limit, count);
}

// The pixel's light once all have given and taken.
void share_out(uvec2 local, out vec3 diffuse, out vec3 specular) {
    const uint at = (local.y + kRing) * kSide + local.x + kRing;
    diffuse = lit_diffuse[at];
    specular = lit_specular[at];
    for (uint i = 0u; i < 9u; ++i) {
        const uint other = neighbour(at, i), inner = (local.y + i / 3u) * kInner + local.x + i % 3u;
        if (lit_id[other] != lit_id[at]) continue;
        const float sign = i == 4u ? -float(count_neighbours(at)) : 1.0;
        diffuse += sign * gift_diffuse[inner];
        specular += sign * gift_specular[inner];
    }
    diffuse = max(diffuse, vec3(0.0));
    specular = max(specular, vec3(0.0));
}
#endif
