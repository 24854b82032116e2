// Light and a deviation in four half floats.
#ifndef PARHELION_RECONSTRUCTION_HALF_LIGHT_GLSL
#define PARHELION_RECONSTRUCTION_HALF_LIGHT_GLSL

const float kMostHalf = 65504.0;

uvec2 pack_half_light(vec4 x) {
    x = clamp(x, vec4(0.0), vec4(kMostHalf));
    return uvec2(packHalf2x16(x.xy), packHalf2x16(x.zw));
}
vec4 unpack_half_light(uvec2 bits) { return vec4(unpackHalf2x16(bits.x), unpackHalf2x16(bits.y)); }

// Rounded up or down as often as the mean asks for, by 13 random bits: a running mean that were rounded to nearest would stand still before
// it is there.
float dither_half(float x, uint bits) {
    if (x < 6.103515625e-5) return x;  // below 2^-14 halves are as fine as 2^-24
    return uintBitsToFloat((floatBitsToUint(x) + (bits & 0x1FFFu)) & 0xFFFFE000u);
}
vec4 dither_half(vec4 x, uvec4 bits) { return vec4(dither_half(x.x, bits.x), dither_half(x.y, bits.y), dither_half(x.z, bits.z), dither_half(x.w, bits.w)); }
#endif
