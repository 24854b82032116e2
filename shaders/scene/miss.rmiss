#version 460
// Miss of a closest-hit ray: the payload was preset to a miss. With SHADE_IN_HIT it adds the sky, where a path asks for its vertex.
// Reads and writes: nothing; SHADE_IN_HIT: reads scene, view, payload, writes payload.
// variants: SHADE_IN_HIT LAYERS+SHADE_IN_HIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#ifdef SHADE_IN_HIT
#include "scene/payload.glsl"

layout(location = 0) rayPayloadInEXT ClosestPayload payload;

#include "scene/asked_vertex.glsl"

void main() {
    if (!asks_vertex()) return;
    AskedVertex asked = asked_vertex();
    const VertexResult vertex = end_in_sky(push.view.data, asked.path, asked.first);
    answer_vertex(asked.path, vertex, asked.at_first, asked.first);
}
#else
void main() {}
#endif
