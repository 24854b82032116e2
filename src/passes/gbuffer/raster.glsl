// How the camera projects triangles for the raster passes: the inverse of camera_ray() for pixel centres (scene/camera.glsl).
#ifndef PARHELION_PASSES_GBUFFER_RASTER_GLSL
#define PARHELION_PASSES_GBUFFER_RASTER_GLSL
#include "lib/affine.glsl"
#include "lib/geometry.glsl"
#include "shared/raster.h"
#include "shared/view.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DrawnArray { DrawnGeometry v[]; };

// Metres in front of a perspective camera where drawing begins. A float of reversed depth has the same relative precision whatever this is
// (the depth near / z goes by its logarithm, down to 1e-38), so it is as small as nobody cares for.
const float kRasterNear = 9.5367431640625e-7;  // 2^-20

// x and y in the image's half extents times z (orthographic: in half extents), y up; z metres along the camera's axis.
vec3 to_view(Camera camera, vec3 position_ws) {
    precise const vec3 q = position_ws - camera.position_ws;
    precise const float x = precise_dot(q, camera.right_ws) / precise_dot(camera.right_ws, camera.right_ws);
    precise const float y = precise_dot(q, camera.up_ws) / precise_dot(camera.up_ws, camera.up_ws);
    return vec3(x, y, precise_dot(q, camera.forward_ws));
}

// Depth is reversed: near / z without a far end; of an orthographic camera 1 - z / far, since depth runs evenly between corners.
vec4 to_clip(Camera camera, vec3 v, float far) {
    precise const float linear = 1.0 - v.z / far;
    return camera.orthographic != 0u ? vec4(v.x, -v.y, linear, 1.0) : vec4(v.x, -v.y, kRasterNear, v.z);
}
#endif
