// Tracing by ray query in a compute shader.
#include "scene/alpha.glsl"
#include "scene/proxy.glsl"

layout(set = 0, binding = 0) uniform accelerationStructureEXT top_now;
layout(set = 0, binding = 1) uniform accelerationStructureEXT top_before;

// Runs a query to its end, asking accept_hit for every non-opaque candidate.
void run_query(rayQueryEXT query, uint alpha_key) {
    while (rayQueryProceedEXT(query)) {
        if (accept_hit(alpha_key, rayQueryGetIntersectionInstanceCustomIndexEXT(query, false), rayQueryGetIntersectionGeometryIndexEXT(query, false),
                       rayQueryGetIntersectionPrimitiveIndexEXT(query, false), rayQueryGetIntersectionBarycentricsEXT(query, false),
                       rayQueryGetIntersectionFrontFaceEXT(query, false)))
            rayQueryConfirmIntersectionEXT(query);
    }
}

Hit trace_closest(Ray ray, uint mask) {
    rayQueryEXT query;
    const uint flags = scene.header.culling != 0u ? gl_RayFlagsCullBackFacingTrianglesEXT : gl_RayFlagsNoneEXT;
    rayQueryInitializeEXT(query, top_now, flags, mask, ray.origin_ws, ray.t_min, ray.direction_ws, ray.t_max);
    run_query(query, ray.alpha_key);
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) return make_miss();
    Hit hit;
    const uint instance = rayQueryGetIntersectionInstanceCustomIndexEXT(query, true);
    hit.instance_bits = instance | ((scene_instance(instance).flags & kInstanceDeforms) << 30);
    hit.geometry = rayQueryGetIntersectionGeometryIndexEXT(query, true);
    hit.primitive = traced_primitive(instance, hit.geometry, rayQueryGetIntersectionPrimitiveIndexEXT(query, true));
    hit.barycentrics = packUnorm2x16(rayQueryGetIntersectionBarycentricsEXT(query, true));
    hit.t = rayQueryGetIntersectionTEXT(query, true);
    return hit;
}

bool trace_visible(Ray ray, uint moment, uint mask) {
    rayQueryEXT query;
    const uint flags = gl_RayFlagsTerminateOnFirstHitEXT | (scene.header.culling != 0u ? gl_RayFlagsCullBackFacingTrianglesEXT : gl_RayFlagsNoneEXT);
    if (moment == kNow)
        rayQueryInitializeEXT(query, top_now, flags, mask, ray.origin_ws, ray.t_min, ray.direction_ws, ray.t_max);
    else
        rayQueryInitializeEXT(query, top_before, flags, mask, ray.origin_ws, ray.t_min, ray.direction_ws, ray.t_max);
    run_query(query, ray.alpha_key);
    return rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT;
}
