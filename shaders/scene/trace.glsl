// The two trace functions, equal in all three ways, and the entry point of a tracing pass:
//     Hit  trace_closest(Ray ray [, uint mask])
//     bool trace_visible(Ray ray, uint moment [, uint mask])
// A tracing pass defines `void invoke(uvec2 id)`, with TRACE_LINEAR `void invoke(uint index)`, numbered along the rows; it uses no shared memory, barrier, workgroup id or subgroup operation.
#ifndef PARHELION_SCENE_TRACE_GLSL
#define PARHELION_SCENE_TRACE_GLSL
#include "scene/ray.glsl"
#include "scene/scene.glsl"

#if defined(TRACE_PIPELINE)
#extension GL_EXT_ray_tracing : require
#elif defined(TRACE_QUERY)
#extension GL_EXT_ray_query : require
#endif

#ifdef TRACE_LINEAR
void invoke(uint index);
#else
void invoke(uvec2 id);
#endif

#if defined(TRACE_PIPELINE)
#include "scene/trace_pipeline.glsl"
#elif defined(TRACE_QUERY)
#include "scene/trace_query.glsl"
#elif defined(TRACE_COMPUTE)
#include "scene/trace_compute.glsl"
#endif

Hit trace_closest(Ray ray) { return trace_closest(ray, kAllInstances); }
bool trace_visible(Ray ray, uint moment) { return trace_visible(ray, moment, kAllInstances); }

#if defined(TRACE_PIPELINE) && defined(TRACE_LINEAR)
void main() { invoke(gl_LaunchIDEXT.y * gl_LaunchSizeEXT.x + gl_LaunchIDEXT.x); }
#elif defined(TRACE_PIPELINE)
void main() { invoke(gl_LaunchIDEXT.xy); }
#elif defined(TRACE_LINEAR)
layout(local_size_x = 64) in;
void main() { invoke(gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x); }
#else
// A tile of 8x8 in Morton order keeps the rays of a subgroup close together, of 8, 16 or 32 of them.
layout(local_size_x = 8, local_size_y = 8) in;
void main() {
    const uvec2 id = gl_GlobalInvocationID.xy, at = id & uvec2(7u, 7u);  // of the tile: by rows, as subgroups are made
    const uvec2 in_order = uvec2((at.x & 1u) | (at.x >> 1 & 2u) | (at.y << 1 & 4u), (at.x >> 1 & 1u) | (at.y << 1 & 2u) | (at.y & 4u));
    invoke((id - at) + in_order);
}
#endif
#endif
