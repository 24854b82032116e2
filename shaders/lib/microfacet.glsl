// GGX microfacets with height-correlated Smith masking, in the shading frame (z = normal). Walter et al. 2007; Heitz 2014.
#ifndef PARHELION_LIB_MICROFACET_GLSL
#define PARHELION_LIB_MICROFACET_GLSL
#include "shared/scene.h"

const float kPi = 3.14159265358979;

// Density of microfacets with normal h. Exact for narrow lobes too, where the sine says more than the cosine.
float ggx_distribution(vec3 h, float alpha) {
    const float a2 = alpha * alpha, d = dot(h.xy, h.xy) + a2 * h.z * h.z;
    return a2 / (kPi * d * d);
}

// Smith's Lambda, Heitz 2014 (72).
float ggx_lambda(float cos_theta, float alpha) {
    const float c2 = cos_theta * cos_theta;
    return 0.5 * (sqrt(1.0 + alpha * alpha * max(1.0 - c2, 0.0) / max(c2, 1e-12)) - 1.0);
}

// sqrt(cos^2 + alpha^2 sin^2): the cosine in the stretched space in which the surface is a hemisphere.
float ggx_stretched(float cos_theta, float alpha) { return sqrt(cos_theta * cos_theta + alpha * alpha * max(1.0 - cos_theta * cos_theta, 0.0)); }

// Height-correlated masking and shadowing over 4 cos_i cos_o.
float ggx_visibility(float cos_i, float cos_o, float alpha) {
    return 0.5 / (cos_i * ggx_stretched(cos_o, alpha) + cos_o * ggx_stretched(cos_i, alpha));
}

// The microfacet that reflects one direction into the other.
vec3 half_vector(vec3 wo, vec3 wi) { return normalize(vec3(wo.xy + wi.xy, max(wo.z + wi.z, 1e-6))); }

// A microfacet normal visible from wo. Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
vec3 sample_vndf_ggx(vec3 wo, float alpha, vec2 u) {
    const vec3 w = normalize(vec3(alpha * wo.xy, wo.z));
    const float phi = 2.0 * kPi * u.x;
    const float z = fma(1.0 - u.y, 1.0 + w.z, -w.z);
    const float s = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    const vec3 h = vec3(s * cos(phi), s * sin(phi), z) + w;
    return normalize(vec3(alpha * h.xy, max(h.z, 1e-9)));
}

// Reflection at a visible normal, from a cap of normals that leaves out most of those which reflect below the surface; the few
// that still do are lost samples. Eto and Tokuyoshi 2023, "Bounding VNDFs for Microfacet Reflections".
float vndf_bound(float cos_o, float alpha) {
    const float s = 1.0 + sqrt(max(1.0 - cos_o * cos_o, 0.0)), s2 = s * s, a2 = min(alpha, 1.0) * min(alpha, 1.0);
    return (1.0 - a2) * s2 / (s2 + a2 * cos_o * cos_o);
}
vec3 sample_ggx_reflection(vec3 wo, float alpha, vec2 u) {
    const vec3 w = normalize(vec3(alpha * wo.xy, wo.z));
    const float phi = 2.0 * kPi * u.x, bound = vndf_bound(wo.z, alpha) * w.z;
    const float z = fma(1.0 - u.y, 1.0 + bound, -bound);
    const float s = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    const vec3 h = vec3(s * cos(phi), s * sin(phi), z) + w;
    return reflect(-wo, normalize(vec3(alpha * h.xy, max(h.z, 1e-9))));
}
float pdf_ggx_reflection_solid_angle(vec3 h, float cos_o, float alpha) {
    return ggx_distribution(h, alpha) / (2.0 * (vndf_bound(cos_o, alpha) * cos_o + ggx_stretched(cos_o, alpha)));
}

float schlick_weight(float cos_h) {
    const float m = clamp(1.0 - cos_h, 0.0, 1.0), m2 = m * m;
    return m2 * m2 * m;
}
vec3 fresnel_schlick(vec3 f0, float f90, float cos_h) { return mix(f0, vec3(f90), schlick_weight(cos_h)); }
#endif
