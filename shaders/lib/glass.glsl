// Surfaces of dielectrics that light crosses: rough and smooth glass, and walls without thickness. A triple sample / pdf / eval in
// the shading frame (z = normal on the side of wo): a direction with z < 0 is on the other side. Walter et al. 2007, "Microfacet
// Models for Refraction through Rough Surfaces". Values are of radiance: what crosses carries the factor (1 / eta)^2, so that
// f(wo, wi) / n_o^2 = f(wi, wo) / n_i^2 (Veach 1997, 5.2).
#ifndef PARHELION_LIB_GLASS_GLSL
#define PARHELION_LIB_GLASS_GLSL
#include "lib/bsdf_tables.glsl"
#include "lib/color.glsl"
#include "lib/microfacet.glsl"
#include "lib/warp.glsl"
#include "shared/types.h"

// Indices that differ by less than this share are one: a rough boundary between them would bend light by less than single
// precision can tell.
const float kMatchedIndices = 1e-3;

struct Glass {
    vec3 tint;       // of the light that crosses
    float roughness; // perceptual
    float alpha;     // GGX width
    float eta;       // index of refraction beyond over that on wo's side; 0: everything is reflected
    float specular;  // scales the reflectance, except where it is total
    vec3 reflected_tint;  // of the reflectance at normal incidence; fades towards grazing and total reflection
    bool thin;       // a wall without thickness: what crosses is mirrored, not refracted
    bool delta;      // smooth: directions are exact. What a smooth wall lets pass straight is pane_transmittance(), not of the triple
    // What microfacets scatter more than once.
    bool compensated;
    uint64_t tables;
    float average_loss, average_loss_beyond;  // over the hemispheres, of light from wo's side and from the other
    float crossing;                           // share of it that crosses
};

struct GlassSample {
    vec3 wi;      // wi.z < 0: the light crosses the surface
    vec3 weight;  // f cos / pdf
    float pdf;    // per solid angle; < 0: a delta lobe, its weight is over the probability of that lobe; 0: absorbed
};

// Fresnel's reflectance for unpolarised light from the cosines of both directions to the normal: the same for both, and exactly so.
float fresnel_dielectric(float cos_o, float cos_i, float eta) {
    const float s = (cos_o - eta * cos_i) / (cos_o + eta * cos_i), p = (eta * cos_o - cos_i) / (eta * cos_o + cos_i);
    return 0.5 * (s * s + p * p);
}

// Cosine of the refracted direction times eta; 0 where reflection is total (Snell).
float refracted_eta_cosine(float cos_o, float eta) { return sqrt(max((eta - 1.0) * (eta + 1.0) + cos_o * cos_o, 0.0)); }

// Reflectance of a microfacet, or of a smooth surface. Total reflection does not depend on `specular` (KHR_materials_specular).
float glass_reflectance(Glass g, float cos_o) {
    if (g.eta == 1.0) return 0.0;
    const float eta_cos_i = refracted_eta_cosine(cos_o, g.eta);
    return eta_cos_i == 0.0 ? 1.0 : g.specular * fresnel_dielectric(cos_o, eta_cos_i / g.eta, g.eta);
}

// Its colour: as Schlick's formula blends f0 towards white (KHR_materials_specular), by what the reflectance itself says of the angle.
// A function of the microfacet's angle, so it is the same in both directions.
vec3 tint_reflectance(Glass g, float reflectance) {
    const float r = (g.eta - 1.0) / (g.eta + 1.0), least = g.specular * r * r;
    return reflectance * mix(g.reflected_tint, vec3(1.0), clamp((reflectance - least) / max(1.0 - least, 1e-6), 0.0, 1.0));
}

// What rough glass scatters more than once of light from this cosine, on wo's side or beyond: 1 - the albedo.
float glass_loss(Glass g, float cosine, bool beyond) {
    if (!g.compensated) return 0.0;
    if (g.thin || g.eta == 0.0) return ggx_albedo(g.tables, cosine, g.roughness).x;  // both sides together return what a mirror does
    return glass_table(g.tables, cosine, g.roughness, beyond ? 1.0 / g.eta : g.eta, g.specular);
}
float glass_average_loss(Glass g, bool beyond) {
    if (g.thin || g.eta == 0.0) return ggx_albedo_average(g.tables, g.roughness).x;
    return glass_average_table(g.tables, g.roughness, beyond ? 1.0 / g.eta : g.eta, g.specular);
}

// Luminance of what is scattered once and more than once, about: for the choice between lobes. Without the square of the index, and
// without what a smooth wall lets pass straight.
float glass_once_albedo(Glass g, float cos_o, float loss) {
    const float reflectance = glass_reflectance(g, cos_o);
    return (1.0 - loss) * (reflectance + (g.thin && g.delta ? 0.0 : (1.0 - reflectance) * luminance(g.tint)));
}
float glass_more_albedo(Glass g, float loss) { return loss * (1.0 - g.crossing + g.crossing * luminance(g.tint)); }
float glass_albedo(Glass g, float cos_o) {
    const float loss = glass_loss(g, cos_o, false);
    return glass_once_albedo(g, cos_o, loss) + glass_more_albedo(g, loss);
}

// Kulla and Conty 2017, "Revisiting Physically Based Shading at Imageworks": light that is scattered more than once leaves as from
// Lambert lobes on both sides, in proportion to what the microfacets lose in each direction (l, averages L):
//     reflected  (1 - a) l(o) l(i) / (pi L)        crossing  a l(o) l'(i) / (pi L') (1 / eta)^2        (primes: of the other side)
// Whatever a is, both together return l(o). Reciprocity of what crosses, f / n_o^2 equal in both directions, asks for
// a L n_o^2 = a' L' n_i^2: so a is L' eta^2 times something symmetric. We take the most that keeps both shares within 1, times
// Fresnel's mean transmittance from the rarer side: a = t min(1, L' eta^2 / L), a' = t min(1, L / (L' eta^2)). A wall has L = L'.
void compensate_glass(inout Glass g) {
    g.average_loss = max(glass_average_loss(g, false), 1e-8);
    g.average_loss_beyond = g.thin ? g.average_loss : max(glass_average_loss(g, true), 1e-8);
    const float n = max(g.eta, 1.0 / g.eta), mean_reflectance = (n - 1.0) / (4.08567 + 1.00071 * n);  // Kulla and Conty's fit
    g.crossing = (1.0 - g.specular * mean_reflectance) * (g.thin ? 1.0 : min(1.0, g.average_loss_beyond * g.eta * g.eta / g.average_loss));
    if (g.eta == 0.0) g.crossing = 0.0;
}

// `tables` is the address of the directional albedos, of no matter without `compensate`.
Glass make_glass(vec3 tint, float roughness, float eta, float specular, vec3 reflected_tint, bool thin, bool compensate, uint64_t tables) {
    const bool matched = abs(eta - 1.0) < kMatchedIndices, opaque = !(eta > 1e-3 && eta < 1e3);  // an index of 0: KHR_materials_ior
    Glass g;
    g.tint = tint;
    g.roughness = roughness;
    g.alpha = roughness * roughness;
    g.eta = matched ? 1.0 : (opaque ? 0.0 : eta);
    g.specular = specular;
    g.reflected_tint = min(reflected_tint, vec3(1.0));  // more would be taken from nowhere
    g.thin = thin;
    g.delta = roughness < kDeltaRoughness || (matched && !thin);
    g.compensated = compensate && !g.delta;
    g.tables = tables;
    g.average_loss = g.average_loss_beyond = g.crossing = 0.0;
    if (g.compensated) compensate_glass(g);
    return g;
}

// What passes straight through a smooth wall without thickness. KHR_materials_transmission: one boundary's reflectance, tinted once.
vec3 pane_transmittance(Glass g, float cos_o) {
    return g.thin && g.delta ? g.tint * (1.0 - glass_reflectance(g, cos_o)) : vec3(0.0);
}

// Share of samples that are reflected where `reflectance` is. At most 1, however the device rounds quotients.
float reflected_share(Glass g, float reflectance) {
    return min(reflectance / max(reflectance + (1.0 - reflectance) * luminance(g.tint), 1e-20), 1.0);
}

// Masking and shadowing of directions on opposite sides, correlated by height: B(1 + a, 1 + b) with the Lambda of both. With
// U uniform (the share of the surface below), light escapes upwards with U^a and downwards with (1 - U)^b: their product's mean is
// Euler's beta function (Heitz et al. 2016, "Multiple-Scattering Microfacet BSDFs with the Smith Model"). It is symmetric, and at
// most 1 / (1 + a) / (1 + b), the uncorrelated form. By Stirling's series for 2 + a, 2 + b, within 1e-5; logarithms are arranged so
// that it stays so where one Lambda is large.
float ggx_masking_across(float lambda_a, float lambda_b) {
    const float large = 2.0 + max(lambda_a, lambda_b), small = 2.0 + min(lambda_a, lambda_b), sum = large + small, ratio = small / large;
    const float w = ratio / (2.0 + ratio), w2 = w * w;
    const float log1p_ratio = 2.0 * w * (1.0 + w2 * (1.0 / 3.0 + w2 * (1.0 / 5.0 + w2 * (1.0 / 7.0 + w2 * (1.0 / 9.0 + w2 / 11.0)))));
    const vec3 r = 1.0 / vec3(large, small, sum), r2 = r * r;
    const vec3 stirling = r * (1.0 / 12.0 - r2 * (1.0 / 360.0 - r2 / 1260.0));
    const float beta = 2.5066283 * sqrt(sum * r.x * r.y) * exp(small * log(ratio) - sum * log1p_ratio + stirling.x + stirling.y - stirling.z);
    return beta * ((sum - 2.0) / (small - 1.0)) * ((sum - 1.0) / (large - 1.0));
}

// Smallest cosine to the normal for which masking is told apart (ggx_lambda).
const float kMinCosine = 1e-6;

struct GlassTerms {
    vec3 value;  // times |cos|
    float pdf;
};
const GlassTerms kNoGlassTerms = GlassTerms(vec3(0.0), 0.0);

// Reflection, and what crosses a wall: the reflected direction mirrored to the other side, with the share that is not reflected.
GlassTerms glass_mirrored(Glass g, vec3 wo, vec3 wi) {
    const float cos_o = max(wo.z, kMinCosine), cos_i = max(abs(wi.z), kMinCosine);
    const vec3 h = normalize(wo + vec3(wi.xy, abs(wi.z)));
    const float reflectance = glass_reflectance(g, dot(wo, h)), share = reflected_share(g, reflectance);
    const float d = ggx_distribution(h, g.alpha), lobe = d * ggx_visibility(cos_i, cos_o, g.alpha) * cos_i;
    const float pdf = d / ((1.0 + ggx_lambda(cos_o, g.alpha)) * 4.0 * cos_o);
    if (wi.z > 0.0) return GlassTerms(tint_reflectance(g, reflectance) * lobe, share * pdf);
    return GlassTerms(g.tint * ((1.0 - reflectance) * lobe), (1.0 - share) * pdf);
}

// Walter et al. 2007, (16), (17), (21), with wo + eta wi along the microfacet's normal.
GlassTerms glass_refracted(Glass g, vec3 wo, vec3 wi) {
    const vec3 along = wo + g.eta * wi;
    const float length2 = dot(along, along);
    const vec3 h = along * ((along.z < 0.0 ? -1.0 : 1.0) * inversesqrt(length2));
    const float cos_oh = dot(wo, h), cos_ih = -dot(wi, h);
    if (cos_oh <= 0.0 || cos_ih <= 0.0) return kNoGlassTerms;
    const float reflectance = g.specular * fresnel_dielectric(cos_oh, cos_ih, g.eta);
    const float cos_o = max(wo.z, kMinCosine), lambda_o = ggx_lambda(cos_o, g.alpha), lambda_i = ggx_lambda(max(-wi.z, kMinCosine), g.alpha);
    const float common_terms = (ggx_distribution(h, g.alpha) / cos_o) * (cos_oh * cos_ih / length2);
    return GlassTerms(g.tint * ((1.0 - reflectance) * common_terms * ggx_masking_across(lambda_o, lambda_i)),
                      (1.0 - reflected_share(g, reflectance)) * common_terms * g.eta * g.eta / (1.0 + lambda_o));
}

GlassTerms glass_once(Glass g, vec3 wo, vec3 wi) {
    return wi.z < 0.0 && !g.thin ? glass_refracted(g, wo, wi) : glass_mirrored(g, wo, wi);
}

// Share of the samples scattered more than once that cross.
float crossing_share(Glass g) {
    const float crossing = g.crossing * luminance(g.tint);
    return min(crossing / max(1.0 - g.crossing + crossing, 1e-20), 1.0);
}

// Share of samples that are scattered once.
float glass_once_share(Glass g, float cos_o, float loss) {
    const float once = glass_once_albedo(g, cos_o, loss), more = glass_more_albedo(g, loss);
    return more > 0.0 ? once / (once + more) : 1.0;
}

// What is scattered more than once, `loss` of the light from wo: compensate_glass().
GlassTerms glass_more(Glass g, float loss, vec3 wi) {
    const bool crosses = wi.z < 0.0;
    const float cos_i = abs(wi.z), lobe = loss * glass_loss(g, cos_i, crosses) * cos_i / kPi, pdf = cos_i / kPi, share = crossing_share(g);
    if (!crosses) return GlassTerms(vec3((1.0 - g.crossing) * lobe / g.average_loss), (1.0 - share) * pdf);
    return GlassTerms(g.tint * (g.crossing * lobe / (g.average_loss_beyond * (g.thin ? 1.0 : g.eta * g.eta))), share * pdf);
}

GlassTerms glass_terms(Glass g, vec3 wo, vec3 wi) {
    if (g.delta || wo.z <= 0.0 || wi.z == 0.0 || (g.eta == 0.0 && wi.z < 0.0)) return kNoGlassTerms;
    const GlassTerms once = glass_once(g, wo, wi);
    const float loss = glass_loss(g, wo.z, false);
    if (loss == 0.0) return once;
    const GlassTerms more = glass_more(g, loss, wi);
    return GlassTerms(once.value + more.value, mix(more.pdf, once.pdf, glass_once_share(g, wo.z, loss)));
}
vec3 eval_glass(Glass g, vec3 wo, vec3 wi) { return glass_terms(g, wo, wi).value; }
float pdf_glass_solid_angle(Glass g, vec3 wo, vec3 wi) { return glass_terms(g, wo, wi).pdf; }

// Refracted at a normal on wo's side; not where reflection is total.
vec3 refract_glass(Glass g, vec3 wo, vec3 h) {
    const float cos_oh = dot(wo, h);
    return normalize((cos_oh - refracted_eta_cosine(cos_oh, g.eta)) * h - wo);
}

// A smooth surface reflects or refracts these shares of the light; a smooth wall reflects only (what passes is decided before).
struct SmoothGlass {
    vec3 reflected, refracted;  // the latter without the square of the index
};
SmoothGlass smooth_glass(Glass g, vec3 wo) {
    const float reflectance = glass_reflectance(g, wo.z);
    return SmoothGlass(tint_reflectance(g, reflectance), g.thin ? vec3(0.0) : g.tint * (1.0 - reflectance));
}
vec3 refract_smooth(Glass g, vec3 wo) { return refract_glass(g, wo, vec3(0.0, 0.0, 1.0)); }

GlassSample sample_smooth_glass(Glass g, SmoothGlass smooth_shares, vec3 wo, float u_lobe) {
    const float reflected = luminance(smooth_shares.reflected), refracted = luminance(smooth_shares.refracted);
    const float share = refracted > 0.0 ? min(reflected / (reflected + refracted), 1.0) : 1.0;
    if (u_lobe < share) return GlassSample(vec3(-wo.xy, wo.z), smooth_shares.reflected / share, -1.0);
    return GlassSample(refract_smooth(g, wo), smooth_shares.refracted / ((1.0 - share) * g.eta * g.eta), -1.0);
}

// Scattered once; no direction where the microfacets' neighbours would be met.
vec3 sample_glass_once(Glass g, vec3 wo, float u_side, vec2 u) {
    const vec3 h = sample_vndf_ggx(wo, g.alpha, u);
    const bool crosses = u_side >= reflected_share(g, glass_reflectance(g, dot(wo, h)));
    vec3 wi = crosses && !g.thin ? refract_glass(g, wo, h) : reflect(-wo, h);
    if (crosses && g.thin) wi.z = -wi.z;
    return crosses == wi.z < 0.0 ? wi : vec3(0.0);
}

// u_lobe picks the lobe and the side, u the direction.
GlassSample sample_glass(Glass g, vec3 wo, float u_lobe, vec2 u) {
    if (g.delta) return sample_smooth_glass(g, smooth_glass(g, wo), wo, u_lobe);
    const float share = glass_once_share(g, wo.z, glass_loss(g, wo.z, false));
    vec3 wi;
    if (u_lobe < share) {
        wi = sample_glass_once(g, wo, u_lobe / share, u);
    } else {
        wi = sample_cosine_hemisphere(u);
        if (u_lobe - share < (1.0 - share) * crossing_share(g)) wi.z = -wi.z;
    }
    const GlassTerms terms = glass_terms(g, wo, wi);
    return terms.pdf > 0.0 ? GlassSample(wi, terms.value / terms.pdf, terms.pdf) : GlassSample(vec3(0.0), vec3(0.0), 0.0);
}
#endif
