// Three values >= 0 with one exponent: 9 bits each and 5, up to 65408 (VK_FORMAT_E5B9G9R9_UFLOAT_PACK32).
#ifndef PARHELION_LIB_RGB9E5_GLSL
#define PARHELION_LIB_RGB9E5_GLSL

uint pack_rgb9e5(vec3 x) {
    x = clamp(x, vec3(0.0), vec3(65408.0));
    const float largest = max(x.r, max(x.g, x.b));
    int exponent = max(-16, int(floor(log2(max(largest, 1e-30))))) + 1;  // of 2: all of x lies below it
    exponent += int(round(largest * exp2(float(9 - exponent))) > 511.0);
    const uvec3 bits = uvec3(round(x * exp2(float(9 - exponent))));
    return bits.r | (bits.g << 9) | (bits.b << 18) | (uint(exponent + 15) << 27);
}
vec3 unpack_rgb9e5(uint bits) { return vec3(bits & 511u, bits >> 9 & 511u, bits >> 18 & 511u) * exp2(float(int(bits >> 27) - 24)); }
#endif
