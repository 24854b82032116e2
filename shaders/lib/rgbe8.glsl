// Three values >= 0 with one exponent: 8 bits each and 8, of nearly a float's range (Ward 1991, "Real Pixels"). Rounded up or down by random bits,
// so that means stay; what comes back is packed as it was, whatever the bits.
#ifndef PARHELION_LIB_RGBE8_GLSL
#define PARHELION_LIB_RGBE8_GLSL

float power_of_two(int exponent) { return uintBitsToFloat(uint(exponent + 127) << 23); }  // -126 to 127

uint pack_rgbe8(vec3 x, uvec3 random) {
    x = clamp(x, vec3(0.0), vec3(1e37));
    const float largest = max(x.r, max(x.g, x.b));
    if (!(largest >= 1e-30)) return 0u;
    int exponent = int(floatBitsToUint(largest) >> 23) - 126;  // of 2: all of x lies below it
    vec3 steps = x * power_of_two(8 - exponent);
    if (max(steps.r, max(steps.g, steps.b)) > 255.0) {
        ++exponent;
        steps *= 0.5;
    }
    const uvec3 bits = uvec3(floor(steps + vec3(random >> 16) * exp2(-16.0)));
    return bits.r | bits.g << 8 | bits.b << 16 | uint(exponent + 127) << 24;
}
vec3 unpack_rgbe8(uint bits) { return vec3(bits & 255u, bits >> 8 & 255u, bits >> 16 & 255u) * power_of_two(max(int(bits >> 24) - 135, -126)); }
#endif
