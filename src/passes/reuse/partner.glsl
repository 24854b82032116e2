// Which pixel another one is paired with, and what is told of its sample.
#ifndef PARHELION_REUSE_PARTNER_GLSL
#define PARHELION_REUSE_PARTNER_GLSL
#include "lib/hash.glsl"
#include "shared/reservoir.h"
#include "shared/view.h"

const uint kNoPartner = 0xFFFFu;

// One of the two that a pixel may have: whose partner that one is itself. All pixels' lie off by bits of the same two numbers.
ivec2 partner_of(ViewData view, ReuseFrame frame, uvec2 id, uint index, uint turn) {
    const uint kPairSalt = 0x50414952u;
    const uvec4 random = pcg4d(uvec4(frame.frame_index, view.seed ^ kPairSalt, 2u * index + turn, frame.set)) % (uint(frame.radius_px) + 1u);
    const ivec2 offset = ivec2(random.xy), exchanged = ivec2(random.zw == uvec2(0u) ? uvec2(1u, 0u) : random.zw);
    return ((ivec2(id) + offset) ^ exchanged) - offset;
}

// What a partner's sample brings, about; in which turn that partner was found; whether that took a ray. 16 bits: of the number its exponent and 6 bits, which will
// do where shares are weighed, as long as all numbers that these are made of are rounded alike (as_told): else two pixels' shares of a sample would not add up to 1.
const uint kToldShift = 17u, kMostTold = (0x7F800000u >> kToldShift) - 1u;
uint pack_told(float target, uint turn, bool traced) { return min(floatBitsToUint(target) >> kToldShift, kMostTold) << 2 | (traced ? 2u : 0u) | turn; }
float told_target(uint told) { return uintBitsToFloat(told >> 2 << kToldShift); }
float as_told(float target) { return told_target(pack_told(target, 0u, false)); }
uint told_turn(uint told) { return told & 1u; }
bool told_traced(uint told) { return told != kNoPartner && (told & 2u) != 0u; }

// Two partners a word.
uint told_at(uint pixels, ReuseFrame frame, uint index, uint pixel) { return (frame.set * ((frame.neighbours + 1u) / 2u) + index / 2u) * pixels + pixel; }
uint told_part(uint index) { return 16u * (index & 1u); }
uint told_of(uint word, uint index) { return word >> told_part(index) & 0xFFFFu; }
bool fills_word(ReuseFrame frame, uint index) { return (index & 1u) == 1u || index + 1u == frame.neighbours; }
#endif
