// Proxies: where a geometry has one, rays meet the proxy's triangles, which follow the geometry's own in its list of indices. What was found
// without a ray, by rasterisation, is of the geometry's own; rays that leave it must not begin behind the proxy.
#ifndef PARHELION_SCENE_PROXY_GLSL
#define PARHELION_SCENE_PROXY_GLSL
#include "lib/geometry.glsl"
#include "scene/scene.glsl"

// The place in the list of indices of the triangle that an acceleration structure of the driver has at `number`.
uint traced_primitive(uint instance, uint geometry_of_mesh, uint number) {
    if ((scene.header.features & kSceneProxies) == 0u) return number;
    const Geometry geometry = scene_geometry(scene_instance(instance).geometry_base + geometry_of_mesh);
    return geometry.proxy_heights == 0ul ? number : geometry.triangle_count + number;
}

// How far the proxy rises at most over this triangle, on its front side or behind it, in metres along its unit normal; 0 for what rays meet
// themselves. Two floats without their lower halves, rounded up: in units of the object, the front's in the upper half.
float proxy_height(Geometry geometry, uint primitive, bool front, Affine world_from_object, vec3 n_ws) {
    if ((scene.header.features & kSceneProxies) == 0u || geometry.proxy_heights == 0ul || primitive >= geometry.triangle_count) return 0.0;
    const uint heights = UintArray(geometry.proxy_heights).v[primitive];
    // A length along the normal becomes, seen along the world's normal, this many times as long, whatever the transform shears.
    precise const vec3 n = (n_ws.x * world_from_object.row0.xyz + n_ws.y * world_from_object.row1.xyz) + n_ws.z * world_from_object.row2.xyz;
    return sqrt(precise_dot(n, n)) * uintBitsToFloat(front ? heights & 0xFFFF0000u : heights << 16);
}
#endif
