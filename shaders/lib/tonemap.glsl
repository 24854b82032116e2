// Tone curves and the sRGB transfer, as src/image/tonemap.cpp: ACES after Stephen Hill's fit (2016), AgX after Troy Sobotka (2022)
// by Benjamin Wrensch's polynomial (2023).
#ifndef PARHELION_LIB_TONEMAP_GLSL
#define PARHELION_LIB_TONEMAP_GLSL

const uint kCurveLinear = 0u;
const uint kCurveAces = 1u;
const uint kCurveAgx = 2u;

// Matrices are given by rows; v * M multiplies from the left of the transposed, which is M's rows times v.
vec3 tonemap_aces(vec3 v) {
    v = v * mat3(0.59719, 0.35458, 0.04823, 0.07600, 0.90834, 0.01566, 0.02840, 0.13383, 0.83777);
    v = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    return v * mat3(1.60475, -0.53108, -0.07367, -0.10208, 1.10813, -0.00605, -0.00327, -0.07276, 1.07602);
}

vec3 tonemap_agx(vec3 v) {
    v = v * mat3(0.842479062, 0.0784336, 0.0792237451, 0.0423282423, 0.878468636, 0.0791661275, 0.0423756549, 0.0784336, 0.879142974);
    const float kMinStops = -12.47393, kMaxStops = 4.026069;
    const vec3 x = (clamp(log2(max(v, 1e-10)), kMinStops, kMaxStops) - kMinStops) / (kMaxStops - kMinStops);
    const vec3 x2 = x * x, x4 = x2 * x2;
    v = 15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232;
    v = v * mat3(1.19687901, -0.0980208811, -0.0990297441, -0.0528968518, 1.15190313, -0.0989611768, -0.0529716355, -0.0980434501, 1.15107367);
    return pow(max(v, 0.0), vec3(2.2));
}

// Display values in [0, 1] from exposed linear Rec.709.
vec3 tonemap_to_srgb(vec3 exposed, uint curve) {
    vec3 v = clamp(exposed, 0.0, 1e9);
    if (curve == kCurveAces) v = tonemap_aces(v);
    if (curve == kCurveAgx) v = tonemap_agx(v);
    v = clamp(v, 0.0, 1.0);
    return mix(12.92 * v, 1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, greaterThan(v, vec3(0.0031308)));
}
#endif
