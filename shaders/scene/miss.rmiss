#version 460
// Miss of a closest-hit ray: the payload was preset to a miss. With SHADE_IN_HIT it adds the sky, where a path asks for its vertex.
// Reads and writes: nothing; SHADE_IN_HIT: reads scene, view, payload, writes payload.
// variants: SHADE_IN_HIT LAYERS+SHADE_IN_HIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#ifdef SHADE_IN_HIT
#include "scene/payload.glsl"

layout(location = 0) rayPayloadInEXT ClosestPayload payload;

#include "scene/hit_view.glsl"
#include "scene/vertex_payload.glsl"

void main() {
    if (!asks_vertex()) return;
    PathState path = asked_path(Ray(gl_WorldRayOriginEXT, gl_RayTminEXT, gl_WorldRayDirectionEXT, kInfinity, payload.alpha_key));
    const bool at_first = path.path_class.bounce == 0u;
    FirstHit first;
    if (at_first) first = payload.vertex.first;
    const VertexResult vertex = end_in_sky(push.view.data, path, first);
    answer_vertex(path, vertex, at_first, first);
}
#else
void main() {}
#endif
