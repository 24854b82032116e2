#version 460
// Turns counts into the work sizes of the passes that follow, and into the shares of cells that this frame updates. One thread.
// Reads and writes: cache (its header). Writes: sizes.
#extension GL_GOOGLE_include_directive : require
#include "cache/cells.glsl"

layout(local_size_x = 1) in;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Sizes { CacheSize v[]; };
layout(push_constant, scalar) uniform Push {
    Cache cache;
    Sizes sizes;
    CacheFrameData frame;
    uint stage;               // kCacheBegin ...
    uint tracing_group, row;  // invocations of a group of the tracing pass; most groups in one row
} push;

void set_size(uint size, uint count, uint group) {
    const uint groups = (count + group - 1u) / group, x = min(groups, push.row);
    push.sizes.v[size] = CacheSize(x, x == 0u ? 1u : (groups + x - 1u) / x, 1u);
}

void begin() {
    Cache cache = push.cache;
    cache.v.frame_before = cache.v.frame_index;
    cache.v.frame_index = push.frame.frame_index;
    cache.v.seed = push.frame.seed;
    cache.v.exposure = push.frame.exposure;
    cache.v.exposure_ratio = push.frame.exposure_ratio;
    cache.v.cell_scale = push.frame.cell_scale;
    cache.v.cell_pixels = push.frame.cell_pixels;
    cache.v.jitter = push.frame.jitter;
    cache.v.life = push.frame.life;
    cache.v.most_samples = push.frame.most_samples;
    cache.v.candidates = push.frame.candidates;
    cache.v.forgets = push.frame.forgets;
    cache.v.chain = push.frame.forgets != 0u ? kCacheLongChain : kCacheChain;
    cache.v.live_before = cache.v.live;
    cache.v.list ^= 1u;
    cache.v.live = cache.v.update_count = 0u;
    cache.v.born = cache.v.died = cache.v.rejected = cache.v.refused = 0u;
    cache.v.shadow_rays = 0u;
    for (uint i = 0u; i < kCachePriorities; ++i) cache.v.class_count[i] = 0u;
    set_size(kCacheSizeMaintain, cache.v.live_before, kCacheGroup * kCacheMaintained);
}

// The shares min(1, k rate) that make the expected number of updates the capacity, less six standard deviations of it: which cells
// would find no room would depend on their order.
void plan() {
    Cache cache = push.cache;
    const float capacity = float(cache.v.update_capacity), target = max(capacity - 6.0 * sqrt(capacity), 0.25 * capacity);
    float rest = 0.0;
    for (uint i = 0u; i < kCachePriorities; ++i) rest += float(cache.v.class_count[i]) * cache_class_rate(i);
    float k = 1e30, whole = 0.0;
    if (cache.v.live > cache.v.update_capacity)
        for (uint i = 0u; i < kCachePriorities; ++i) {
            const float rate = cache_class_rate(i), count = float(cache.v.class_count[i]);
            k = max(target - whole, 0.0) / max(rest, 1e-30);
            if (k * rate <= 1.0) break;
            whole += count;
            rest -= count * rate;
        }
    for (uint i = 0u; i < kCachePriorities; ++i) cache.v.class_share[i] = min(k * cache_class_rate(i), 1.0);
    set_size(kCacheSizeSelect, cache.v.live, kCacheGroup);
}

// All rounds have the sizes of the first one: what few paths go on leave over returns at once, and a pass that counted them would make all others wait.
void plan_updates() {
    const uint count = min(push.cache.v.update_count, push.cache.v.update_capacity);
    push.cache.v.update_count = push.cache.v.path_count[0] = count;
    for (uint round = 1u; round <= kCacheRoundsLayers; ++round) push.cache.v.path_count[round] = 0u;
    set_size(kCacheSizeUpdates, count, kCacheGroup);
    set_size(kCacheSizeCandidates, count * kCacheLanes, kCacheGroup);
    set_size(kCacheSizeRays, count, push.tracing_group);
}

void main() {
    switch (push.stage) {
        case kCacheBegin: begin(); break;
        case kCachePlan: plan(); break;
        default: plan_updates();
    }
}
