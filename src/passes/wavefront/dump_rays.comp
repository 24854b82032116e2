#version 460
// Keeps the rays that Extend, or with SHADOWS Connect, has just traced, in the order of their list: for replay_rays.trace.
// Reads: control, lists, rays (SHADOWS: shadow_list, shadow_rays). Writes: dump.
// variants: SHADOWS
#extension GL_GOOGLE_include_directive : require
#include "scene/ray.glsl"
#include "wavefront/linear.glsl"
#include "wavefront/lists.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer RayDump { DumpedRay v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ShadowList { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer ShadowRays { WavefrontShadowRay v[]; };
layout(push_constant, scalar) uniform Push {
    Control control;
    RayDump dump;
#ifdef SHADOWS
    ShadowList shadow_list;
    ShadowRays shadow_rays;
#else
    Lists lists;
    Rays rays;
#endif
    uint list;
} push;

void main() {
    const uint i = invocation_index();
    if (i >= push.control.v.count[push.list]) return;
#ifdef SHADOWS
    const WavefrontShadowRay ray = push.shadow_rays.v[push.shadow_list.v[i]];
    push.dump.v[i] = DumpedRay(ray.origin_ws, ray.t_max, ray.direction_ws, ray.alpha_key);
#else
    const WavefrontRay ray = push.rays.v[push.lists.v[list_at(push.control, push.list, i)]];
    push.dump.v[i] = DumpedRay(ray.origin_ws, kInfinity, ray.direction_ws, ray.alpha_key);
#endif
}
