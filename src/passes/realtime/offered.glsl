// What a path was offered, beside what it brought by itself: while reservoirs wait for each other a signal holds both in its 64 bits. Nearly always one of the two
// is nothing, since a lobe's light is shared or it is not; then the other has all the bits but two, which say so. Else the path's own has 8 bits a channel, what it
// was offered 7, with exponents of 7: rounded up or down by random bits, so that means stay.
#ifndef PARHELION_REALTIME_OFFERED_GLSL
#define PARHELION_REALTIME_OFFERED_GLSL
#include "lib/color.glsl"
#include "lib/hash.glsl"
#include "lib/packed_light.glsl"
#include "lib/rgbe8.glsl"

const uint kPartsOwn = 0u, kPartsOffered = 1u, kPartsBoth = 2u;

uint parts_of(PackedLight p) { return p.high >> 30; }

// PackedLight without the last bit of blue: 2^-13.
PackedLight pack_part(vec3 x, uint parts) {
    PackedLight p = pack_light(vec3(x.rg, 0.0));
    p.high |= (min(floatBitsToUint(max(x.b, 0.0)) + (1u << 10), 0x7F7FFFFFu) >> 11) << 10 | parts << 30;
    return p;
}
vec3 unpack_part(PackedLight p) { return vec3(unpack_light(PackedLight(p.low, p.high & 1023u)).rg, unpack_21((p.high >> 10 & 0xFFFFFu) << 1)); }

// Three values >= 0 of so many bits, and 7 of the power of two that a step is.
const int kLeastStep = 64;
uint pack_steps(vec3 x, int bits, uvec3 random) {
    const float most = power_of_two(bits) - 1.0;
    const int of_largest = int(floatBitsToUint(max(max_component(x), 1e-30)) >> 23) - 126;  // of 2: all of x lies below it
    int step = clamp(of_largest - bits, -kLeastStep, 63);
    if (max_component(x) * power_of_two(-step) > most) step = min(step + 1, 63);
    const uvec3 steps = uvec3(min(floor(x * power_of_two(-step) + vec3(random >> 16) * exp2(-16.0)), vec3(most)));
    return steps.r | steps.g << bits | steps.b << 2 * bits | uint(step + kLeastStep) << 3 * bits;
}
vec3 unpack_steps(uint packed, int bits) {
    const uint mask = (1u << bits) - 1u;
    return vec3(packed & mask, packed >> bits & mask, packed >> 2 * bits & mask) * power_of_two(int(packed >> 3 * bits & 127u) - kLeastStep);
}

PackedLight pack_parts(vec3 own, vec3 offered, uvec4 random) {
    if (offered == vec3(0.0)) return pack_part(own, kPartsOwn);
    if (own == vec3(0.0)) return pack_part(offered, kPartsOffered);
    const uint of_own = pack_steps(own, 8, random.xyz), of_offered = pack_steps(offered, 7, random.yzw);
    return PackedLight(of_own, of_offered | kPartsBoth << 30);
}
vec3 own_light(PackedLight p) {
    if (parts_of(p) == kPartsBoth) return unpack_steps(p.low, 8);
    return parts_of(p) == kPartsOwn ? unpack_part(p) : vec3(0.0);
}
vec3 offered_light(PackedLight p) {
    if (parts_of(p) == kPartsBoth) return unpack_steps(p.high, 7);
    return parts_of(p) == kPartsOffered ? unpack_part(p) : vec3(0.0);
}
#endif
