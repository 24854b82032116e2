#version 460
// Goes over the cells that lived at the end of the last frame: takes in those that came then, lets the others age, rescales them to a
// new exposure, gives up those whose life is over, and writes the list of those that stay. Work follows live cells, not capacity.
// Reads and writes: cache.
#extension GL_GOOGLE_include_directive : require
#include "cache/cells.glsl"

layout(local_size_x = kCacheGroup) in;
layout(push_constant, scalar) uniform Push {
    Cache cache;
} push;

shared uint class_count[kCachePriorities];
shared uint stay_count, first_place, born_count, died_count, rejected_count;

void forget(uint slot) {
    CacheWords64(push.cache.v.keys).v[slot] = kCacheNoKey;
    CacheWords64(push.cache.v.claims).v[slot] = kCacheNoClaim;
}

// A cell came into a bucket that overflowed in the same frame.
bool came_too_many(uint64_t key) {
    const uint bucket = CacheWords(push.cache.v.buckets).v[cache_bucket(key, push.cache.v.bucket_mask)];
    return bucket != 0u && bucket >> 8 == (push.cache.v.frame_before & 0xFFFFFFu);
}

void take_in(uint slot, uint64_t key) {
    CacheWords64(push.cache.v.keys).v[slot] = key & ~kCacheNewborn;
    CacheWords64(push.cache.v.irradiance).v[slot] = 0ul;
    CacheWords(push.cache.v.moments).v[slot] = 0u;
}

void grow_older(uint slot) {
    const uint before_now = CacheWords(push.cache.v.moments).v[slot];
    uint moments = before_now;
    if (((moments >> kCacheAgeShift) & kCacheOldest) < kCacheOldest) moments += 1u << kCacheAgeShift;
    if (push.cache.v.forgets != 0u) moments = moments & ~kCacheCountMask | min(moments & kCacheCountMask, 1u);
    if (moments != before_now) CacheWords(push.cache.v.moments).v[slot] = moments;
    if (push.cache.v.exposure_ratio == 1.0) return;
    const vec3 before = cache_unpack_irradiance(CacheWords64(push.cache.v.irradiance).v[slot]);
    CacheWords64(push.cache.v.irradiance).v[slot] = cache_pack_irradiance(before * push.cache.v.exposure_ratio);
}

// False: it is gone.
bool keep(uint slot, uint64_t key) {
    const uint64_t claim = CacheWords64(push.cache.v.claims).v[slot];
    const bool newborn = (key & kCacheNewborn) != 0ul, undone = newborn && came_too_many(key);
    const uint life = cache_claim_life(claim);
    if (undone || life == 0u) {
        forget(slot);
        if (undone) atomicAdd(rejected_count, 1u);
        else atomicAdd(died_count, 1u);
        return false;
    }
    CacheWords64(push.cache.v.claims).v[slot] = cache_old_claim(claim, life - 1u, cache_salt(push.cache.v.frame_before));
    if (newborn) {
        take_in(slot, key);
        atomicAdd(born_count, 1u);
    } else grow_older(slot);
    return true;
}

void main() {
    const uint here = gl_LocalInvocationIndex, first = cache_invocation() / kCacheGroup * kCacheMaintained;
    class_count[here] = 0u;
    if (here == 0u) stay_count = born_count = died_count = rejected_count = 0u;
    barrier();
    uint slots[kCacheMaintained], places[kCacheMaintained];
    for (uint k = 0u; k < kCacheMaintained; ++k) {
        const uint i = (first + k) * kCacheGroup + here;
        slots[k] = kCacheNoSlot;
        if (i >= push.cache.v.live_before) continue;
        const uint slot = CacheWords(push.cache.v.lists[push.cache.v.list ^ 1u]).v[i];
        const uint64_t key = CacheWords64(push.cache.v.keys).v[slot];
        if (!keep(slot, key)) continue;
        slots[k] = slot;
        places[k] = atomicAdd(stay_count, 1u);
        atomicAdd(class_count[cache_slot_class(push.cache, slot, key)], 1u);
    }
    barrier();
    if (here == 0u) {
        first_place = atomicAdd(push.cache.v.live, stay_count);
        if (born_count != 0u) atomicAdd(push.cache.v.born, born_count);
        if (died_count != 0u) atomicAdd(push.cache.v.died, died_count);
        if (rejected_count != 0u) atomicAdd(push.cache.v.rejected, rejected_count);
    }
    if (class_count[here] != 0u) atomicAdd(push.cache.v.class_count[here], class_count[here]);
    barrier();
    for (uint k = 0u; k < kCacheMaintained; ++k)
        if (slots[k] != kCacheNoSlot) CacheWords(push.cache.v.lists[push.cache.v.list]).v[first_place + places[k]] = slots[k];
}
