// A frame of the world cache: short passes over lists, and the rays between them.
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
struct SelectPush {
    uint64_t cache, rays, paths;
};
struct CandidatesPush {
    uint64_t cache, found, light_rays;
};
struct CacheExtendPush {
    uint64_t cache, lists, rays, hits;
    uint32_t round;
};
struct MeetPush {
    uint64_t view, cache, lists, rays, paths, hits, found;
    uint32_t round, rounds;
};
struct CacheConnectPush {
    uint64_t view, cache, found, light_rays, passing;
};
struct BlendPush {
    uint64_t cache, found, passing;
};

constexpr uint32_t kCacheTracingGroup = 64;    // scene/trace.glsl
constexpr uint32_t kCacheRowGroups = 1 << 15;  // below the 65,535 that every device takes

void clear(Frame& frame, const LightCache& cache) {
    frame.upload(cache.buffer(), 0, std::as_bytes(std::span(&cache.layout(), 1)));
    frame.compute("cache/clear").read_write("cache", cache.buffer()).push(CachePush{}).over_all(cache.slot_count());
}

void plan(Frame& frame, gpu::TraceWay way, const LightCache& cache, const shared::CacheFrameData& data, uint32_t stage) {
    const uint32_t tracing_group = way == gpu::TraceWay::Pipeline ? 1 : kCacheTracingGroup;
    frame.compute("cache/plan")
        .read_write("cache", cache.buffer())
        .write("sizes", cache.sizes())
        .push(PlanPush{.frame = data, .stage = stage, .tracing_group = tracing_group, .row = kCacheRowGroups})
        .over(1);
}

uint64_t size_at(uint32_t size) { return size * sizeof(shared::CacheSize); }

void maintain(Frame& frame, const LightCache& cache) {
    frame.compute("cache/maintain").read_write("cache", cache.buffer()).push(CachePush{}).over_indirect(cache.sizes(), size_at(shared::kCacheSizeMaintain));
}

void select(Frame& frame, const LightCache& cache) {
    frame.compute("cache/select")
        .read_write("cache", cache.buffer())
        .write("rays", cache.updates().rays)
        .write("paths", cache.updates().paths)
        .push(SelectPush{})
        .over_indirect(cache.sizes(), size_at(shared::kCacheSizeSelect));
}

void choose_lights(Frame& frame, const SceneGpu& scene, const LightCache& cache) {
    frame.compute("cache/candidates")
        .scene(scene.binding())
        .read("cache", cache.buffer())
        .write("found", cache.updates().found)
        .write("light_rays", cache.updates().light_rays)
        .push(CandidatesPush{})
        .over_indirect(cache.sizes(), size_at(shared::kCacheSizeCandidates));
}

void extend(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const LightCache& cache, uint32_t round) {
    frame.trace("cache/extend", way)
        .scene(scene.binding())
        .read("cache", cache.buffer())
        .read("lists", cache.updates().lists)
        .read("rays", cache.updates().rays)
        .write("hits", cache.updates().hits)
        .push(CacheExtendPush{.round = round})
        .over_indirect(cache.sizes(), size_at(shared::kCacheSizeRays));
}

void meet(Frame& frame, const SceneGpu& scene, const LightCache& cache, const gpu::Buffer& view, uint32_t round, uint32_t rounds) {
    frame.compute("cache/meet", (scene.features() & shared::kSceneLayers) != 0 ? "+LAYERS" : "")
        .scene(scene.binding())
        .read("view", view)
        .read_write("cache", cache.buffer())
        .read_write("lists", cache.updates().lists)
        .read_write("rays", cache.updates().rays)
        .read_write("paths", cache.updates().paths)
        .read("hits", cache.updates().hits)
        .read_write("found", cache.updates().found)
        .push(MeetPush{.round = round, .rounds = rounds})
        .over_indirect(cache.sizes(), size_at(shared::kCacheSizeUpdates));
}

void connect(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const LightCache& cache, const gpu::Buffer& view) {
    frame.trace("cache/connect", way, (scene.features() & shared::kScenePanes) != 0 ? "+PANES" : "")
        .scene(scene.binding())
        .read("view", view)
        .read("cache", cache.buffer())
        .read("found", cache.updates().found)
        .read("light_rays", cache.updates().light_rays)
        .write("passing", cache.updates().passing)
        .push(CacheConnectPush{})
        .over_indirect(cache.sizes(), size_at(shared::kCacheSizeRays));
}

}  // namespace

void begin_cache(Frame& frame, gpu::TraceWay way, LightCache& cache, const CacheFrame& now) {
    if (cache.take_empty()) clear(frame, cache);
    const shared::CacheFrameData data = cache.begin_frame(now.frame_index, now.seed, now.exposure, now.lights_changed, now.lights_switched);
    plan(frame, way, cache, data, shared::kCacheBegin);
    maintain(frame, cache);
    plan(frame, way, cache, data, shared::kCachePlan);
    select(frame, cache);
    plan(frame, way, cache, data, shared::kCacheSelected);
}

void blend_cache(Frame& frame, const LightCache& cache) {
    frame.compute("cache/blend")
        .read_write("cache", cache.buffer())
        .read("found", cache.updates().found)
        .read("passing", cache.updates().passing)
        .push(BlendPush{})
        .over_indirect(cache.sizes(), size_at(shared::kCacheSizeUpdates));
}

CacheUpdate::CacheUpdate(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, LightCache& cache, const CacheFrame& now)
    : frame_(frame),
      scene_(scene),
      way_(way),
      cache_(cache),
      view_(now.view),
      rounds_((scene.features() & shared::kSceneLayers) != 0 ? shared::kCacheRoundsLayers : shared::kCacheRounds) {
    begin_cache(frame, way, cache, now);
}

void CacheUpdate::step() {
    const uint32_t round = step_ / 2;
    if (ended()) return;
    if (round == rounds_) blend_cache(frame_, cache_);
    else if (step_ % 2 != 0) meet(frame_, scene_, cache_, view_, round, rounds_);
    else trace(round);
    ++step_;
}

void CacheUpdate::finish() {
    while (!ended()) step();
}

void CacheUpdate::trace(uint32_t round) {
    if (round == 0) choose_lights(frame_, scene_, cache_);
    extend(frame_, scene_, way_, cache_, round);
    if (round == 1) connect(frame_, scene_, way_, cache_, view_);
}

void update_cache(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, LightCache& cache, const CacheFrame& now) {
    CacheUpdate(frame, scene, way, cache, now).finish();
}

}  // namespace parhelion::passes
