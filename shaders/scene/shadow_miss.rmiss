#version 460
// Miss of a shadow ray: the light is visible. Reads: nothing. Writes: payload.
// variants: SHADE_IN_HIT LAYERS+SHADE_IN_HIT
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#include "scene/payload.glsl"

layout(location = 0) rayPayloadInEXT ClosestPayload payload;

void main() { payload.hit.instance_bits = kHitMiss; }
