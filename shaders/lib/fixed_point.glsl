// Exact sums: a film channel is a 96-bit two's complement integer in units of 2^-40, so adding sample blocks is associative and
// any split of a sample range merges to the same bits. The host's mirror is image/film.h.
#ifndef PARHELION_LIB_FIXED_POINT_GLSL
#define PARHELION_LIB_FIXED_POINT_GLSL

// v * 2^40 rounded toward zero, |v| limited to 2^50; limbs from low to high.
uvec3 fixed_from_float(float v) {
    const uint bits = floatBitsToUint(v);
    const int exponent = int((bits >> 23) & 0xFFu) - 127 - 23 + 40;  // of the integer mantissa
    if (((bits >> 23) & 0xFFu) == 0u) return uvec3(0u);              // zero and subnormals
    uint mantissa = (bits & 0x7FFFFFu) | 0x800000u;
    uvec3 limbs = uvec3(0u);
    if (exponent >= 67) {
        limbs = uvec3(0u, 0u, 1u << 26);  // 2^50 * 2^40 = 2^90
    } else if (exponent <= 0) {
        limbs.x = exponent > -24 ? mantissa >> uint(-exponent) : 0u;
    } else {
        const uint word = uint(exponent) >> 5, shift = uint(exponent) & 31u;
        const uint low = mantissa << shift;
        const uint high = shift == 0u ? 0u : mantissa >> (32u - shift);
        if (word == 0u) limbs = uvec3(low, high, 0u);
        else if (word == 1u) limbs = uvec3(0u, low, high);
        else limbs = uvec3(0u, 0u, low);
    }
    if ((bits & 0x80000000u) == 0u) return limbs;
    uint carry = 0u;
    uvec3 negated;
    negated.x = uaddCarry(~limbs.x, 1u, carry);
    negated.y = uaddCarry(~limbs.y, carry, carry);
    negated.z = ~limbs.z + carry;
    return negated;
}

uvec3 fixed_add(uvec3 a, uvec3 b) {
    uint carry_low, carry_mid, carry_extra;
    uvec3 sum;
    sum.x = uaddCarry(a.x, b.x, carry_low);
    sum.y = uaddCarry(a.y, b.y, carry_mid);
    sum.y = uaddCarry(sum.y, carry_low, carry_extra);
    sum.z = a.z + b.z + carry_mid + carry_extra;
    return sum;
}
// Nearest float, for display: the three limbs are rounded one by one.
float float_from_fixed(uvec3 limbs) {
    const bool negative = (limbs.z & 0x80000000u) != 0u;
    if (negative) limbs = fixed_add(~limbs, uvec3(1u, 0u, 0u));
    const float value = float(limbs.z) * 16777216.0 + float(limbs.y) * 0.00390625 + float(limbs.x) * 9.094947e-13;
    return negative ? -value : value;
}
#endif
