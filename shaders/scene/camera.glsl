// Camera rays.
#ifndef PARHELION_SCENE_CAMERA_GLSL
#define PARHELION_SCENE_CAMERA_GLSL
#include "lib/camera_motion.glsl"
#include "lib/geometry.glsl"
#include "lib/sampler.glsl"
#include "lib/warp.glsl"
#include "scene/ray.glsl"
#include "shared/view.h"

// The same bits in every way to trace. The ray through a film position in pixels (x to the right, y down, pixel centres at .5) and
// the middle of the lens.
Ray camera_ray(Camera camera, vec2 film_px, vec2 size_px, uint alpha_key) {
    precise const vec2 p = vec2(2.0 * film_px.x / size_px.x - 1.0, 1.0 - 2.0 * film_px.y / size_px.y);
    precise const vec3 offset = p.x * camera.right_ws + p.y * camera.up_ws;
    precise const vec3 origin = camera.position_ws + offset, through = camera.forward_ws + offset;
    if (camera.orthographic != 0u) return Ray(origin, 0.0, camera.forward_ws, kInfinity, alpha_key);
    return Ray(camera.position_ws, 0.0, precise_normalize(through), kInfinity, alpha_key);
}

// The ray from another point of the lens (of the unit disk: x to the right, y up) that meets the first one in the plane of focus.
// Cook, Porter, Carpenter 1984. The picture of what lies in that plane stays, so a point at depth z blurs to a disk of diameter
// 2 lens_radius |z - focus_distance| / focus_distance in the plane z.
Ray bend_through_lens(Camera camera, Ray ray, vec2 lens) {
    precise const vec3 from_middle = camera.lens_radius * (lens.x * precise_normalize(camera.right_ws) + lens.y * precise_normalize(camera.up_ws));
    precise const vec3 to_focus = ray.direction_ws * (camera.focus_distance / precise_dot(ray.direction_ws, camera.forward_ws));
    precise const vec3 origin = ray.origin_ws + from_middle, along = to_focus - from_middle;
    ray.origin_ws = origin;
    ray.direction_ws = precise_normalize(along);
    return ray;
}

// The ray of a sample: at its moment of the shutter, from a point uniform on the lens. The filter takes dimensions 0 and 1, the lens 2
// and 3. A ray cone is the pixel's with or without a lens: the footprint of a pixel seen from one point of the lens is as large.
Ray sample_camera_ray(ViewData view, uvec2 pixel, PathSampler samples, uint alpha_key) {
    Camera camera = view.camera;
    if ((view.flags & kViewShutter) != 0u) camera = camera_at(camera, view.motion, shutter_share(samples.sample_index, view.seed));
    start_bounce(samples, 0u);
    const vec2 in_pixel = view.pixel_filter == kFilterPoint ? vec2(0.5) + view.jitter : next_2d(samples);
    const Ray ray = camera_ray(camera, vec2(pixel) + in_pixel, vec2(view.width, view.height), alpha_key);
    if (camera.lens_radius == 0.0) return ray;
    samples.dimension = 2u;
    return bend_through_lens(camera, ray, sample_concentric_disk(next_2d(samples)));
}
#endif
