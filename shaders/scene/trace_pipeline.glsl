// Tracing by traceRayEXT from raygen, recursion depth 1. Shadow rays skip closest-hit; any-hit reads the same payload.
#include "scene/payload.glsl"

layout(set = 0, binding = 0) uniform accelerationStructureEXT top_now;
layout(set = 0, binding = 1) uniform accelerationStructureEXT top_before;
layout(location = 0) rayPayloadEXT ClosestPayload payload;

Hit trace_closest(Ray ray, uint mask) {
    payload.hit = make_miss();
    payload.alpha_key = ray.alpha_key;
    const uint flags = scene.header.culling != 0u ? gl_RayFlagsCullBackFacingTrianglesEXT : gl_RayFlagsNoneEXT;
    traceRayEXT(top_now, flags, mask, 0u, 0u, kMissClosest, ray.origin_ws, ray.t_min, ray.direction_ws, ray.t_max, 0);
    return payload.hit;
}

bool trace_visible(Ray ray, uint moment, uint mask) {
    payload.hit.instance_bits = 0u;
    payload.alpha_key = ray.alpha_key;
    const uint flags = gl_RayFlagsTerminateOnFirstHitEXT | gl_RayFlagsSkipClosestHitShaderEXT |
                       (scene.header.culling != 0u ? gl_RayFlagsCullBackFacingTrianglesEXT : gl_RayFlagsNoneEXT);
    if (moment == kNow)
        traceRayEXT(top_now, flags, mask, 0u, 0u, kMissShadow, ray.origin_ws, ray.t_min, ray.direction_ws, ray.t_max, 0);
    else
        traceRayEXT(top_before, flags, mask, 0u, 0u, kMissShadow, ray.origin_ws, ray.t_min, ray.direction_ws, ray.t_max, 0);
    return is_miss(payload.hit);
}
