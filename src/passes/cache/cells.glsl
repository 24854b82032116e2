// What the passes that keep the world cache's books have in common.
#ifndef PARHELION_CACHE_CELLS_GLSL
#define PARHELION_CACHE_CELLS_GLSL
#include "scene/cache_table.glsl"

// The invocation's number in an indirect dispatch of rows.
#define cache_invocation() (gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x)

// How often a class of cells is updated, before the budget bounds it.
float cache_class_rate(uint priority) { return exp2(-float(priority) / 3.0); }

const float kCacheChangeRate = 1.0 / 8.0;

// The part of a cell's trend that cannot be its noise. Whatever favours cells that a bright sample has just raised, as noise alone would,
// makes the cache too dark on average.
float cache_trend(CacheMoments moments) {
    const float kDeviations = 3.0;
    // A running mean of rate r of independent numbers has r / (2 - r) of their variance.
    const float noise = kDeviations * sqrt(moments.spread * (kCacheChangeRate / (2.0 - kCacheChangeRate)));
    return clamp(abs(moments.change) - noise, 0.0, 1.0);
}

// What is to be known soon comes first: cells that a pixel saw, young ones, those whose light changes, noisy ones; coarse ones later.
uint cache_class(CacheMoments moments, uint life, uint full_life, uint level) {
    const float kHighest = 12.0;
    float octaves = life + 1u >= full_life ? 2.0 : 0.0;
    octaves += 4.0 * (1.0 - min(cache_worth(moments.count) / float(kCacheYoung), 1.0));
    octaves += log2(1.0 + 15.0 * cache_trend(moments));
    octaves += moments.count == 0u ? 2.0 : min(log2(1.0 + sqrt(moments.spread / cache_worth(moments.count)) * 4.0), 2.0);
    octaves -= 0.25 * float(level);
    return min(uint(max((kHighest - octaves) * 3.0, 0.0)), kCachePriorities - 1u);
}
uint cache_slot_class(Cache cache, uint slot, uint64_t key) {
    const uint life = cache_claim_life(CacheWords64(cache.v.claims).v[slot]);
    return cache_class(cache_unpack_moments(CacheWords(cache.v.moments).v[slot]), life, cache.v.life, cache_key_level(key));
}

#endif
