#version 460
// Which triangle a pixel sees. ASKED: of what masks, blends or has an inside, only where the traced ray through the pixel's centre would
// accept the hit, by the same function with the same key. Reads: ASKED: scene, view. Writes: identity.
// variants: ASKED
#extension GL_GOOGLE_include_directive : require
#ifdef ASKED
#include "gbuffer/visible.glsl"
#include "lib/ray_triangle.glsl"
#include "scene/alpha.glsl"
#include "scene/camera.glsl"
#endif

layout(location = 0) flat in uvec3 ids;
layout(location = 0) out uvec4 identity;

#ifdef ASKED
// Where the ray meets the triangle, as fetch_surface() has it.
vec2 canonical_barycentrics(Ray ray, uint instance) {
    const Affine world_from_object = scene_instance(instance).world_from_object;
    const Geometry geometry = scene_geometry(scene_instance(instance).geometry_base + ids.y);
    const uvec3 index = IndexArray(geometry.indices).v[ids.z];
    PositionArray positions = PositionArray(geometry.positions);
    vec3 ignored;
    const vec3 p0 = transform_point_precise(world_from_object, positions.v[index.x], vec3(0.0), ignored);
    const vec3 p1 = transform_point_precise(world_from_object, positions.v[index.y], vec3(0.0), ignored);
    const vec3 p2 = transform_point_precise(world_from_object, positions.v[index.z], vec3(0.0), ignored);
    float t;
    vec2 found;
    intersect_canonical(ray.origin_ws, ray.direction_ws, p0, p1, p2, t, found);
    return found;
}

bool accepted() {
    const ViewData view = push.view.data;
    const uvec2 pixel = uvec2(gl_FragCoord.xy);
    const Ray ray = camera_ray(view.camera, vec2(pixel) + 0.5 + view.jitter, vec2(view.width, view.height), hash_ray(pixel, push.frame_index, view.seed, 0u, kRayPath));
    const uint instance = ids.x & kHitInstanceMask;
    return accept_hit(ray.alpha_key, instance, ids.y, ids.z, canonical_barycentrics(ray, instance), gl_FrontFacing);
}
#endif

void main() {
#ifdef ASKED
    if (!accepted()) discard;
#endif
    identity = uvec4(ids, 0u);
}
