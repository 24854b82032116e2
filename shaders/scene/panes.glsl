// Thin smooth walls (glass panes) let light pass straight, so they take no part in the choice of directions: a path decides at the
// wall whether it passes, as at a partly transparent one, and keeps its density; shadow rays pass weighted. Both see the same share.
#ifndef PARHELION_SCENE_PANES_GLSL
#define PARHELION_SCENE_PANES_GLSL
#include "scene/surface.glsl"
#include "shared/view.h"

bool is_pane(BsdfParameters p) { return p.thin && p.transmission > 0.0 && p.roughness < kDeltaRoughness; }

// What passes straight, from either side: both normals are looked at as they are, so that a path and a shadow ray agree.
vec3 pane_transmittance(ViewData view, Surface s, vec3 direction_ws) {
    if (!is_pane(s.scattering)) return vec3(0.0);
    const bool compensate = (view.flags & kViewEnergyCompensation) != 0u;
    return thin_transmittance(s.scattering, abs(dot(s.n_shading_ws, direction_ws)), compensate, scene.header.bsdf_tables);
}

// The ray behind a surface that it passes.
Ray pass_through(Ray ray, Surface s) {
    Ray behind = spawn_ray(s, ray.direction_ws, ray.t_max, ray.alpha_key);
    if (ray.t_max < kInfinity) behind.t_max = max(ray.t_max - distance(behind.origin_ws, ray.origin_ws), 0.0);
    return behind;
}
#endif
