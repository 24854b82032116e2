// What hit and miss shaders that shade share: the view, and the vertex that a path asks for. Included where `payload` is declared; a
// pass that lets them shade begins its push constants with the view's address.
#ifndef PARHELION_SCENE_ASKED_VERTEX_GLSL
#define PARHELION_SCENE_ASKED_VERTEX_GLSL
#include "scene/vertex_payload.glsl"
#include "shared/view.h"

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
layout(push_constant, scalar) uniform Push { ViewBlock view; } push;

struct AskedVertex {
    PathState path;
    bool at_first;   // the path came to its first surface
    FirstHit first;  // of which this is told
};

// Read before the answer takes its place in the payload.
AskedVertex asked_vertex() {
    AskedVertex asked;
    asked.path = asked_path(Ray(gl_WorldRayOriginEXT, gl_RayTminEXT, gl_WorldRayDirectionEXT, kInfinity, payload.alpha_key));
    asked.at_first = asked.path.path_class.bounce == 0u;
    if (asked.at_first) asked.first = payload.vertex.first;
    return asked;
}
#endif
