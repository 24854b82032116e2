// The world cache (scene/cache_ask.glsl) at surfaces.
#ifndef PARHELION_SCENE_CACHE_GLSL
#define PARHELION_SCENE_CACHE_GLSL
#include "lib/geometry.glsl"
#include "scene/cache_ask.glsl"
#include "scene/surface.glsl"

// `wo_ws`: unit, to where the path came from, on whose side the cell will lie.
CachePoint cache_point(Surface s, vec3 wo_ws, float footprint, float u) {
    const vec3 n = s.front_facing ? s.n_geometric_ws : -s.n_geometric_ws;
    return CachePoint(s.position_ws, offset_origin(s.position_ws, s.position_error, n, n), n, wo_ws * s.t, s.instance, footprint, u);
}
#endif
