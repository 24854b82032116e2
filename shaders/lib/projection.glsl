// From the world to the film: the inverse of camera rays. The same bits in whatever shader they are compiled.
#ifndef PARHELION_LIB_PROJECTION_GLSL
#define PARHELION_LIB_PROJECTION_GLSL
#include "lib/geometry.glsl"
#include "shared/view.h"

struct FilmPoint {
    vec2 film_px;
    bool in_front;  // of the camera; film_px means nothing otherwise
};

// Where a camera sees what lies at `offset_ws` from it, `distance` along its axis (1 for an orthographic one).
FilmPoint project_offset(Camera camera, vec3 offset_ws, float distance, vec2 size_px) {
    precise const float x = precise_dot(offset_ws, camera.right_ws) / (precise_dot(camera.right_ws, camera.right_ws) * distance);
    precise const float y = precise_dot(offset_ws, camera.up_ws) / (precise_dot(camera.up_ws, camera.up_ws) * distance);
    precise const vec2 film_px = vec2((x + 1.0) * size_px.x, (1.0 - y) * size_px.y) * 0.5;
    return FilmPoint(film_px, distance > 0.0);
}

FilmPoint project_point(Camera camera, vec3 position_ws, vec2 size_px) {
    precise const vec3 offset = position_ws - camera.position_ws;
    const float distance = camera.orthographic != 0u ? 1.0 : precise_dot(offset, camera.forward_ws);
    return project_offset(camera, offset, distance, size_px);
}

// What is infinitely far in a direction; perspective cameras only.
FilmPoint project_direction(Camera camera, vec3 direction_ws, vec2 size_px) {
    return project_offset(camera, direction_ws, precise_dot(direction_ws, camera.forward_ws), size_px);
}

// Previous minus current position; +infinity for what was not in front of the previous camera.
vec2 film_motion(FilmPoint before, FilmPoint now) {
    precise const vec2 motion = before.film_px - now.film_px;
    return before.in_front ? motion : vec2(uintBitsToFloat(0x7F800000u));
}
#endif
