// The world cache's buffer (shared/cache.h), and random numbers of its cells.
#ifndef PARHELION_SCENE_CACHE_TABLE_GLSL
#define PARHELION_SCENE_CACHE_TABLE_GLSL
#include "lib/cache_cell.glsl"

#ifndef CACHE_ACCESS
#define CACHE_ACCESS  // `readonly` in passes that may run beside others of that kind
#endif
layout(buffer_reference, scalar, buffer_reference_align = 16) CACHE_ACCESS buffer Cache { CacheHeader v; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer CacheWords64 { uint64_t v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer CacheWords { uint v[]; };

// Random words of a cell and frame.
uvec4 cache_random(uint64_t key, uint frame_index, uint seed, uint purpose) {
    return pcg4d(uvec4(uint(key), uint(key >> 32) & 0x7FFFFFFFu, frame_index, hash_combine(seed, purpose)));
}
const uint kCacheForChoice = 0u, kCacheForRounding = 1u, kCacheForPaths = 2u;

// The number of the update of a slot's cell in this frame, or kCacheNoSlot. Between two frames' maintenance the list that they leave behind
// says it; where no update wrote, something else is there.
uint cache_update_of(Cache cache, uint slot) {
    const uint update = CacheWords(cache.v.lists[cache.v.list ^ 1u]).v[slot];
    return update < cache.v.update_count && CacheWords(cache.v.updates).v[update] == slot ? update : kCacheNoSlot;
}
void cache_note_update(Cache cache, uint slot, uint update) {
    CacheWords(cache.v.updates).v[update] = slot;
    CacheWords(cache.v.lists[cache.v.list ^ 1u]).v[slot] = update;
}
#endif
