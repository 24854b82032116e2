// The two trace functions, equal in all three ways, and the entry point of a tracing pass:
//     Hit  trace_closest(Ray ray)
//     bool trace_visible(Ray ray, uint moment)
// A tracing pass defines `void invoke(uvec2 id)`; it uses no shared memory, barrier, workgroup id or subgroup operation.
#ifndef PARHELION_SCENE_TRACE_GLSL
#define PARHELION_SCENE_TRACE_GLSL
#include "scene/ray.glsl"
#include "scene/scene.glsl"

#if defined(TRACE_PIPELINE)
#extension GL_EXT_ray_tracing : require
#elif defined(TRACE_QUERY)
#extension GL_EXT_ray_query : require
#endif

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
// A tile of 8x4 keeps the rays of a subgroup close together; in Morton order, those of a subgroup of 8 or 16 too.
layout(local_size_x = 8, local_size_y = 4) in;
void main() {
    const uvec2 id = gl_GlobalInvocationID.xy, at = id & uvec2(7u, 3u);  // of the tile: by rows, as subgroups are made
    const uvec2 in_order = uvec2((at.x & 1u) | (at.x >> 1 & 2u) | (at.y << 1 & 4u), (at.x >> 1 & 1u) | (at.y << 1 & 2u));
    invoke((id - at) + in_order);
}
#endif
#endif
