// The two trace functions, equal in all three ways, and the entry point of a tracing pass:
//     Hit  trace_closest(Ray ray)
//     bool trace_visible(Ray ray, uint moment)     kNow | kBefore (the previous frame's scene)
// A tracing pass defines `void invoke(uvec2 id)`; it uses no shared memory, barrier, workgroup id or subgroup operation.
#ifndef PARHELION_SCENE_TRACE_GLSL
#define PARHELION_SCENE_TRACE_GLSL
#include "scene/scene.glsl"
#include "shared/hit.h"

#if defined(TRACE_PIPELINE)
#extension GL_EXT_ray_tracing : require
#elif defined(TRACE_QUERY)
#extension GL_EXT_ray_query : require
#endif

const uint kNow = 0u;
const uint kBefore = 1u;

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

void invoke(uvec2 id);

#if defined(TRACE_PIPELINE)
#include "scene/trace_pipeline.glsl"
#elif defined(TRACE_QUERY)
#include "scene/trace_query.glsl"
#elif defined(TRACE_COMPUTE)
#include "scene/trace_compute.glsl"
#endif

#if defined(TRACE_PIPELINE)
void main() { invoke(gl_LaunchIDEXT.xy); }
#else
// A tile of 8x4 keeps the rays of a subgroup close together.
layout(local_size_x = 8, local_size_y = 4) in;
void main() { invoke(gl_GlobalInvocationID.xy); }
#endif
#endif
