// The path's next vertex by hit and miss shaders that shade, as document 002 has it (SHADE_IN_HIT): they return candidates, and shadow
// rays are traced here, in raygen, so that rays never nest.
#include "scene/vertex_payload.glsl"

VertexResult next_vertex(ViewData view, PathKey key, inout PathState path, inout FirstHit first) {
    ask_vertex(key, path, first);
    const uint flags = scene.header.culling != 0u ? gl_RayFlagsCullBackFacingTrianglesEXT : gl_RayFlagsNoneEXT;
    traceRayEXT(top_now, flags, kAllInstances, 0u, 0u, kMissClosest, path.ray.origin_ws, path.ray.t_min, path.ray.direction_ws, path.ray.t_max, 0);
    return take_vertex(key, path, first);
}
