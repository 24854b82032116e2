#version 460
// World cache test: in place of the update's rays, the same irradiance at every cell that this frame updates.
// Reads: cache. Writes: found, passing.
#extension GL_GOOGLE_include_directive : require
#define CACHE_ACCESS readonly
#include "cache/update.glsl"

layout(local_size_x = 64) in;
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer CacheUpdates { CacheUpdate v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) writeonly buffer CachePassing { vec4 v[]; };
layout(push_constant, scalar) uniform Push {
    Cache cache;
    CacheUpdates found;
    CachePassing passing;
    vec3 irradiance;
} push;

void main() {
    const uint i = gl_GlobalInvocationID.x;
    if (i >= push.cache.v.update_count) return;
    push.found.v[i] = CacheUpdate(push.irradiance / push.cache.v.exposure, kCacheNoSlot, vec3(0.0), 0.0, vec3(0.0), 0.0, vec3(0.0), 0u);
    push.passing.v[i] = vec4(0.0);
}
