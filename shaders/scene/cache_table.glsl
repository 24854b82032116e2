// The world cache's buffer (shared/cache.h), and random numbers of its cells.
#ifndef PARHELION_SCENE_CACHE_TABLE_GLSL
#define PARHELION_SCENE_CACHE_TABLE_GLSL
#include "lib/cache_cell.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Cache { CacheHeader v; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer CacheWords64 { uint64_t v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CacheWords { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CacheSamples { vec3 v[]; };

// Random words of a cell and frame.
uvec4 cache_random(uint64_t key, uint frame_index, uint seed, uint purpose) {
    return pcg4d(uvec4(uint(key), uint(key >> 32) & 0x7FFFFFFFu, frame_index, hash_combine(seed, purpose)));
}
const uint kCacheForChoice = 0u, kCacheForRounding = 1u, kCacheForPaths = 2u;

// Where the sample of an update will be lies, until then, the claim that it starts from.
void cache_keep_claim(Cache cache, uint update, uint64_t claim) {
    CacheWords(cache.v.samples).v[3u * update] = uint(claim);
    CacheWords(cache.v.samples).v[3u * update + 1u] = uint(claim >> 32);
}
uint64_t cache_kept_claim(Cache cache, uint update) {
    return uint64_t(CacheWords(cache.v.samples).v[3u * update]) | (uint64_t(CacheWords(cache.v.samples).v[3u * update + 1u]) << 32);
}
#endif
