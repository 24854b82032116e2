// The world cache: a table of cells in one buffer, its header first. docs/world-cache.md says what a cell is.
#ifndef PARHELION_SHARED_CACHE_H
#define PARHELION_SHARED_CACHE_H
#include "shared/types.h"
SHARED_BEGIN

SHARED_CONST uint kCacheBucket = 32u;        // slots that a key may lie in
SHARED_CONST uint kCacheParents = 1u;        // levels above a cell's own that answer for it; more would reach through thicker walls
SHARED_CONST uint kCacheYoung = 4u;          // count from which a cell answers alone
SHARED_CONST uint kCacheSteady = 8u;         // count from which paths of the update end in a cell while they may still go on
SHARED_CONST uint kCacheMostLife = 63u;      // frames; the claim has 6 bits for it
SHARED_CONST uint kCacheMostSamples = 255u;  // the moments have 8 bits for the count
SHARED_CONST uint kCacheOldest = 63u;        // frames up to which ages are told apart
SHARED_CONST uint kCachePriorities = 64u;    // classes of cells that are updated equally often
SHARED_CONST uint kCacheNoSlot = 0xFFFFFFFFu;

// Per slot 8 bytes of key, 8 of claim, 8 of irradiance, 4 of moments, 4 in each of two lists; per bucket 4; per cell that one frame
// updates 4 in a list and 12 of sample.
struct CacheHeader {
    uint64_t keys;        // uint64_t[slot_count]: lib/cache_key.glsl
    uint64_t claims;      // uint64_t[slot_count]
    uint64_t irradiance;  // uint64_t[slot_count]: lib/cache_cell.glsl
    uint64_t moments;     // uint[slot_count]
    uint64_t lists[2];    // uint[slot_count] each: slots of live cells
    uint64_t buckets;     // uint[slot_count / kCacheBucket]: frame of the last overflow and how strictly cells are let in since
    uint64_t updates;     // uint[update_capacity]: slots of the cells that this frame updates
    uint64_t samples;     // vec3[update_capacity]: irradiance that their rays found, pre-exposed
    uint slot_count, bucket_mask, update_capacity;
    // Of this frame.
    uint frame_index, frame_before, seed;
    uint list;            // which of the two lists grows
    float exposure;       // of everything that is stored
    float exposure_ratio; // over that of the frame before
    float cell_scale;     // size of a cell over the footprint that asks for it
    float cell_pixels;    // least size of a cell, in widths of the pixel that looks at it
    float jitter;         // of look-ups, in cells
    uint life;            // frames that a cell lives on after a pixel asked for it
    uint most_samples;    // count that running means stop at
    uint candidates;      // of one choice of a light
    // Counts, since this frame began.
    uint live_before;     // entries of the other list
    uint live;            // entries of the list
    uint update_count;
    uint born, died, rejected;  // cells taken in; given up; undone because their bucket overflowed
    uint refused;         // askings that found no place
    uint path_rays, shadow_rays;  // of the update
    uint class_count[kCachePriorities];
    float class_share[kCachePriorities];  // of the cells of a class that is updated
};

// What a frame gives to the cache.
struct CacheFrameData {
    uint frame_index, seed;
    float exposure, exposure_ratio;
    float cell_scale, cell_pixels, jitter;
    uint life, most_samples, candidates;
};

// Work sizes for vkCmdDispatchIndirect and vkCmdTraceRaysIndirectKHR.
SHARED_CONST uint kCacheSizeMaintain = 0u;
SHARED_CONST uint kCacheSizeSelect = 1u;
SHARED_CONST uint kCacheSizeUpdate = 2u;
SHARED_CONST uint kCacheSizeBlend = 3u;
SHARED_CONST uint kCacheSizeCount = 4u;
struct CacheSize {
    uint x, y, z;
};

// Stages of cache/plan.
SHARED_CONST uint kCacheBegin = 0u;
SHARED_CONST uint kCachePlan = 1u;
SHARED_CONST uint kCacheSelected = 2u;

SHARED_CONST uint kCacheGroup = 64u;  // invocations of a work group of the passes that trace nothing

SHARED_END
#endif
