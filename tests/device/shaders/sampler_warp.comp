#version 460
// Sampler tests: samples of lib/warp.glsl with the density that the library says they have.
// Writes: samples, four floats an invocation: place or direction, density.
#extension GL_GOOGLE_include_directive : require
#include "lib/hash.glsl"
#include "lib/warp.glsl"
layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Samples { vec4 v[]; };
layout(push_constant, scalar) uniform Push {
    Samples samples;
    uint shape, count;
    float opening;
} push;

vec4 sample_shape(vec2 u) {
    switch (push.shape) {
        case 0: return vec4(sample_triangle(u), 0.0, pdf_triangle_solid_angle(0.5, 9.0, 0.25));
        case 1: return vec4(sample_concentric_disk(u), 0.0, pdf_concentric_disk_area());
        case 2: {
            const vec3 w = sample_cosine_hemisphere(u);
            return vec4(w, pdf_cosine_hemisphere_solid_angle(w.z));
        }
        case 3: return vec4(sample_uniform_sphere(u), pdf_uniform_sphere_solid_angle());
        default: return vec4(sample_cone(u, push.opening), pdf_cone_solid_angle(push.opening));
    }
}

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.count) return;
    // The corners of the square come first.
    vec2 u = vec2(float(i & 1u), float((i >> 1) & 1u)) * (1.0 - 5.9604645e-8);
    if (i >= 4u) {
        const uvec4 random = pcg4d(uvec4(i, 7u, 8u, 9u));
        u = vec2(uint_to_unit_float(random.x), uint_to_unit_float(random.y));
    }
    push.samples.v[i] = sample_shape(u);
}
