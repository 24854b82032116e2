// Rays and what they meet.
#ifndef PARHELION_SCENE_RAY_GLSL
#define PARHELION_SCENE_RAY_GLSL
#include "shared/hit.h"

const uint kNow = 0u;     // moments of trace_visible
const uint kBefore = 1u;  // the previous frame's scene
const uint kAllInstances = 0xFFu;  // a ray mask: sees the instances whose mask shares a bit

struct Ray {
    vec3 origin_ws;
    float t_min;
    vec3 direction_ws;  // unit
    float t_max;
    uint alpha_key;  // hash of (pixel, sample, bounce, ray kind) for alpha tests
};

const float kInfinity = 3.4e38;

bool is_miss(Hit hit) { return hit.instance_bits == kHitMiss; }
uint hit_instance(Hit hit) { return hit.instance_bits & kHitInstanceMask; }
Hit make_miss() { return Hit(kHitMiss, 0u, 0u, 0u, kInfinity); }
#endif
