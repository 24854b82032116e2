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

// A surface's plane as the pixels around see it: how a pixel's ray, 1 m deep (orthographic: where it starts), lies along the normal, and by how much more it does a pixel
// to the right and one down. It saves placing each point that is held against the plane.
struct SeenPlane {
    vec2 more;
    float along, depth;
};
SeenPlane see_plane(Camera camera, vec2 film_px, vec2 size_px, vec3 normal_ws, float depth) {
    const vec2 across = vec2(dot(camera.right_ws, normal_ws), -dot(camera.up_ws, normal_ws)), ray = camera.orthographic != 0u ? vec2(0.0) : 2.0 * film_px / size_px - 1.0;
    return SeenPlane(2.0 * across / size_px, dot(camera.forward_ws, normal_ws) + dot(ray, across), depth);
}
// Of the point that a pixel so far off sees at a depth, metres.
float distance_to(SeenPlane plane, bool orthographic, vec2 off_px, float depth) {
    const float more = dot(off_px, plane.more);
    return abs(orthographic ? more + (depth - plane.depth) * plane.along : depth * (plane.along + more) - plane.depth * plane.along);
}

// A pixel's width at a depth, metres.
float pixel_size(ViewData view, float depth) { return view.pixel_width + view.pixel_spread * depth; }

// Tangent of the half angle that holds three quarters of a GGX lobe's normals: Walter et al. 2007, equation 35 with u = 3/4.
float lobe_tangent(float roughness) { return 1.732 * roughness * roughness; }
#endif
