#include "renderers/realtime.h"

#include "base/error.h"
#include "renderers/slice.h"

namespace parhelion {

Realtime::Realtime(gpu::DevicePtr device, const View& view, const RealtimeOptions& options)
    : options_(options),
      gbuffer_(passes::make_gbuffer(device, {view.film().width, view.film().height})),
      signals_(passes::make_signals(device, uint64_t{view.film().width} * view.film().height)),
      tiles_(passes::make_light_tiles(device)) {
    if (options.gbuffer == GBufferMode::Raster && !device->caps().raster)
        throw Error(ErrorCode::MissingFeature, "the device cannot draw", "gbuffer.mode=raster", "use gbuffer.mode=trace");
    if (options.gbuffer == GBufferMode::Raster && view.desc().camera.lens_radius > 0)
        throw Error(ErrorCode::Usage, "a camera with a lens is traced", "gbuffer.mode=raster", "use gbuffer.mode=trace");
    if (options.cache) cache_.emplace(device, options.cache_options);
}

void Realtime::record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view, bool ends_range) {
    const passes::Film& film = view.film();
    const auto sample = static_cast<uint32_t>(view.accumulation().samples++);
    const shared::Slice slice{.first_row = 0, .row_count = film.height, .first_sample = sample, .sample_count = 1};
    const shared::RealtimeFrame settings{.frame_index = frame_index_,
                                         .exposure = options_.exposure,
                                         .candidates = options_.candidates,
                                         .tiles = options_.tiles,
                                         .path_bounces = options_.path_bounces};
    begin_slice(frame, scene, way, view, slice);
    if (options_.gbuffer == GBufferMode::Raster) passes::raster_identity(frame, scene, film, gbuffer_.identity, raster_, frame_index_);
    else passes::trace_identity(frame, scene, way, film, gbuffer_, frame_index_);
    passes::summarise_surfaces(frame, scene, film, gbuffer_, frame_index_, options_.exposure);
    if (options_.tiles) passes::draw_light_tiles(frame, scene, tiles_, frame_index_, view.desc().seed);
    if (cache_) {
        const bool changed = scene_version_ != 0 && scene.version() != scene_version_;
        passes::update_cache(frame, scene, way, *cache_, {.frame_index = frame_index_, .seed = view.desc().seed, .exposure = options_.exposure, .lights_changed = changed, .view = film.view});
        scene_version_ = scene.version();
    }
    passes::light(frame, scene, way, film, gbuffer_, tiles_, cache_ ? &cache_->buffer() : nullptr, signals_, settings);
    passes::composite(frame, film, gbuffer_, signals_, options_.exposure);
    end_slice(frame, view, slice, ends_range);
    ++frame_index_;
}

}  // namespace parhelion
