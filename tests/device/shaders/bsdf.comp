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
    uint thin, compensate;
};
struct BsdfInput {
    uint surface;
    vec3 wo, given;  // kind 0: number of the lobe and two more; 1: wi; 2: x: samples of each lobe
};
struct BsdfResult {
    vec3 wi, weight;     // sampled (kind 0)
    float pdf;
    uint lobe;
    vec3 value;          // eval of wi, all lobes
    float pdf_again;     // pdf of wi
    vec3 value_swapped;  // eval with wi and wo exchanged
    vec3 diffuse, specular, transmission;  // the value's parts; kind 2: of the albedo
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

Bsdf bsdf_of(BsdfSurface s) {
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
    return make_bsdf(p, s.coat_normal, s.compensate != 0u, uint64_t(push.tables));
}

// Point n of a sequence with low discrepancy: in two dimensions (powers of the inverse of the root of x^3 = x + 1), and one by itself.
vec3 point(uint n) {
    const uvec3 steps = uvec3(3242174889u, 2447445414u, 2654435769u);
    return vec3((n * steps + 0x80000000u) >> 8u) * 5.9604645e-8;
}

// The albedo seen from wo: as many samples in each lobe, of low discrepancy, and each lobe by its share.
void add_furnace(inout BsdfResult r, Bsdf bsdf, vec3 wo, uint count) {
    const LobeShares s = lobe_shares(bsdf, wo, bsdf_place(bsdf, wo));
    const float shares[5] = float[](s.ggx, s.wide, s.coat, s.sheen, s.glass);
    float first = 0.0;
    for (uint lobe = 0u; lobe < 5u; ++lobe) {
        BsdfValue sum = kNoBsdfValue;
        for (uint n = 0u; shares[lobe] > 0.0 && n < count; ++n) {
            const vec3 u = point(n);
            const BsdfSample drawn = sample_bsdf(bsdf, wo, first + shares[lobe] * (0.001 + 0.998 * u.z), u.xy);
            if (drawn.lobe == kLobeNone) continue;
            sum.diffuse += drawn.weight.diffuse;
            sum.specular += drawn.weight.specular;
            sum.transmission += drawn.weight.transmission;
        }
        const float by = shares[lobe] / float(count);
        r.diffuse += by * sum.diffuse;
        r.specular += by * sum.specular;
        r.transmission += by * sum.transmission;
        first += shares[lobe];
    }
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
        r.diffuse = r.specular = r.transmission = vec3(0.0);
        add_furnace(r, bsdf, given.wo, uint(given.given.x));
        push.results.v[index] = r;
        return;
    }
    if (push.kind == 0u) {
        const BsdfSample s = sample_bsdf(bsdf, given.wo, given.given.x, given.given.yz);
        r.wi = s.wi;
        r.weight = total(s.weight);
        r.pdf = s.pdf;
        r.lobe = s.lobe;
    }
    const BsdfValue value = eval_bsdf(bsdf, given.wo, r.wi);
    r.value = total(value);
    r.diffuse = value.diffuse;
    r.specular = value.specular;
    r.transmission = value.transmission;
    r.pdf_again = pdf_bsdf_solid_angle(bsdf, given.wo, r.wi);
    r.value_swapped = r.wi.z > 0.0 ? total(eval_bsdf(bsdf, r.wi, given.wo)) : vec3(0.0);
    push.results.v[index] = r;
}
