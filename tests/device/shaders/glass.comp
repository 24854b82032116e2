#version 460
// Test shader: glass. kind 0 samples from given numbers; 1 evaluates given directions; 2 adds up the weights of many samples.
// Reads: inputs, tables. Writes: results.
#extension GL_GOOGLE_include_directive : require
#include "lib/glass.glsl"
#include "shared/types.h"

struct GlassInput {
    vec3 wo, given;  // kind 0: number of the lobe and two more; kind 1: wi; kind 2: x: number of samples
    vec3 tint;
    float roughness, eta, specular;
    uint thin, compensate;
};
struct GlassResult {
    vec3 wi, weight;
    float pdf;
    uint delta;
    vec3 value;          // of wi
    float pdf_again;
    vec3 value_swapped;  // with wi and wo exchanged, seen from the side of wi
    vec3 reflected, transmitted;  // kind 0, 1: at wo, reflectance and what passes straight; 2: mean weights, the square of the index taken off
};
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Inputs { GlassInput v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Results { GlassResult v[]; };
layout(push_constant, scalar) uniform Push {
    Inputs inputs;
    Results results;
    BsdfTableWords tables;
    uint kind, count;
} push;

Glass glass_of(GlassInput g, float eta, bool compensate) { return make_glass(g.tint, g.roughness, eta, g.specular, vec3(1.0), g.thin != 0u, compensate, uint64_t(push.tables)); }

// Point n of a sequence with low discrepancy in three dimensions (powers of the inverse of the root of x^4 = x + 1).
vec3 point(uint n) {
    const uvec3 steps = uvec3(3518319153u, 2882110345u, 2360945575u);
    return vec3((n * steps + 0x80000000u) >> 8u) * 5.9604645e-8;
}

const uint kRings = 256u;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    const GlassInput g = push.inputs.v[i];
    const Glass glass = glass_of(g, g.eta, g.compensate != 0u);
    GlassResult r;
    r.delta = uint(glass.delta);
    r.reflected = vec3(glass_reflectance(glass, g.wo.z));
    r.transmitted = pane_transmittance(glass, g.wo.z);
    GlassSample s = GlassSample(g.given, vec3(0.0), 0.0);
    if (push.kind == 0u) s = sample_glass(glass, g.wo, g.given.x, g.given.yz);
    if (push.kind == 2u) {
        r.reflected = r.transmitted = vec3(0.0);
        const float index2 = glass.thin ? 1.0 : glass.eta * glass.eta;
        const Glass once = glass_of(g, g.eta, false);
        const uint samples = uint(g.given.x);
        for (uint n = 0u; n < samples; ++n) {
            const vec3 u = point(n);
            s = sample_glass(once, g.wo, u.x, u.yz);
            if (s.wi.z > 0.0) r.reflected += s.weight / float(samples);
            if (s.wi.z < 0.0) r.transmitted += s.weight * index2 / float(samples);
        }
        const float loss = glass_loss(glass, g.wo.z, false);
        for (uint n = 0u; n < kRings && loss > 0.0; ++n) {  // rings of equal steps in the fourth root of the cosine
            const float x = (float(n) + 0.5) / float(kRings), z = x * x * x * x, width = 2.0 * kPi * 4.0 * x * x * x / float(kRings);
            const vec3 wi = vec3(sqrt(1.0 - z * z), 0.0, z);
            r.reflected += glass_more(glass, loss, wi).value * width;
            r.transmitted += glass_more(glass, loss, -wi).value * (index2 * width);
        }
    }
    r.wi = s.wi;
    r.weight = s.weight;
    r.pdf = s.pdf;
    r.value = eval_glass(glass, g.wo, s.wi);
    r.pdf_again = pdf_glass_solid_angle(glass, g.wo, s.wi);
    const float side = s.wi.z < 0.0 ? -1.0 : 1.0;
    const Glass there = glass_of(g, side < 0.0 && !glass.thin ? 1.0 / g.eta : g.eta, g.compensate != 0u);
    r.value_swapped = eval_glass(there, vec3(s.wi.xy, s.wi.z * side), vec3(g.wo.xy, g.wo.z * side));
    push.results.v[i] = r;
}
