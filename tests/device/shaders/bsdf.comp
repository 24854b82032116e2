#version 460
// variants: LAYERS
// Test shader: the BSDF's triple. kind 0 samples from given numbers; 1 evaluates given directions; 2 adds up the weights of many
// samples, the furnace; 3 reads the albedo tables (given: cosine, roughness).
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
    vec3 wo, given;  // kind 0: number of the lobe and two more; 1: wi; 2: x: count of samples
};
struct BsdfResult {
    vec3 wi, weight;     // sampled (kind 0)
    float pdf;
    uint lobe;
    vec3 value;          // eval of wi, all lobes
    float pdf_again;     // pdf of wi
    vec3 value_swapped;  // eval with wi and wo exchanged
    vec3 diffuse, specular, transmission;  // the value's parts; kind 2: sums of weights
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

// Point n of a sequence with low discrepancy in three dimensions (powers of the inverse of the root of x^4 = x + 1).
vec3 point(uint n) {
    const uvec3 steps = uvec3(3518319153u, 2882110345u, 2360945575u);
    return vec3((n * steps + 0x80000000u) >> 8u) * 5.9604645e-8;
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
        const uint count = uint(given.given.x);
        for (uint n = 0u; n < count; ++n) {
            const vec3 u = point(n);
            const BsdfSample s = sample_bsdf(bsdf, given.wo, u.x, u.yz);
            if (s.lobe == kLobeNone) continue;
            r.diffuse += s.weight.diffuse;
            r.specular += s.weight.specular;
            r.transmission += s.weight.transmission;
        }
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
