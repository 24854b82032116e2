// A frame of the world cache: six short passes over lists, and the rays between them.
#include <algorithm>
#include <span>

#include "passes/cache/cache.h"
#include "shared/scene.h"

namespace parhelion::passes {

namespace {

struct CachePush {
    uint64_t cache;
};
struct PlanPush {
    uint64_t cache, sizes;
    shared::CacheFrameData frame;
    uint32_t stage, tracing_group, row;
};
struct UpdatePush {
    uint64_t view, cache;
};

constexpr uint32_t kTracingGroup = 64;    // scene/trace.glsl
constexpr uint32_t kRowGroups = 1 << 15;  // below the 65,535 that every device takes

void clear(Frame& frame, const LightCache& cache) {
    frame.upload(cache.buffer(), 0, std::as_bytes(std::span(&cache.layout(), 1)));
    constexpr uint32_t kRow = 1u << 20;
    frame.compute("cache/clear").read_write("cache", cache.buffer()).push(CachePush{}).over(std::min(cache.slot_count(), kRow), (cache.slot_count() + kRow - 1) / kRow);
}

void plan(Frame& frame, gpu::TraceWay way, const LightCache& cache, const shared::CacheFrameData& data, uint32_t stage) {
    const uint32_t tracing_group = way == gpu::TraceWay::Pipeline ? 1 : kTracingGroup;
    frame.compute("cache/plan")
        .read_write("cache", cache.buffer())
        .write("sizes", cache.sizes())
        .push(PlanPush{.frame = data, .stage = stage, .tracing_group = tracing_group, .row = kRowGroups})
        .over(1);
}

void over_cells(Frame& frame, const char* name, const LightCache& cache, uint32_t size) {
    frame.compute(name).read_write("cache", cache.buffer()).push(CachePush{}).over_indirect(cache.sizes(), size * sizeof(shared::CacheSize));
}

}  // namespace

void begin_cache(Frame& frame, gpu::TraceWay way, LightCache& cache, const CacheFrame& now) {
    if (cache.take_empty()) clear(frame, cache);
    const shared::CacheFrameData data = cache.begin_frame(now.frame_index, now.seed, now.exposure, now.lights_changed);
    plan(frame, way, cache, data, shared::kCacheBegin);
    over_cells(frame, "cache/maintain", cache, shared::kCacheSizeMaintain);
    plan(frame, way, cache, data, shared::kCachePlan);
    over_cells(frame, "cache/select", cache, shared::kCacheSizeSelect);
    plan(frame, way, cache, data, shared::kCacheSelected);
}

void blend_cache(Frame& frame, const LightCache& cache) { over_cells(frame, "cache/blend", cache, shared::kCacheSizeBlend); }

void update_cache(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, LightCache& cache, const CacheFrame& now) {
    begin_cache(frame, way, cache, now);
    frame.trace("cache/update", way, (scene.features() & shared::kSceneLayers) != 0 ? "+LAYERS" : "")
        .scene(scene.binding())
        .read("view", now.view)
        .read_write("cache", cache.buffer())
        .push(UpdatePush{})
        .over_indirect(cache.sizes(), shared::kCacheSizeUpdate * sizeof(shared::CacheSize));
    blend_cache(frame, cache);
}

}  // namespace parhelion::passes
