// GGX microfacets with height-correlated Smith masking, in the shading frame (z = normal). Walter et al. 2007; Heitz 2014.
#ifndef PARHELION_LIB_MICROFACET_GLSL
#define PARHELION_LIB_MICROFACET_GLSL

const float kPi = 3.14159265358979;

// Below this perceptual roughness surfaces are exact mirrors and clear glass: GGX lobes with alpha < 0.0009 are narrower than a pixel.
const float kDeltaRoughness = 0.03;

float ggx_distribution(float cos_h, float alpha) {
    const float a2 = alpha * alpha;
    const float d = (cos_h * a2 - cos_h) * cos_h + 1.0;
    return a2 / (kPi * d * d);
}

// The same from the microfacet's normal, exact for narrow lobes too, where the sine says more than the cosine.
float ggx_distribution(vec3 h, float alpha) {
    const float a2 = alpha * alpha, d = dot(h.xy, h.xy) + a2 * h.z * h.z;
    return a2 / (kPi * d * d);
}

// Smith's Lambda, Heitz 2014 (72).
float ggx_lambda(float cos_theta, float alpha) {
    const float c2 = cos_theta * cos_theta;
    return 0.5 * (sqrt(1.0 + alpha * alpha * max(1.0 - c2, 0.0) / max(c2, 1e-12)) - 1.0);
}

// Height-correlated masking and shadowing over 4 cos_i cos_o.
float ggx_visibility(float cos_i, float cos_o, float alpha) {
    return 1.0 / ((1.0 + ggx_lambda(cos_i, alpha) + ggx_lambda(cos_o, alpha)) * 4.0 * cos_i * cos_o);
}

// A microfacet normal visible from wo. Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
vec3 sample_vndf_ggx(vec3 wo, float alpha, vec2 u) {
    const vec3 w = normalize(vec3(alpha * wo.xy, wo.z));
    const float phi = 2.0 * kPi * u.x;
    const float z = fma(1.0 - u.y, 1.0 + w.z, -w.z);
    const float s = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    const vec3 h = vec3(s * cos(phi), s * sin(phi), z) + w;
    return normalize(vec3(alpha * h.xy, max(h.z, 1e-9)));
}

// Density of the direction reflected at such a normal, per solid angle: D G1 / (4 cos_o).
float pdf_vndf_reflection_solid_angle(float cos_h, float cos_o, float alpha) {
    return ggx_distribution(cos_h, alpha) / ((1.0 + ggx_lambda(cos_o, alpha)) * 4.0 * cos_o);
}

vec3 fresnel_schlick(vec3 f0, float f90, float cos_h) {
    const float m = clamp(1.0 - cos_h, 0.0, 1.0);
    const float m2 = m * m;
    return f0 + (vec3(f90) - f0) * (m2 * m2 * m);
}
#endif
