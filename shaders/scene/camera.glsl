// Camera rays.
#ifndef PARHELION_SCENE_CAMERA_GLSL
#define PARHELION_SCENE_CAMERA_GLSL
#include "scene/trace.glsl"
#include "shared/view.h"

// The ray through a film position in pixels (x to the right, y down, pixel centres at .5).
Ray camera_ray(Camera camera, vec2 film_px, vec2 size_px, uint alpha_key) {
    const vec2 p = vec2(2.0 * film_px.x / size_px.x - 1.0, 1.0 - 2.0 * film_px.y / size_px.y);
    const vec3 offset = p.x * camera.right_ws + p.y * camera.up_ws;
    if (camera.orthographic != 0u) return Ray(camera.position_ws + offset, 0.0, camera.forward_ws, kInfinity, alpha_key);
    return Ray(camera.position_ws, 0.0, normalize(camera.forward_ws + offset), kInfinity, alpha_key);
}
#endif
