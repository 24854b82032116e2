#version 460
// Test shader: the BSDF's triple. kind 0 samples from given numbers; kind 1 evaluates given directions.
// Reads: inputs (kind 0: lobe number and two more; kind 1: direction). Writes: results.
#extension GL_GOOGLE_include_directive : require
#include "lib/bsdf.glsl"
#include "shared/types.h"

struct BsdfResult {
    vec3 wi, weight;     // sampled (kind 0)
    float pdf;
    uint lobe;
    vec3 value;          // eval of wi, all lobes
    float pdf_again;     // pdf of wi
    vec3 value_swapped;  // eval with wi and wo exchanged
};
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Inputs { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Results { BsdfResult v[]; };
layout(push_constant, scalar) uniform Push {
    Inputs inputs;
    Results results;
    uint kind, count;
    vec3 wo, base_color, specular_color;
    float metallic, roughness, ior, specular;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    BsdfParameters p;
    p.base_color = push.base_color;
    p.metallic = push.metallic;
    p.roughness = push.roughness;
    p.ior = push.ior;
    p.specular = push.specular;
    p.specular_color = push.specular_color;
    const Bsdf bsdf = make_bsdf(p, vec3(0.0, 0.0, 1.0), false, 0ul);
    const vec3 given = push.inputs.v[i];
    BsdfSample s = BsdfSample(given, kNoBsdfValue, 0.0, kLobeNone);
    if (push.kind == 0u) s = sample_bsdf(bsdf, push.wo, given.x, given.yz);
    const BsdfValue value = eval_bsdf(bsdf, push.wo, s.wi), swapped = eval_bsdf(bsdf, s.wi, push.wo);
    push.results.v[i] = BsdfResult(s.wi, total(s.weight), s.pdf, s.lobe, total(value), pdf_bsdf_solid_angle(bsdf, push.wo, s.wi), total(swapped));
}
