#version 460
// Closest hit of the pipeline way: says which triangle, nothing else. Reads: hit attributes. Writes: payload.
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#include "scene/payload.glsl"
#include "scene/scene.glsl"

layout(location = 0) rayPayloadInEXT ClosestPayload payload;
hitAttributeEXT vec2 barycentrics;

void main() {
    const uint instance = gl_InstanceCustomIndexEXT;
    payload.hit.instance_bits = instance | ((scene_instance(instance).flags & kInstanceDeforms) << 30);
    payload.hit.geometry = gl_GeometryIndexEXT;
    payload.hit.primitive = gl_PrimitiveID;
    payload.hit.barycentrics = packUnorm2x16(barycentrics);
    payload.hit.t = gl_HitTEXT;
}
