#version 460
// Empties the table: no slot holds a key or a claim, and every bucket lets everything in.
// Reads: cache (its header). Writes: cache.
#extension GL_GOOGLE_include_directive : require
#include "cache/cells.glsl"

layout(local_size_x = kCacheGroup) in;
layout(push_constant, scalar) uniform Push {
    Cache cache;
} push;

void main() {
    const uint slot = cache_invocation();
    if (slot >= push.cache.v.slot_count) return;
    CacheWords64(push.cache.v.keys).v[slot] = kCacheNoKey;
    CacheWords64(push.cache.v.claims).v[slot] = kCacheNoClaim;
    if (slot <= push.cache.v.bucket_mask) CacheWords(push.cache.v.buckets).v[slot] = 0u;
}
