#version 460
// World cache test: in place of the update's rays, the same irradiance at every cell that this frame updates.
// Reads and writes: cache.
#extension GL_GOOGLE_include_directive : require
#include "scene/cache_table.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push {
    Cache cache;
    vec3 irradiance;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i < push.cache.v.update_count) CacheSamples(push.cache.v.samples).v[i] = push.irradiance;
}
