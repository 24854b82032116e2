// The surfaces that reconstruction compares: one of a pixel, now or a frame ago.
#ifndef PARHELION_RECONSTRUCTION_SURFACES_GLSL
#define PARHELION_RECONSTRUCTION_SURFACES_GLSL
#include "lib/octahedral.glsl"
#include "shared/realtime.h"
#include "shared/reconstruction.h"
#include "shared/view.h"

// A pixel's guide, two words: metres along the camera's axis (+infinity: sky), and the shading normal (24 bits) with the roughness (8 bits).
struct Guide {
    float depth;
    vec3 normal;
    float roughness;
};
Guide unpack_guide(uvec2 g) { return Guide(uintBitsToFloat(g.x), unpack_direction_24(g.y >> 8), float(g.y & 255u) / 255.0); }
uvec2 pack_guide(float reversed_depth, bool orthographic, uvec4 summary) {
    const float depth = reversed_depth <= 0.0 ? uintBitsToFloat(0x7F800000u) : orthographic ? 1.0 / reversed_depth - 1.0 : kDepthNear / reversed_depth;
    return uvec2(floatBitsToUint(depth), (summary.w & 0xFFFFFF00u) | summary.x >> 24);
}

// The point that a camera without a lens sees at a film position (pixels) and a depth.
vec3 place(Camera camera, vec2 film_px, vec2 size_px, float depth) {
    const vec3 offset = (2.0 * film_px.x / size_px.x - 1.0) * camera.right_ws + (1.0 - 2.0 * film_px.y / size_px.y) * camera.up_ws;
    return camera.orthographic != 0u ? camera.position_ws + offset + depth * camera.forward_ws : camera.position_ws + depth * (camera.forward_ws + offset);
}

// A pixel's width at a depth, metres.
float pixel_size(ViewData view, float depth) { return view.pixel_width + view.pixel_spread * depth; }

// Tangent of the half angle that holds three quarters of a GGX lobe's normals: Walter et al. 2007, equation 35 with u = 3/4.
float lobe_tangent(float roughness) { return 1.732 * roughness * roughness; }
#endif
