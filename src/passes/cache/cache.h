#pragma once
// Passes that keep the world cache current (scene_gpu/light_cache.h, docs/world-cache.md).
#include "scene_gpu/light_cache.h"
#include "scene_gpu/scene_gpu.h"

namespace parhelion::passes {

struct CacheFrame {
    uint32_t frame_index = 0;  // grows by one with every frame of the cache
    uint32_t seed = 0;
    float exposure = 1.0f;     // of what is stored from now on; what is stored already is rescaled
    bool lights_changed = false;
    bool lights_switched = false;  // they did, and all at once: what is stored is no better than a first guess
    gpu::Buffer view;          // shared::ViewData: only its flags matter
};

// One frame of the cache, to be recorded before whoever asks it: cells age, come in and go, some are updated with new rays. What asks
// afterwards binds `cache` to cache.buffer(), read_write.
void update_cache(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, LightCache& cache, const CacheFrame& now);

// The same in three parts. Its rays are few and long; what is recorded between the parts need not wait for them.
class CacheUpdate {
public:
    CacheUpdate(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, LightCache& cache, const CacheFrame& now);
    void trace_first();  // rays of the cells that are updated
    void meet_first();   // what those met
    void finish();       // further rays, shadow rays, and the cells' new means

private:
    void meet(uint32_t round);
    Frame& frame_;
    const SceneGpu& scene_;
    gpu::TraceWay way_;
    LightCache& cache_;
    gpu::Buffer view_;
    shared::CacheFrameData data_;
    uint32_t rounds_;
};

// Its parts: what comes before the rays (the cells that are updated are chosen), and after them.
shared::CacheFrameData begin_cache(Frame& frame, gpu::TraceWay way, LightCache& cache, const CacheFrame& now);
void blend_cache(Frame& frame, const LightCache& cache);

}  // namespace parhelion::passes
