// A pixel's summary of a surface (shared/realtime.h), and its depth.
#ifndef PARHELION_GBUFFER_SUMMARY_GLSL
#define PARHELION_GBUFFER_SUMMARY_GLSL
#include "lib/color.glsl"
#include "lib/hash.glsl"
#include "lib/octahedral.glsl"
#include "lib/rgb9e5.glsl"
#include "scene/follow.glsl"
#include "shared/realtime.h"

// Of a surface that stands in the place of others before it, by the number of those.
uint surface_number(uint before, Surface s) { return pcg_hash(before ^ s.instance ^ s.geometry << 20); }

uint summary_flags(Surface s) {
    const bool transmits = kLayers && s.scattering.transmission > 0.0;
    return (s.front_facing ? kSummaryFrontFacing : 0u) | (transmits ? kSummaryTransmits : 0u) | (s.scattering.roughness < kDeltaRoughness ? kSummaryDelta : 0u) |
           (is_followed(s) ? kSummaryFollowed : 0u);
}

// `seen`: what of its light comes through what lies before it.
uvec4 summarise(Surface s, vec3 n_shading_ws, vec3 seen, uint number, float exposure) {
    const BsdfParameters p = s.scattering;
    const float f0 = (p.ior - 1.0) / (p.ior + 1.0);
    const float reflectance = min(sqrt(f0 * f0 * p.specular * luminance(seen) / 0.16), 1.0);  // as f0 = 0.16 reflectance^2 has it
    const uint id = max(number & 0xFFFFu, 1u);
    return uvec4(packUnorm4x8(vec4(pow(p.base_color * seen, vec3(1.0 / 2.2)), p.roughness)), pack_rgb9e5(s.emission * seen * exposure),
                 packUnorm4x8(vec4(reflectance, p.metallic, 0.0, 0.0)) | id << kSummaryIdShift, pack_direction_24(n_shading_ws) << 8 | summary_flags(s));
}

float reversed_depth(Camera camera, vec3 position_ws) {
    const float distance = dot(position_ws - camera.position_ws, camera.forward_ws);
    return camera.orthographic != 0u ? 1.0 / (1.0 + distance) : min(kDepthNear / distance, 1.0);
}
#endif
