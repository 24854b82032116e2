// Camera rays.
#ifndef PARHELION_SCENE_CAMERA_GLSL
#define PARHELION_SCENE_CAMERA_GLSL
#include "lib/geometry.glsl"
#include "scene/ray.glsl"
#include "shared/view.h"

// The same bits in every way to trace. The ray through a film position in pixels (x to the right, y down, pixel centres at .5).
Ray camera_ray(Camera camera, vec2 film_px, vec2 size_px, uint alpha_key) {
    precise const vec2 p = vec2(2.0 * film_px.x / size_px.x - 1.0, 1.0 - 2.0 * film_px.y / size_px.y);
    precise const vec3 offset = p.x * camera.right_ws + p.y * camera.up_ws;
    precise const vec3 origin = camera.position_ws + offset, through = camera.forward_ws + offset;
    if (camera.orthographic != 0u) return Ray(origin, 0.0, camera.forward_ws, kInfinity, alpha_key);
    return Ray(camera.position_ws, 0.0, precise_normalize(through), kInfinity, alpha_key);
}
#endif
