#version 460
// Chooses the cells that this frame updates, each by a random number of its key and the frame against the share of its class, and keeps
// their claims as they are now.
// Reads and writes: cache.
#extension GL_GOOGLE_include_directive : require
#include "cache/cells.glsl"

layout(local_size_x = kCacheGroup) in;
layout(push_constant, scalar) uniform Push {
    Cache cache;
} push;

shared uint chosen_count, first_place;

void main() {
    const uint i = cache_invocation();
    if (gl_LocalInvocationIndex == 0u) chosen_count = 0u;
    barrier();
    uint slot = kCacheNoSlot, place = 0u;
    if (i < push.cache.v.live) {
        slot = CacheWords(push.cache.v.lists[push.cache.v.list]).v[i];
        const uint64_t key = CacheWords64(push.cache.v.keys).v[slot];
        const float u = uint_to_unit_float(cache_random(key, push.cache.v.frame_index, push.cache.v.seed, kCacheForChoice).x);
        if (u < push.cache.v.class_share[cache_slot_class(push.cache, slot, key)]) place = atomicAdd(chosen_count, 1u);
        else slot = kCacheNoSlot;
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) first_place = atomicAdd(push.cache.v.update_count, chosen_count);
    barrier();
    if (slot == kCacheNoSlot || first_place + place >= push.cache.v.update_capacity) return;
    CacheWords(push.cache.v.updates).v[first_place + place] = slot;
    // Rays of the update will claim this very cell anew while others start from it.
    cache_keep_claim(push.cache, first_place + place, CacheWords64(push.cache.v.claims).v[slot]);
}
