#pragma once
// The realtime renderer: a frame's light in one pass of short paths, with nothing baked. Documents 000, 001 and 004.
#include <functional>
#include <optional>

#include "passes/cache/cache.h"
#include "passes/gbuffer/raster.h"
#include "passes/lights/lights.h"
#include "passes/reuse/reuse.h"
#include "renderers/kept_input.h"
#include "renderers/reconstruction.h"
#include "renderers/rendered_view.h"
#include "passes/wavefront/replay.h"
#include "renderers/view.h"

namespace parhelion {

enum class RealtimeReuse : uint32_t { Full, None, Unbiased };

// One reservoir a pixel for all light that is shared, or one for direct and one for indirect light.
enum class ReservoirSets : uint32_t { Unified, Split };

// How samples are shared between pixels and frames.
struct ReuseOptions {
    ReservoirSets sets = ReservoirSets::Unified;
    uint32_t confidence = 8;   // frames that what the last frame knew counts for at most; 0: no temporal reuse
    bool adapt_confidence = true;  // at most as much as lights call for: log2 of how many there are for each candidate, and not at all below 3
    bool adapt_offers = true;      // where lights are many: eight times the candidates, later four times, and two neighbours at least
    uint32_t neighbours = 1;   // pixels around whose samples are taken; 0: no spatial reuse
    float radius = 30.0f;      // pixels that these are off at most, along each axis
    bool permutation = false;  // near pixels of the last frame are exchanged: less that stays in place, but edges of shadows darken where samples are not weighed exactly
};

// What finds the triangles under the pixels.
enum class GBufferMode : uint32_t { Auto, Raster, Trace };

struct RealtimeOptions {
    RealtimeReuse reuse = RealtimeReuse::None;  // Unbiased: samples are weighed with what hides them, and nothing that is known to be off is used
    ReuseOptions reuse_options;
    GBufferMode gbuffer = GBufferMode::Auto;  // Raster needs SceneGpuOptions::raster, and a camera without a lens
    bool auto_draws = false;  // Auto is Raster while the camera has neither lens nor shutter, else Trace; false: Trace always
    uint32_t candidates = 8;  // light samples that the first surface's one is chosen from
    uint32_t later_candidates = 4;  // and that later vertices' are, where there are at least 64 lights; 0: one of all lights
    bool tiles = true;        // they come from light tiles; false: the light is sampled as by the reference
    bool cache = true;           // paths end in the world cache; false: they go to the view's depth
    uint32_t path_bounces = 3;   // reflections after which a path ends in the cache whatever it meets, but for glass
    uint32_t slots = 0;          // paths at a time, in bands of whole rows; 0: as suits the device. Pictures do not depend on it
    CacheOptions cache_options;
    float exposure = 1.0f;    // stored radiance is nits times this; about 1 over the nits of white
    std::optional<ReconstructionOptions> reconstruction = {};  // none: frames are as noisy as their paths
    double upscale = 1.0;     // the picture's width and height over those of what is traced; more than 1 needs reconstruction
};

// Draws frames of one view.
class Realtime {
public:
    Realtime(gpu::DevicePtr device, const View& view, const RealtimeOptions& options);

    // Records a frame, as one more sample of the view's film (the block of 64 that it ends is added to the exact sums). `ends_range`: the
    // film is read after it. Only records: no submit, no wait. The scene must be drawable (SceneGpu::update).
    void record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view, bool ends_range);

    uint32_t frame_index() const { return frame_index_; }  // of the next frame: key of its random numbers
    void set_frame_index(uint32_t index) { frame_index_ = index; }
    const passes::GBuffer& gbuffer() const { return gbuffer_; }
    const std::optional<LightCache>& cache() const { return cache_; }
    gpu::Buffer reservoirs() const { return reuse_ ? reuse_->reservoirs : gpu::Buffer(); }  // passes::ReuseState
    // Of the coming frames; what is stored is rescaled.
    void set_exposure(float exposure) { options_.exposure = exposure; }
    // The coming frame has nothing to do with those before: a cut. A camera that turns by a right angle or more says so itself.
    void cut() { cut_ = true; }
    // Of the coming frames what reconstruction gets is kept, whether there is any or not. It never changes them.
    void keep_input(bool keep) { keeps_input_ = keep; }
    InputReadback read_input(Frame& frame) const { return input_.read(frame); }  // of the last frame that was kept
    // Called while a frame is recorded, after Extend and after Connect: to look at what they traced (session/bench_realtime.h).
    std::function<void(const passes::WavefrontPass&, passes::WavefrontTraced)> after_trace;

    // False: the cells stay as they are, for measurements of what their update costs.
    bool updates_cells = true;

private:
    const passes::Film& traced(const View& view) const { return rendered_ ? rendered_->film() : view.film(); }  // the film of the frame's passes
    void note_changes(const SceneGpu& scene);
    void begin_update(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const View& view);
    void beside_update(Frame& frame, const std::function<void()>& passes);
    void finish_update();  // before anyone asks the cache
    void show_cells(Frame& frame, const SceneGpu& scene, const View& view);
    bool draws_pixels(const View& view) const;
    bool follows(const SceneGpu& scene) const;
    bool has_many_lights(const SceneGpu& scene) const;
    uint32_t candidates(const SceneGpu& scene) const;
    uint32_t later_candidates(const SceneGpu& scene) const;
    uint32_t neighbours(const SceneGpu& scene) const;
    uint32_t path_length(const SceneGpu& scene, const View& view) const;
    bool is_cut(const View& view) const;
    passes::LightPass light_pass(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const View& view) const;
    template <class Do>
    void for_bands(passes::LightPass pass, Do&& band) const;
    void show(Frame& frame, View& view);
    void trace_band(passes::LightPass pass, uint32_t path_length);
    void light_band(passes::LightPass pass, passes::ReusePass reuse) const;
    void share_light(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const View& view);
    void trace_paths(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const View& view);

    gpu::DevicePtr device_;
    RealtimeOptions options_;
    std::optional<RenderedView> rendered_;  // where the picture has more pixels
    passes::GBuffer gbuffer_;
    passes::RasterHistory raster_;
    passes::Signals signals_;
    passes::LightPaths paths_;
    bool paths_have_layers_ = false;
    uint32_t band_rows_ = 0;
    gpu::Buffer tiles_;
    std::optional<LightCache> cache_;
    std::optional<passes::CacheUpdate> update_;  // of the cache, while a frame is recorded
    std::optional<passes::ReuseState> reuse_;
    std::optional<Reconstruction> reconstruction_;
    bool cut_ = true;  // the first frame follows none
    bool keeps_input_ = false;
    KeptInput input_;
    uint64_t scene_version_ = 0, light_switches_ = 0;
    bool changed_ = false;           // something in the scene is not as it was in the last frame: what moves takes its shadow along
    bool switched_ = false;          // a light that matters was switched
    uint32_t unsettled_frames_ = 0;  // in which points may still be lit as they were before
    uint32_t frame_index_ = 0;
};

}  // namespace parhelion
