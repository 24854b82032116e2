// The surface's scattering as glTF's metallic-roughness model and its extensions have it: metal, a dielectric over Lambert, and glass,
// mixed by weight (lib/glossy.glsl, lib/glass.glsl), under sheen and a clear coat (lib/layers.glsl). Lobes below kDeltaRoughness are
// exact mirrors. A triple sample / pdf / eval in the shading frame (z = shading normal on the side of wo).
#ifndef PARHELION_LIB_BSDF_GLSL
#define PARHELION_LIB_BSDF_GLSL
#include "lib/bsdf_types.glsl"
#include "lib/coated_glass.glsl"
#include "lib/color.glsl"
#include "lib/glass.glsl"
#include "lib/glossy.glsl"
#include "lib/layers.glsl"
#include "lib/warp.glsl"
#include "shared/types.h"

struct Bsdf {
    Glossy base;
    float alpha;          // GGX width of the surface, for whoever asks how far its light spreads
    uint64_t tables;
    // Below: with LAYERS only.
    float glass_weight;   // of `glass` in the mixture; the base's weights are in it
    Glass glass;
    Layers layers;
    CoatedGlass coated;   // the glass, with the layers
};

// KHR_materials_ior and KHR_materials_specular: the colour scales the dielectric's reflectance at normal incidence, up to 1, and
// `specular` all of it; metal has neither. glTF 2.0, appendix B.3.
// `coat_normal` is the clear coat's in the shading frame (0, 0, 1 where it has none of its own), `compensate` adds what microfacets
// scatter more than once, `tables` is the address of the directional albedos.
Bsdf make_bsdf(BsdfParameters p, vec3 coat_normal, bool compensate, uint64_t tables) {
    const float r = (p.ior - 1.0) / (p.ior + 1.0), transmission = kLayers ? p.transmission : 0.0;
    const vec3 dielectric_f0 = min(r * r * p.specular_color, vec3(1.0)) * p.specular;
    const float opaque = (1.0 - p.metallic) * (1.0 - transmission);
    Bsdf bsdf;
    bsdf.tables = tables;
    bsdf.alpha = p.roughness * p.roughness;
    bsdf.base = make_glossy(p.base_color * opaque, p.base_color, p.metallic, dielectric_f0, p.specular, opaque, p.roughness, compensate, tables);
#ifdef LAYERS
    bsdf.glass_weight = (1.0 - p.metallic) * transmission;
    if (bsdf.glass_weight > 0.0) bsdf.glass = make_glass(p.base_color, p.roughness, p.eta, p.specular, p.specular_color, p.thin, compensate, tables);
    bsdf.layers = make_layers(bsdf.base, bsdf.glass_weight, p.coat, p.coat_roughness, coat_normal, p.sheen_color, p.sheen_roughness, compensate, tables);
    bsdf.coated.inside = p.inside && transmission > 0.0 && !p.thin;
    bsdf.coated.diffuse = false;
    if (bsdf.glass_weight > 0.0) bsdf.coated = make_coated_glass(bsdf.glass, bsdf.layers, bsdf.coated.inside);
#endif
    return bsdf;
}

#ifdef LAYERS
bool is_layered(Bsdf bsdf) { return has_layers(bsdf.layers); }
bool has_glass(Bsdf bsdf) { return bsdf.glass_weight > 0.0; }
#endif

// What is looked up for a direction, once.
struct BsdfPlace {
    vec2 table;  // glossy_table()
#ifdef LAYERS
    LayerPlace layers;
#endif
};
BsdfPlace bsdf_place(Bsdf bsdf, vec3 w) {
    BsdfPlace place;
    const vec3 up = vec3(w.xy, abs(w.z));
    place.table = glossy_table(bsdf.base, up.z, bsdf.tables);
#ifdef LAYERS
    if (is_layered(bsdf)) place.layers = layer_place(bsdf.layers, bsdf.base, up, place.table, bsdf.tables);
#endif
    return place;
}

#ifdef LAYERS
// What the layers do not scatter, from either side.
float layers_leave(Bsdf bsdf, vec3 w) { return bare_layer_place(bsdf.layers, vec3(w.xy, abs(w.z)), bsdf.tables).leaves; }
#endif

// Probabilities of the lobes: `wide` is everything that is sampled by the cosine; sheen is sampled uniformly, because it is brightest
// at grazing angles.
struct LobeShares {
    float wide, ggx, coat, sheen, glass;
};
const LobeShares kNoShares = LobeShares(0.0, 0.0, 0.0, 0.0, 0.0);

// From what each lobe would return towards wo. Narrow lobes get at least a tenth where they are there at all: their light is the
// brightest; the wide one enough to bound the weight of what is scattered again.
LobeShares lobe_shares(Bsdf bsdf, vec3 wo, BsdfPlace o) {
    LobeShares s = kNoShares;
    float passes = 1.0;
#ifdef LAYERS
    const bool layered = is_layered(bsdf) && !bsdf.coated.inside;
    if (layered) passes = o.layers.passes;
#endif
    s.wide = passes * luminance(diffuse_albedo(bsdf.base, o.table) + again_albedo(bsdf.base, o.table));
    s.ggx = passes * luminance(single_albedo(bsdf.base.glossy, o.table));
#ifdef LAYERS
    if (layered) {
        const Layers l = bsdf.layers;
        s.wide += luminance(o.layers.residual) + l.coat * l.coat_again * o.layers.coat_loss;
        if (l.sheen > 0.0) s.sheen = o.layers.sheen_out * luminance(l.sheen_color) / l.sheen;
        if (bsdf.base.delta) s.ggx = o.layers.leaves * luminance(single_albedo(bsdf.base.glossy, o.table));
        s.coat = max(o.layers.coat - l.coat * l.coat_again * o.layers.coat_loss, 0.0);
    }
    if (has_glass(bsdf)) {
        s.glass = (layered ? o.layers.leaves : 1.0) * bsdf.glass_weight * glass_albedo(bsdf.glass, wo.z);
        s.wide += bsdf.glass_weight * bsdf.coated.average;
    }
#endif
    const float sum = s.wide + s.ggx + s.coat + s.sheen + s.glass;
    if (s.wide > 0.0) s.wide = max(s.wide, 0.02 * sum);
    if (s.ggx > 0.0) s.ggx = max(s.ggx, 0.1 * sum);
    if (s.coat > 0.0) s.coat = max(s.coat, 0.1 * sum);
    if (s.glass > 0.0) s.glass = max(s.glass, 0.1 * sum);
    const float by = sum > 0.0 ? 1.0 / (s.wide + s.ggx + s.coat + s.sheen + s.glass) : 0.0;
    return LobeShares(s.wide * by, s.ggx * by, s.coat * by, s.sheen * by, s.glass * by);
}

// All that a direction of view decides, for whoever asks more than once.
struct Outgoing {
    vec3 w;
    BsdfPlace place;
    LobeShares shares;
};
Outgoing look_from(Bsdf bsdf, vec3 wo) {
    const BsdfPlace place = bsdf_place(bsdf, wo);
    return Outgoing(wo, place, lobe_shares(bsdf, wo, place));
}

// Value and density (per solid angle) of all lobes that are no mirrors.
struct BsdfTerms {
    BsdfValue value;
    float pdf;
};

#ifdef LAYERS
const float kUniformHemisphere = 0.5 / kPi;

void add_layers(inout BsdfTerms terms, Bsdf bsdf, LobeShares shares, BsdfPlace o, BsdfPlace i, vec3 wo, vec3 wi) {
    const Layers l = bsdf.layers;
    const float passes = o.layers.passes * i.layers.passes;
    terms.value = scale(terms.value, vec3(passes));
    terms.value.diffuse += eval_residual(l, o.layers, i.layers, wi.z);
    if (l.sheen > 0.0) terms.value.diffuse += eval_sheen(l, o.layers, i.layers, half_vector(wo, wi), wo, wi);
    terms.pdf += shares.sheen * kUniformHemisphere;
    if (l.coat <= 0.0 || o.layers.cos_coat <= 0.0 || i.layers.cos_coat <= 0.0) return;
    terms.value.specular += vec3(eval_coat_again(l, o.layers, i.layers));
    if (l.coat_delta) return;
    const vec3 co = to_coat(l, wo), ci = to_coat(l, wi), h = half_vector(co, ci);
    terms.value.specular += l.coat * eval_ggx(coat_reflectance(l), l.coat_alpha, h, co, ci);
    terms.pdf += shares.coat * pdf_ggx_reflection_solid_angle(h, co.z, l.coat_alpha);
}

void add_glass(inout BsdfTerms terms, Bsdf bsdf, LobeShares shares, BsdfPlace o, BsdfPlace i, vec3 wo, vec3 wi) {
    const GlassTerms glass = glass_terms(bsdf.glass, wo, wi);
    vec3 value = glass.value * bsdf.glass_weight;
    if (is_layered(bsdf)) {
        value *= coated_passes(bsdf.glass, bsdf.coated, o.layers.leaves, i.layers.leaves, wi.z < 0.0);
        if (wi.z > 0.0) value += bsdf.glass_weight * eval_coated(bsdf.glass, bsdf.coated, vec2(wo.z, wi.z), vec2(o.layers.leaves, i.layers.leaves));
    }
    if (wi.z < 0.0) terms.value.transmission += value;
    else terms.value.specular += value;
    terms.pdf += shares.glass * glass.pdf;
}
#endif

BsdfTerms evaluate_bsdf(Bsdf bsdf, Outgoing from, vec3 wi) {
    BsdfTerms terms = BsdfTerms(kNoBsdfValue, 0.0);
    const vec3 wo = from.w;
    const BsdfPlace o = from.place;
    const LobeShares shares = from.shares;
    if (wo.z <= 0.0 || (!kLayers && wi.z <= 0.0)) return terms;
    const BsdfPlace i = bsdf_place(bsdf, wi);
    if (wi.z > 0.0) {
        terms.value.diffuse = eval_diffuse(bsdf.base, o.table, i.table, wi.z);
        terms.pdf = shares.wide * pdf_cosine_hemisphere_solid_angle(wi.z);
        if (has_glossy(bsdf.base) && !bsdf.base.delta) {
            const vec3 h = half_vector(wo, wi);
            terms.value.specular = eval_again(bsdf.base, o.table, i.table, wi.z) + eval_ggx(bsdf.base.glossy, bsdf.base.alpha, h, wo, wi);
            terms.pdf += shares.ggx * pdf_ggx_reflection_solid_angle(h, wo.z, bsdf.base.alpha);
        }
    }
#ifdef LAYERS
    if (wi.z > 0.0 && is_layered(bsdf) && !bsdf.coated.inside) add_layers(terms, bsdf, shares, o, i, wo, wi);
    if (has_glass(bsdf)) add_glass(terms, bsdf, shares, o, i, wo, wi);
#endif
    return terms;
}

// A mirror's direction, with the weight of its lobe over the probability of having drawn it.
BsdfSample delta_sample(vec3 wi, BsdfValue weight, uint lobe) { return BsdfSample(wi, weight, -1.0, lobe); }

#ifdef LAYERS
BsdfSample sample_delta_coat(Bsdf bsdf, LobeShares shares, BsdfPlace o, vec3 wo) {
    const Layers l = bsdf.layers;
    const vec3 wi = reflect(-wo, l.coat_normal);
    if (wi.z <= 0.0) return kNoBsdfSample;
    const vec3 weight = l.coat * fresnel_schlick(vec3(kCoatF0), 1.0, o.layers.cos_coat) / shares.coat;
    return delta_sample(wi, BsdfValue(vec3(0.0), weight, vec3(0.0)), kLobeSpecular);
}

BsdfSample sample_delta_glass(Bsdf bsdf, LobeShares shares, BsdfPlace o, vec3 wo, float u_lobe) {
    SmoothGlass smooth_shares = smooth_glass(bsdf.glass, wo);
    if (is_layered(bsdf)) {
        const vec3 mirrored = vec3(-wo.xy, wo.z), across = refract_smooth(bsdf.glass, wo);
        const bool crosses = bsdf.coated.inside && max_component(smooth_shares.refracted) > 0.0;
        smooth_shares = coated_smooth_glass(bsdf.glass, bsdf.coated, wo, o.layers.leaves, layers_leave(bsdf, mirrored), crosses ? layers_leave(bsdf, across) : 0.0);
    }
    const GlassSample glass = sample_smooth_glass(bsdf.glass, smooth_shares, wo, u_lobe);
    const vec3 weight = glass.weight * bsdf.glass_weight / shares.glass;
    if (glass.wi.z < 0.0) return delta_sample(glass.wi, BsdfValue(vec3(0.0), vec3(0.0), weight), kLobeTransmission);
    return delta_sample(glass.wi, BsdfValue(vec3(0.0), weight, vec3(0.0)), kLobeSpecular);
}
#endif

BsdfSample sample_delta_base(Bsdf bsdf, LobeShares shares, BsdfPlace o, vec3 wo) {
    const vec3 wi = vec3(-wo.xy, wo.z);
    vec3 weight = fresnel_schlick(bsdf.base.glossy.f0, bsdf.base.glossy.f90, wo.z) / shares.ggx;
#ifdef LAYERS
    // The coat's own normal may see the two directions differently.
    if (is_layered(bsdf) && !bsdf.coated.inside) weight *= sqrt(o.layers.leaves * layers_leave(bsdf, wi));
#endif
    return delta_sample(wi, BsdfValue(vec3(0.0), weight, vec3(0.0)), kLobeSpecular);
}

// u_lobe picks the lobe, u the direction.
BsdfSample sample_bsdf(Bsdf bsdf, Outgoing from, float u_lobe, vec2 u) {
    const vec3 wo = from.w;
    if (wo.z <= 0.0) return kNoBsdfSample;
    const BsdfPlace o = from.place;
    const LobeShares shares = from.shares;
    BsdfSample result = kNoBsdfSample;
    if (u_lobe < shares.ggx) {
        if (bsdf.base.delta) return sample_delta_base(bsdf, shares, o, wo);
        result.wi = sample_ggx_reflection(wo, bsdf.base.alpha, u);
        if (result.wi.z <= 0.0) return kNoBsdfSample;
        result.lobe = kLobeSpecular;
    } else if (u_lobe < shares.ggx + shares.wide) {
        result.wi = sample_cosine_hemisphere(u);
        result.lobe = kLobeDiffuse;
    }
#ifdef LAYERS
    else if (u_lobe < shares.ggx + shares.wide + shares.coat) {
        if (bsdf.layers.coat_delta) return sample_delta_coat(bsdf, shares, o, wo);
        const vec3 co = to_coat(bsdf.layers, wo);
        if (co.z <= 0.0) return kNoBsdfSample;
        const vec3 ci = sample_ggx_reflection(co, bsdf.layers.coat_alpha, u);
        result.wi = from_coat(bsdf.layers, ci);
        result.lobe = kLobeSpecular;
        if (ci.z <= 0.0 || result.wi.z <= 0.0) return kNoBsdfSample;
    } else if (u_lobe < shares.ggx + shares.wide + shares.coat + shares.sheen) {
        result.wi = sample_uniform_sphere(u);
        result.wi.z = abs(result.wi.z);
        result.lobe = kLobeDiffuse;
    } else if (shares.glass > 0.0) {
        const float u_glass = min((u_lobe - (1.0 - shares.glass)) / shares.glass, 0.99999994);
        if (bsdf.glass.delta) return sample_delta_glass(bsdf, shares, o, wo, u_glass);
        const GlassSample glass = sample_glass(bsdf.glass, wo, u_glass, u);
        if (glass.pdf == 0.0) return result;
        result.wi = glass.wi;
        result.lobe = glass.wi.z < 0.0 ? kLobeTransmission : kLobeSpecular;
    }
#endif
    if (result.lobe == kLobeNone) return kNoBsdfSample;
    const BsdfTerms terms = evaluate_bsdf(bsdf, from, result.wi);
    if (terms.pdf <= 0.0) return kNoBsdfSample;
    result.pdf = terms.pdf;
    result.weight = scale(terms.value, vec3(1.0 / terms.pdf));
    return result;
}

// What passes straight through a smooth thin wall (no part of the lobes above, see scene/panes.glsl): the same from both sides. Behind the
// layers, seen by the wall's own normal, it is what they and the reflection leave.
vec3 thin_transmittance(BsdfParameters p, float cos_o, bool compensate, uint64_t tables) {
#ifdef LAYERS
    const float weight = (1.0 - p.metallic) * p.transmission;
    if (weight <= 0.0) return vec3(0.0);
    const Glass glass = make_glass(p.base_color, p.roughness, p.eta, p.specular, p.specular_color, p.thin, false, tables);
    const Layers layers = make_bare_layers(p.coat, p.coat_roughness, vec3(0.0, 0.0, 1.0), p.sheen_color, p.sheen_roughness, compensate, tables);
    return weight * pane_transmittance(glass, cos_o) * (has_layers(layers) ? layers_pass(layers, cos_o, tables) : 1.0);
#else
    return vec3(0.0);
#endif
}
#endif
