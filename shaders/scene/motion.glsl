// Where what a pixel sees was on the previous frame's picture.
#ifndef PARHELION_SCENE_MOTION_GLSL
#define PARHELION_SCENE_MOTION_GLSL
#include "lib/projection.glsl"
#include "scene/previous.glsl"
#include "scene/surface.glsl"

// The surface's point, now and a frame ago. The same arithmetic for both moments: what stands still does not move.
void find_moments(Surface s, out vec3 now_ws, out vec3 before_ws) {
    const Instance instance = scene_instance(s.instance);
    const Geometry geometry = scene_geometry(instance.geometry_base + s.geometry);
    const uvec3 index = IndexArray(geometry.indices).v[s.primitive];
    PositionArray positions = PositionArray(geometry.positions), positions_before = PositionArray(scene_geometry(geometry_base_before(s.instance) + s.geometry).positions);
    const vec3 weights = vec3(1.0 - s.barycentrics.x - s.barycentrics.y, s.barycentrics);
    const vec3 p = interpolate(weights, positions.v[index.x], positions.v[index.y], positions.v[index.z]);
    const vec3 p_before = interpolate(weights, positions_before.v[index.x], positions_before.v[index.y], positions_before.v[index.z]);
    vec3 ignored;
    now_ws = transform_point_precise(instance.world_from_object, p, vec3(0.0), ignored);
    before_ws = transform_point_precise(placement_before(s.instance), p_before, vec3(0.0), ignored);
}

vec2 point_motion(ViewData view, vec3 now_ws, vec3 before_ws) {
    const vec2 size_px = vec2(view.width, view.height);
    return film_motion(project_point(view.camera_before, before_ws, size_px), project_point(view.camera, now_ws, size_px));
}

// Motion of the surface's point with its instance and the camera.
vec2 surface_motion(ViewData view, Surface s) {
    vec3 now_ws, before_ws;
    find_moments(s, now_ws, before_ws);
    return point_motion(view, now_ws, before_ws);
}

// Of what is infinitely far in this direction. It stands still for an orthographic camera, which sees one direction everywhere.
vec2 sky_motion(ViewData view, vec3 direction_ws) {
    if (view.camera.orthographic != 0u || view.camera_before.orthographic != 0u) return vec2(0.0);
    const vec2 size_px = vec2(view.width, view.height);
    return film_motion(project_direction(view.camera_before, direction_ws, size_px), project_direction(view.camera, direction_ws, size_px));
}
#endif
