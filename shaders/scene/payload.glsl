// Ray payloads of the pipeline way, shared by raygen and the hit and miss shaders.
#ifndef PARHELION_SCENE_PAYLOAD_GLSL
#define PARHELION_SCENE_PAYLOAD_GLSL
#include "shared/hit.h"

struct ClosestPayload {
    Hit hit;
    uint alpha_key;
};

const uint kMissClosest = 0u;  // index of the miss shader
const uint kMissShadow = 1u;

#endif
