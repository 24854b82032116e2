// Lambert under GGX: one reflecting lobe of a metal and a dielectric mixed, what microfacets scatter more than once, and below the
// dielectric the Lambert lobe. Symmetric, and white where its colours are white, whatever the roughness. Kulla and Conty 2017,
// "Revisiting Physically Based Shading at Imageworks"; reflectances by Schlick as glTF 2.0, appendix B, has them.
#ifndef PARHELION_LIB_GLOSSY_GLSL
#define PARHELION_LIB_GLOSSY_GLSL
#include "lib/bsdf_tables.glsl"
#include "lib/color.glsl"
#include "lib/microfacet.glsl"
#include "shared/types.h"

// A reflectance by Schlick, and the share `again` of what the microfacets' first scattering loses that further ones bring back.
struct Reflectance {
    vec3 f0;
    float f90;
    vec3 again;
};

struct Glossy {
    vec3 diffuse;         // albedo of the Lambert lobe; its weight included
    Reflectance glossy;   // of the GGX lobe, the mean of all that have it; f90 = 0: none
    Reflectance over;     // of the dielectric over the Lambert lobe, in the channel where it is largest, in all channels
    float passes_average; // what that one lets through, averaged over the hemisphere
    float loss_average;   // ggx_albedo_average().x
    float roughness, alpha;
    bool delta;           // an exact mirror in place of the GGX lobe
};

// `average` is ggx_albedo_average(). Light that is scattered again passes the Fresnel reflectance, averaged, each time.
Reflectance make_reflectance(vec3 f0, float f90, bool compensate, float loss_average) {
    const vec3 f = f0 + (vec3(f90) - f0) / 21.0;
    return Reflectance(f0, f90, compensate ? f * f * (1.0 - loss_average) / (vec3(1.0) - f * loss_average) : vec3(0.0));
}
Reflectance mix_reflectance(Reflectance a, Reflectance b, float weight_a, float weight_b) {
    return Reflectance(a.f0 * weight_a + b.f0 * weight_b, a.f90 * weight_a + b.f90 * weight_b, a.again * weight_a + b.again * weight_b);
}

// Albedo at once and of everything, from (loss, grazing).
vec3 single_albedo(Reflectance r, vec2 t) { return r.f0 * (1.0 - t.x - t.y) + vec3(r.f90 * t.y); }
vec3 whole_albedo(Reflectance r, vec2 t) { return single_albedo(r, t) + r.again * t.x; }

bool has_glossy(Glossy g) { return g.glossy.f90 > 0.0; }

// (loss, grazing) of the lobe seen from a cosine. A mirror loses nothing; a surface without the lobe reads no table.
vec2 glossy_table(Glossy g, float cosine, uint64_t tables) {
    if (!has_glossy(g)) return vec2(0.0);
    return g.delta ? vec2(0.0, schlick_weight(cosine)) : ggx_albedo(tables, cosine, g.roughness);
}

// What the dielectric lets through to the Lambert lobe, and out again: equal in both directions, and never more than it does not
// reflect. The same in all channels, so that a coloured dielectric does not lend the diffuse light its complement
// (KHR_materials_specular).
float glossy_passes(Glossy g, vec2 t) { return max(1.0 - whole_albedo(g.over, t).x, 0.0); }

// metal_f0 of weight `metal`; the dielectric of weight `dielectric`, over a Lambert lobe of albedo `diffuse` (its weight included).
Glossy make_glossy(vec3 diffuse, vec3 metal_f0, float metal, vec3 dielectric_f0, float dielectric_f90, float dielectric, float roughness, bool compensate, uint64_t tables) {
    Glossy g;
    g.diffuse = diffuse;
    g.roughness = roughness;
    g.alpha = roughness * roughness;
    g.delta = roughness < kDeltaRoughness;
    g.passes_average = 1.0;
    g.loss_average = 0.0;
    g.glossy = Reflectance(vec3(0.0), metal + dielectric * dielectric_f90, vec3(0.0));
    g.over = g.glossy;
    if (!has_glossy(g)) return g;
    const vec2 average = g.delta ? vec2(0.0, 1.0 / 21.0) : ggx_albedo_average(tables, roughness);
    g.loss_average = average.x;
    const Reflectance of_metal = make_reflectance(metal_f0, 1.0, compensate, average.x), of_dielectric = make_reflectance(dielectric_f0, dielectric_f90, compensate, average.x);
    g.glossy = mix_reflectance(of_metal, of_dielectric, metal, dielectric);
    g.over = Reflectance(vec3(max_component(of_dielectric.f0)), of_dielectric.f90, vec3(max_component(of_dielectric.again)));
    g.passes_average = glossy_passes(g, average);
    if (g.passes_average < 1e-5) {  // it reflects everything
        g.diffuse = vec3(0.0);
        g.passes_average = 1.0;
    }
    return g;
}

// Albedos seen from a direction with this table entry. The Lambert lobe is albedo (1 - S(o)) (1 - S(i)) / (pi (1 - S_average)), S being
// the dielectric's albedo; what microfacets scatter again is again loss(o) loss(i) / (pi loss_average).
vec3 diffuse_albedo(Glossy g, vec2 t) { return g.diffuse * glossy_passes(g, t); }
vec3 again_albedo(Glossy g, vec2 t) { return g.loss_average > 0.0 ? g.glossy.again * t.x : vec3(0.0); }

// Values times cosine. to, ti: table entries of wo and wi.
vec3 eval_diffuse(Glossy g, vec2 to, vec2 ti, float cos_i) { return diffuse_albedo(g, to) * (glossy_passes(g, ti) / g.passes_average * cos_i / kPi); }
vec3 eval_again(Glossy g, vec2 to, vec2 ti, float cos_i) { return again_albedo(g, to) * (ti.x / max(g.loss_average, 1e-20) * cos_i / kPi); }
vec3 eval_ggx(Reflectance r, float alpha, vec3 h, vec3 wo, vec3 wi) {
    return fresnel_schlick(r.f0, r.f90, dot(wi, h)) * (ggx_distribution(h, alpha) * ggx_visibility(wi.z, wo.z, alpha) * wi.z);
}
#endif
