// The surface's scattering: Lambert under a GGX coat, metallic or dielectric, as glTF's metallic-roughness model.
// A triple sample / pdf / eval in the shading frame (z = shading normal on the side of wo).
#ifndef PARHELION_LIB_BSDF_GLSL
#define PARHELION_LIB_BSDF_GLSL
#include "lib/color.glsl"
#include "lib/microfacet.glsl"
#include "lib/warp.glsl"
#include "shared/types.h"

const uint kLobeDiffuse = 0u;
const uint kLobeSpecular = 1u;
const uint kLobeTransmission = 2u;
const uint kLobeNone = 3u;

// The parts of a material that only some scenes have (transmission, clear coat, sheen) cost nothing in shaders compiled without
// LAYERS; SceneHeader::features says what a scene needs.
#ifdef LAYERS
const bool kLayers = true;
#else
const bool kLayers = false;
#endif

// What the material says at a point of a surface. Factors and textures are multiplied already; colours are linear Rec. 709.
struct BsdfParameters {
    vec3 base_color;
    float metallic, roughness;     // perceptual roughness
    float ior;                     // of the material; 0: reflects everything (KHR_materials_ior)
    float specular;                // KHR_materials_specular; 0 with metallic 0: a pure Lambert surface
    vec3 specular_color;
    // Below: with LAYERS only.
    float transmission;            // KHR_materials_transmission
    bool thin;                     // the transmitting surface is a wall without thickness: no refraction, equal from both sides
    float eta;                     // index of refraction beyond the surface over that on wo's side
    float coat, coat_roughness;    // KHR_materials_clearcoat
    vec3 sheen_color;              // KHR_materials_sheen
    float sheen_roughness;
};

struct Bsdf {
    vec3 diffuse;            // albedo of the Lambert lobe
    float coat_f0, coat_f90; // reflectance of the dielectric coat over it, in the channel where it is largest
    vec3 f0;                 // reflectance of the GGX lobe at normal incidence; black with f90 = 0: no such lobe
    float f90;
    float alpha;             // GGX width
};

// Value times cosine, by class of the path that takes it (docs/path-space.md).
struct BsdfValue {
    vec3 diffuse, specular, transmission;
};
vec3 total(BsdfValue value) { return value.diffuse + value.specular + value.transmission; }
BsdfValue scale(BsdfValue value, vec3 by) { return BsdfValue(value.diffuse * by, value.specular * by, value.transmission * by); }
const BsdfValue kNoBsdfValue = BsdfValue(vec3(0.0), vec3(0.0), vec3(0.0));

struct BsdfSample {
    vec3 wi;
    BsdfValue weight;  // f cos / pdf of all lobes together, by class; of a delta lobe, of that lobe alone
    float pdf;         // per solid angle, of all lobes together; < 0: a delta lobe, which no light sample finds
    uint lobe;         // that was drawn; kLobeNone: absorbed
};

// Below this perceptual roughness surfaces are exact mirrors and clear glass: GGX lobes with alpha < 0.0009 are narrower than a pixel.
const float kDeltaRoughness = 0.03;

// Below this perceptual roughness the lobe is as narrow as single precision resolves.
const float kMinAlpha = 1e-3;

// The last three as KHR_materials_ior and KHR_materials_specular define them: the colour scales the dielectric's reflectance at
// normal incidence, up to 1, and `specular` all of it; metal has neither. glTF 2.0, appendix B.3.
//
// `coat_normal` is the clear coat's in the shading frame (0, 0, 1 where it has none of its own), `compensate` adds what microfacets
// scatter more than once, `tables` is the address of the directional albedos.
Bsdf make_bsdf(BsdfParameters p, vec3 coat_normal, bool compensate, uint64_t tables) {
    const float r = (p.ior - 1.0) / (p.ior + 1.0);
    const vec3 dielectric_f0 = min(r * r * p.specular_color, vec3(1.0)) * p.specular;
    Bsdf bsdf;
    bsdf.diffuse = p.base_color * (1.0 - p.metallic);
    bsdf.coat_f0 = max_component(dielectric_f0);
    bsdf.coat_f90 = p.specular;
    bsdf.f0 = mix(dielectric_f0, p.base_color, p.metallic);
    bsdf.f90 = mix(p.specular, 1.0, p.metallic);
    bsdf.alpha = max(p.roughness * p.roughness, kMinAlpha);
    return bsdf;
}

// Share of samples given to the specular lobe, from what each would return towards wo.
float specular_share(Bsdf bsdf, float cos_o) {
    const float s = luminance(fresnel_schlick(bsdf.f0, bsdf.f90, cos_o));
    const float d = luminance(bsdf.diffuse) * (1.0 - s);
    if (s + d <= 0.0) return 0.0;
    if (bsdf.f90 == 0.0) return 0.0;
    return d <= 0.0 ? 1.0 : clamp(s / (s + d), 0.1, 0.9);
}

// What the coat lets through, on the way in and on the way out: equal in both directions, and never more than it does not
// reflect. The same in all channels, so that a coloured coat does not lend the diffuse light its complement
// (KHR_materials_specular).
float coat_passes(Bsdf bsdf, float cosine) { return 1.0 - fresnel_schlick(vec3(bsdf.coat_f0), bsdf.coat_f90, cosine).x; }

BsdfValue eval_bsdf(Bsdf bsdf, vec3 wo, vec3 wi) {
    BsdfValue value = kNoBsdfValue;
    if (wi.z <= 0.0 || wo.z <= 0.0) return value;
    const vec3 h = normalize(wo + wi);
    const vec3 f = fresnel_schlick(bsdf.f0, bsdf.f90, dot(wi, h));
    value.diffuse = bsdf.diffuse * coat_passes(bsdf, wo.z) * coat_passes(bsdf, wi.z) * (wi.z / kPi);
    if (bsdf.f90 > 0.0) value.specular = f * (ggx_distribution(h.z, bsdf.alpha) * ggx_visibility(wi.z, wo.z, bsdf.alpha) * wi.z);
    return value;
}

float pdf_bsdf_solid_angle(Bsdf bsdf, vec3 wo, vec3 wi) {
    if (wi.z <= 0.0 || wo.z <= 0.0) return 0.0;
    const float share = specular_share(bsdf, wo.z);
    float pdf = (1.0 - share) * pdf_cosine_hemisphere_solid_angle(wi.z);
    if (share > 0.0) pdf += share * pdf_vndf_reflection_solid_angle(normalize(wo + wi).z, wo.z, bsdf.alpha);
    return pdf;
}

// u_lobe picks the lobe, u the direction.
BsdfSample sample_bsdf(Bsdf bsdf, vec3 wo, float u_lobe, vec2 u) {
    BsdfSample result = BsdfSample(vec3(0.0), kNoBsdfValue, 0.0, kLobeNone);
    if (wo.z <= 0.0) return result;
    if (u_lobe < specular_share(bsdf, wo.z)) {
        result.wi = reflect(-wo, sample_vndf_ggx(wo, bsdf.alpha, u));
        result.lobe = kLobeSpecular;
    } else {
        result.wi = sample_cosine_hemisphere(u);
        result.lobe = kLobeDiffuse;
    }
    result.pdf = pdf_bsdf_solid_angle(bsdf, wo, result.wi);
    if (result.pdf <= 0.0) {
        result.lobe = kLobeNone;
        return result;
    }
    result.weight = scale(eval_bsdf(bsdf, wo, result.wi), vec3(1.0 / result.pdf));
    return result;
}

// What passes straight through a smooth thin wall (no part of the lobes above, see scene/panes.glsl).
vec3 thin_transmittance(BsdfParameters p, float cos_o, uint64_t tables) { return vec3(0.0); }
#endif
