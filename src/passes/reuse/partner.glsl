// Which pixel another one is paired with, and what is told of its sample.
#ifndef PARHELION_REUSE_PARTNER_GLSL
#define PARHELION_REUSE_PARTNER_GLSL
#include "lib/hash.glsl"
#include "shared/reservoir.h"
#include "shared/view.h"

const uint kNoPartner = 0xFFFFFFFFu;

// One of the two that a pixel may have: whose partner that one is itself. All pixels' lie off by bits of the same two numbers.
ivec2 partner_of(ViewData view, ReuseFrame frame, uvec2 id, uint index, uint turn) {
    const uint kPairSalt = 0x50414952u;
    const uvec4 random = pcg4d(uvec4(frame.frame_index, view.seed ^ kPairSalt, 2u * index + turn, frame.set)) % (uint(frame.radius_px) + 1u);
    const ivec2 offset = ivec2(random.xy), exchanged = ivec2(random.zw == uvec2(0u) ? uvec2(1u, 0u) : random.zw);
    return ((ivec2(id) + offset) ^ exchanged) - offset;
}

// What a partner's sample brings, about; in which turn that partner was found; whether that took a ray.
uint pack_told(float target, uint turn, bool traced) { return floatBitsToUint(target) & ~3u | (traced ? 2u : 0u) | turn; }
float told_target(uint told) { return uintBitsToFloat(told & ~3u); }
uint told_turn(uint told) { return told & 1u; }
bool told_traced(uint told) { return told != kNoPartner && (told & 2u) != 0u; }

uint told_at(uint pixels, ReuseFrame frame, uint index, uint pixel) { return (frame.set * frame.neighbours + index) * pixels + pixel; }
#endif
