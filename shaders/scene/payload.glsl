// Ray payloads of the pipeline way, shared by raygen and the hit and miss shaders: 24 bytes. With SHADE_IN_HIT the closest-hit and
// miss shaders shade the vertices of paths, and the payload has 180 bytes (212 with LAYERS); 64 of them are for the first surface only.
#ifndef PARHELION_SCENE_PAYLOAD_GLSL
#define PARHELION_SCENE_PAYLOAD_GLSL
#include "shared/hit.h"
#ifdef SHADE_IN_HIT
#include "scene/path_state.glsl"

// What the path brings to its vertex, and what the vertex gives back in the same place; see vertex_payload.glsl.
struct VertexPayload {
    vec3 throughput;
    float travelled;
    vec3 arriving;
    vec3 origin_ws, direction_ws;              // the path's next ray
    vec3 event_origin_ws, event_direction_ws;  // the shadow ray, and what it adds if it is free
    float event_reach;
    vec3 event_diffuse, event_specular;
    vec3 diffuse_share;  // this and `first` at the first surface only
    FirstHit first;
#ifdef LAYERS
    vec3 event_transmission;
    float radiance_scale;
    MediumStack media;
#endif
};
#endif

struct ClosestPayload {
    Hit hit;
    uint alpha_key;
#ifdef SHADE_IN_HIT
    VertexPayload vertex;
#endif
};

const uint kMissClosest = 0u;  // index of the miss shader
const uint kMissShadow = 1u;

#endif
