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

// The same step by step. Each step waits for the one before and is too little work to fill a GPU: what is recorded right behind one, and does not
// touch the cache, runs beside it.
class CacheUpdate {
public:
    CacheUpdate(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, LightCache& cache, const CacheFrame& now);
    void step();    // rays, then what they met, by turns; at last the cells' new means; then nothing more
    void finish();  // all steps that are left

private:
    bool ended() const { return step_ > 2 * rounds_; }
    void trace(uint32_t round);
    Frame& frame_;
    const SceneGpu& scene_;
    gpu::TraceWay way_;
    LightCache& cache_;
    gpu::Buffer view_;
    uint32_t rounds_, step_ = 0;
};

// Its parts: what comes before the rays (the cells that are updated are chosen), and after them.
void begin_cache(Frame& frame, gpu::TraceWay way, LightCache& cache, const CacheFrame& now);
void blend_cache(Frame& frame, const LightCache& cache);

}  // namespace parhelion::passes
