#version 460
// Closest hit of the pipeline way: says which triangle. With SHADE_IN_HIT it also shades the vertex, where a path asks for it.
// Reads: hit attributes; SHADE_IN_HIT: scene, view, payload. Writes: payload.
// variants: SHADE_IN_HIT LAYERS+SHADE_IN_HIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#include "scene/payload.glsl"
#include "scene/proxy.glsl"

layout(location = 0) rayPayloadInEXT ClosestPayload payload;
hitAttributeEXT vec2 barycentrics;

Hit this_hit() {
    const uint instance = gl_InstanceCustomIndexEXT;
    return Hit(instance | ((scene_instance(instance).flags & kInstanceDeforms) << 30), gl_GeometryIndexEXT, traced_primitive(instance, gl_GeometryIndexEXT, gl_PrimitiveID),
               packUnorm2x16(barycentrics), gl_HitTEXT);
}

#ifdef SHADE_IN_HIT
#include "scene/asked_vertex.glsl"

void shade(Hit hit) {
    const ViewData view = push.view.data;
    AskedVertex asked = asked_vertex();
    const VertexResult vertex = shade_vertex(view, asked_key(view), hit, asked.path, asked.first);
    answer_vertex(asked.path, vertex, asked.at_first, asked.first);
}

void main() {
    const Hit hit = this_hit();
    if (asks_vertex()) shade(hit);
    else payload.hit = hit;
}
#else
void main() { payload.hit = this_hit(); }
#endif
