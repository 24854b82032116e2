// Radiance in 64 bits: three unsigned floats with the exponents of a 32-bit float and 13 bits of mantissa (relative error 2^-14).
#ifndef PARHELION_LIB_PACKED_LIGHT_GLSL
#define PARHELION_LIB_PACKED_LIGHT_GLSL
#include "shared/realtime.h"

const uint kPackedMask = (1u << 21) - 1u;

// Values >= 0; the largest finite one stands for all beyond.
uint pack_21(float x) { return min(floatBitsToUint(max(x, 0.0)) + (1u << 9), 0x7F7FFFFFu) >> 10; }
float unpack_21(uint bits) { return uintBitsToFloat(bits << 10); }

PackedLight pack_light(vec3 x) {
    const uint r = pack_21(x.r), g = pack_21(x.g), b = pack_21(x.b);
    return PackedLight(r | (g << 21), (g >> 11) | (b << 10));
}
vec3 unpack_light(PackedLight p) { return vec3(unpack_21(p.low & kPackedMask), unpack_21((p.low >> 21 | p.high << 11) & kPackedMask), unpack_21(p.high >> 10 & kPackedMask)); }
#endif
