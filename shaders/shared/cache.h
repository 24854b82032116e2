// The world cache: a table of cells in one buffer, its header first. docs/world-cache.md says what a cell is.
#ifndef PARHELION_SHARED_CACHE_H
#define PARHELION_SHARED_CACHE_H
#include "shared/wavefront.h"
SHARED_BEGIN

SHARED_CONST uint kCacheBucket = 32u;        // slots that a key may lie in
SHARED_CONST uint kCacheParents = 1u;        // levels above a cell's own that answer for it; more would reach through thicker walls
SHARED_CONST uint kCacheYoung = 4u;          // count from which a cell answers alone
SHARED_CONST uint kCacheSteady = 8u;         // count from which a cell's mean lights others, not what its update finds in this frame
SHARED_CONST uint kCacheChain = 8u;          // updates along which light comes to a cell in one frame
SHARED_CONST uint kCacheLongChain = 32u;     // where a light was switched: what lies beyond the end is of before, and its share has to be next to nothing
SHARED_CONST uint kCacheRounds = 2u;         // rays of an update's path, its first one included
SHARED_CONST uint kCacheRoundsLayers = 4u;   // where it may lead through glass
SHARED_CONST uint kCacheLanes = 8u;          // invocations that choose one update's light
SHARED_CONST uint kCacheMostLife = 63u;      // frames; the claim has 6 bits for it
SHARED_CONST uint kCacheMostSamples = 255u;  // the moments have 8 bits for the count
SHARED_CONST uint kCacheOldest = 63u;        // frames up to which ages are told apart
SHARED_CONST uint kCachePriorities = 64u;    // classes of cells that are updated equally often
SHARED_CONST uint kCacheNoSlot = 0xFFFFFFFFu;

// What an update has found so far of the irradiance at its cell, nits times steradians before exposure: 64 bytes.
struct CacheUpdate {
    vec3 found;      // by rays that ended, but for the choice
    uint link;       // number of the update whose cell lights this one too, or kCacheNoSlot
    vec3 share;      // of what that one finds
    float sum;       // of all weights of the choice among lights and the path's direction
    vec3 otherwise;  // what comes in its place when the chain ends here
    float target;    // luminance of:
    vec3 value;      // the choice so far, radiance times cosine; weighs sum / target
    uint bits;       // kCacheSeen, kCacheUnknown
};

SHARED_CONST uint kCacheSeen = 1u;     // nothing lies between the cell and what was chosen
SHARED_CONST uint kCacheUnknown = 2u;  // a ray ended where nothing was known yet: there is more light than was found

// An update's path between two of its rays, beside the ray (whose `bits` are its scatterings by lobes that are not diffuse): 40 bytes.
struct CachePath {
    vec3 throughput;
    float pdf;
    uvec4 media;
    float travelled, radiance_scale;
};

// Per slot 8 bytes of key, 8 of claim, 8 of irradiance, 4 of moments, 4 in each of two lists; per bucket 4; per cell that one frame
// updates 12. What updates need between their passes lies in buffers of its own, which views of one scene may share.
struct CacheHeader {
    uint64_t keys;        // uint64_t[slot_count]: lib/cache_key.glsl
    uint64_t claims;      // uint64_t[slot_count]
    uint64_t irradiance;  // uint64_t[slot_count]: lib/cache_cell.glsl
    uint64_t moments;     // uint[slot_count]
    uint64_t lists[2];    // uint[slot_count] each: slots of live cells. The other one says, by slot, which update is its cell's.
    uint64_t buckets;     // uint[slot_count / kCacheBucket]: frame of the last overflow and how strictly cells are let in since
    uint64_t updates;     // uint[update_capacity]: slots of the cells that this frame updates
    uint64_t kept;        // uint64_t[update_capacity]: their claims
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
    uint forgets;         // 1: a light was switched, and what cells know goes with their next sample
    uint chain;           // updates along which light comes to a cell
    // Counts, since this frame began.
    uint live_before;     // entries of the other list
    uint live;            // entries of the list
    uint update_count;
    uint path_count[kCacheRoundsLayers + 1u];  // of each round: updates whose paths have a ray in it; none after the last
    uint born, died, rejected;  // cells taken in; given up; undone because their bucket overflowed
    uint refused;         // askings that found no place
    uint shadow_rays;     // of the update
    uint class_count[kCachePriorities];
    float class_share[kCachePriorities];  // of the cells of a class that is updated
};

// What a frame gives to the cache.
struct CacheFrameData {
    uint frame_index, seed;
    float exposure, exposure_ratio;
    float cell_scale, cell_pixels, jitter;
    uint life, most_samples, candidates, forgets;
};

// Work sizes for vkCmdDispatchIndirect and vkCmdTraceRaysIndirectKHR.
SHARED_CONST uint kCacheSizeMaintain = 0u;
SHARED_CONST uint kCacheSizeSelect = 1u;
SHARED_CONST uint kCacheSizeUpdates = 2u;     // one invocation an update
SHARED_CONST uint kCacheSizeCandidates = 3u;  // kCacheLanes
SHARED_CONST uint kCacheSizeRays = 4u;        // one an update, in the groups of a pass that traces
SHARED_CONST uint kCacheSizeCount = 5u;
struct CacheSize {
    uint x, y, z;
};

// Stages of cache/plan.
SHARED_CONST uint kCacheBegin = 0u;
SHARED_CONST uint kCachePlan = 1u;
SHARED_CONST uint kCacheSelected = 2u;

SHARED_CONST uint kCacheGroup = 64u;  // invocations of a work group of the passes that trace nothing
SHARED_CONST uint kCacheMaintained = 4u;  // cells that an invocation of the maintenance looks after

SHARED_END
#endif
