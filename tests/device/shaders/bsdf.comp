#version 460
// variants: LAYERS
// Test shader: the BSDF's triple. kind 0 samples from given numbers; 1 evaluates given directions; 2 finds albedos, the
// furnace; 3 reads the albedo tables (given: cosine, roughness).
// Reads: surfaces, inputs, tables. Writes: results.
#extension GL_GOOGLE_include_directive : require
#include "lib/bsdf.glsl"
#include "shared/types.h"

struct BsdfSurface {
    vec3 base_color, specular_color, sheen_color, coat_normal;
    float metallic, roughness, ior, specular, transmission, eta, coat, coat_roughness, sheen_roughness;
    uint thin, compensate, inside;
};
struct BsdfInput {
    uint surface;
    vec3 wo, given;  // kind 0: number of the lobe and two more; 1: wi; 2: x: samples in each set
};
struct BsdfResult {
    vec3 wi, weight;     // sampled (kind 0)
    float pdf;
    uint lobe;
    vec3 value;          // eval of wi, all lobes
    float pdf_again;     // pdf of wi
    vec3 value_swapped;  // eval with wi and wo exchanged, seen from wi's side
    vec3 diffuse, specular, transmission;  // the value's parts; kind 2: of the albedo, of what crosses without the index squared
};
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Surfaces { BsdfSurface v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Inputs { BsdfInput v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Results { BsdfResult v[]; };
layout(push_constant, scalar) uniform Push {
    Surfaces surfaces;
    Inputs inputs;
    Results results;
    BsdfTableWords tables;
    uint kind, count;
} push;

BsdfParameters parameters_of(BsdfSurface s) {
    BsdfParameters p;
    p.base_color = s.base_color;
    p.metallic = s.metallic;
    p.roughness = s.roughness;
    p.ior = s.ior;
    p.specular = s.specular;
    p.specular_color = s.specular_color;
    p.transmission = s.transmission;
    p.thin = s.thin != 0u;
    p.eta = s.eta;
    p.coat = s.coat;
    p.coat_roughness = s.coat_roughness;
    p.sheen_color = s.sheen_color;
    p.sheen_roughness = s.sheen_roughness;
    p.inside = s.inside != 0u;
    return p;
}
Bsdf bsdf_of(BsdfSurface s) { return make_bsdf(parameters_of(s), s.coat_normal, s.compensate != 0u, uint64_t(push.tables)); }

// Point n of a sequence with low discrepancy: in two dimensions (powers of the inverse of the root of x^3 = x + 1), and one by itself.
vec3 point(uint n) {
    const uvec3 steps = uvec3(3242174889u, 2447445414u, 2654435769u);
    return vec3((n * steps + 0x80000000u) >> 8u) * 5.9604645e-8;
}

// Density of directions that are uniform in sqrt(cosine) and azimuth: many at grazing angles, where the BSDF's own are few.
float pdf_grazing(vec3 wi) { return wi.z > 0.0 ? 1.0 / (4.0 * kPi * sqrt(wi.z)) : 0.0; }

// The albedo seen from wo by the balance heuristic from two sets of directions, both of low discrepancy: the BSDF's own samples, as
// many of each lobe, each lobe by its share; and that of pdf_grazing().
void add_furnace(inout BsdfResult r, Bsdf bsdf, vec3 wo, uint count) {
    const Outgoing from = look_from(bsdf, wo);
    const LobeShares s = from.shares;
    const float shares[5] = float[](s.ggx, s.wide, s.coat, s.sheen, s.glass);
    float first = 0.0;
    BsdfValue albedo = kNoBsdfValue;
    for (uint lobe = 0u; lobe < 6u; ++lobe) {
        const float share = lobe < 5u ? shares[lobe] : 1.0;
        BsdfValue sum = kNoBsdfValue;
        for (uint n = 0u; share > 0.0 && n < count; ++n) {
            const vec3 u = point(n);
            BsdfSample drawn;
            if (lobe < 5u) {
                drawn = sample_bsdf(bsdf, from, first + share * (0.001 + 0.998 * u.z), u.xy);
                if (drawn.lobe == kLobeNone) continue;
                if (drawn.pdf > 0.0) drawn.weight = scale(drawn.weight, vec3(drawn.pdf / (drawn.pdf + pdf_grazing(drawn.wi))));
            } else {
                const float z = max(u.x * u.x, 1e-12), across = sqrt(1.0 - z * z), phi = 2.0 * kPi * u.y;
                drawn.wi = vec3(across * cos(phi), across * sin(phi), z);
                const BsdfTerms terms = evaluate_bsdf(bsdf, from, drawn.wi);
                drawn.weight = scale(terms.value, vec3(1.0 / (terms.pdf + pdf_grazing(drawn.wi))));
            }
            sum = BsdfValue(sum.diffuse + drawn.weight.diffuse, sum.specular + drawn.weight.specular, sum.transmission + drawn.weight.transmission);
        }
        sum = scale(sum, vec3(share / float(count)));
        albedo = BsdfValue(albedo.diffuse + sum.diffuse, albedo.specular + sum.specular, albedo.transmission + sum.transmission);
        first += share;
    }
    r.diffuse = albedo.diffuse;
    r.specular = albedo.specular;
    r.transmission = albedo.transmission;
}

void main() {
    const uint index = gl_GlobalInvocationID.x;
    if (index >= push.count) return;
    const BsdfInput given = push.inputs.v[index];
    BsdfResult r;
    r.wi = given.given;
    r.weight = vec3(0.0);
    r.pdf = 0.0;
    r.lobe = kLobeNone;
    r.pdf_again = 0.0;
    if (push.kind == 3u) {
        r.value = vec3(ggx_albedo(uint64_t(push.tables), given.given.x, given.given.y), 0.0);
        r.value_swapped = vec3(ggx_albedo_average(uint64_t(push.tables), given.given.y), 0.0);
        push.results.v[index] = r;
        return;
    }
    const Bsdf bsdf = bsdf_of(push.surfaces.v[given.surface]);
    if (push.kind == 2u) {
        const BsdfSurface s = push.surfaces.v[given.surface];
        add_furnace(r, bsdf, given.wo, uint(given.given.x));
        if (s.thin != 0u) r.transmission += thin_transmittance(parameters_of(s), given.wo.z, s.compensate != 0u, uint64_t(push.tables));
        else r.transmission *= s.eta * s.eta;
        push.results.v[index] = r;
        return;
    }
    const Outgoing from = look_from(bsdf, given.wo);
    if (push.kind == 0u) {
        const BsdfSample s = sample_bsdf(bsdf, from, given.given.x, given.given.yz);
        r.wi = s.wi;
        r.weight = total(s.weight);
        r.pdf = s.pdf;
        r.lobe = s.lobe;
    }
    const BsdfTerms terms = evaluate_bsdf(bsdf, from, r.wi);
    const BsdfValue value = terms.value;
    r.value = total(value);
    r.diffuse = value.diffuse;
    r.specular = value.specular;
    r.transmission = value.transmission;
    r.pdf_again = terms.pdf;
    BsdfSurface there = push.surfaces.v[given.surface];
    if (r.wi.z < 0.0 && there.thin == 0u) {
        there.eta = 1.0 / there.eta;
        there.inside = 1u - there.inside;
    }
    const float side = r.wi.z < 0.0 ? -1.0 : 1.0;
    const Bsdf swapped = bsdf_of(there);
    r.value_swapped = total(evaluate_bsdf(swapped, look_from(swapped, vec3(r.wi.xy, r.wi.z * side)), vec3(given.wo.xy, given.wo.z * side)).value);
    push.results.v[index] = r;
}
