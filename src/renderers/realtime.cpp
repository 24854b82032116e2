#include "renderers/realtime.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "base/error.h"
#include "renderers/slice.h"
#include "shared/scene.h"

namespace parhelion {

namespace {

constexpr uint32_t kTileRows = 8;           // bands are whole squares of 64 pixels
constexpr uint32_t kPassings = 8, kPassingsWithoutCache = 32;  // panes, and boundaries that are none, along a path of most scatterings
constexpr uint32_t kMostScatterings = 256;  // of paths without a bound: roulette lets less than one in 100,000 live so long

constexpr uint32_t kAdaptedNeighbours = 2, kMostCandidates = 64;  // where lights are many

uint32_t reservoir_sets(const RealtimeOptions& options) { return options.reuse_options.sets == ReservoirSets::Split ? 2 : 1; }

// Of the samples that a path was offered one is kept, which brings as much as all of them; but their colours, and what the surface's lobes have of them, are
// noise then. With one set, weighed about, the path's own pixel takes them as they are.
bool keeps_offered(const RealtimeOptions& options) { return options.reuse == RealtimeReuse::Full && options.reuse_options.sets == ReservoirSets::Unified; }

// What the last frame counts for at most. Where few lights are the frame's own samples are as good as the last one's, and what frames repeat of each
// other their means keep as noise; below kWorthIt what is left of it is not worth its time (docs/resampling.md).
uint32_t confidence_for(const ReuseOptions& options, uint32_t lights, uint32_t candidates) {
    constexpr uint32_t kWorthIt = 3;
    if (!options.adapt_confidence) return options.confidence;
    const uint32_t called_for = static_cast<uint32_t>(std::bit_width(std::max(lights / candidates, 1u))) - 1;
    return called_for < kWorthIt ? 0 : std::min(options.confidence, called_for);
}

// Layers that show what the world cache knows at what pixels see.
bool shows_cache(const View& view) {
    constexpr std::string_view kOfTheCache[] = {"debug.cells", "debug.irradiance", "debug.level", "debug.count", "debug.age", "debug.life"};
    const auto is_of_it = [&](const std::string& channel) { return std::ranges::any_of(kOfTheCache, [&](std::string_view layer) { return channel.starts_with(layer); }); };
    return std::ranges::any_of(view.channels(), is_of_it);
}

bool shows_duplicates(const View& view) { return std::ranges::find(view.channels(), "debug.duplicates") != view.channels().end(); }

std::optional<RenderedView> make_rendered(const gpu::DevicePtr& device, const View& view, const RealtimeOptions& options) {
    const gpu::Extent picture{view.film().width, view.film().height}, rendered = rendered_extent(picture, options.upscale);
    if (rendered == picture) return {};
    if (!options.reconstruction) throw Error(ErrorCode::Usage, "what is traced becomes the picture by reconstruction alone", "--upscale", "add --denoise builtin");
    return std::make_optional<RenderedView>(device, view, rendered);
}

}  // namespace

Realtime::Realtime(gpu::DevicePtr device, const View& view, const RealtimeOptions& options)
    : device_(device),
      options_(options),
      rendered_(make_rendered(device, view, options)),
      gbuffer_(passes::make_gbuffer(device, {traced(view).width, traced(view).height})),
      signals_(passes::make_signals(device, uint64_t{traced(view).width} * traced(view).height)),
      tiles_(passes::make_light_tiles(device)) {
    if (!device->caps().subgroup_ballot)
        throw Error(ErrorCode::MissingFeature, "the realtime renderer needs subgroup ballots in compute shaders, which the device lacks", escape_name(device->caps().name), "use --renderer reference");
    if (options.gbuffer == GBufferMode::Raster && !device->caps().raster)
        throw Error(ErrorCode::MissingFeature, "the device cannot draw", "gbuffer.mode=raster", "use gbuffer.mode=trace");
    if (options.gbuffer == GBufferMode::Raster && view.desc().camera.lens_radius > 0)
        throw Error(ErrorCode::Usage, "a camera with a lens is traced", "gbuffer.mode=raster", "use gbuffer.mode=trace");
    if (options.reuse == RealtimeReuse::Unbiased && options.cache)
        throw Error(ErrorCode::Usage, "the world cache is not unbiased", "realtime.reuse=unbiased", "add --set realtime.cache=off");
    if (options.reuse != RealtimeReuse::None)
        reuse_.emplace(passes::make_reuse_state(device, gbuffer_.identity.extent(), reservoir_sets(options), std::max(options.reuse_options.neighbours, kAdaptedNeighbours), options.reuse == RealtimeReuse::Unbiased));
    if (options.cache) cache_.emplace(device, options.cache_options);
    if (options.reconstruction) reconstruction_.emplace(device, gbuffer_.identity.extent(), gpu::Extent{view.film().width, view.film().height}, *options.reconstruction);
    const uint32_t rows = (options.slots != 0 ? options.slots : passes::usual_light_paths(device->caps())) / traced(view).width / kTileRows * kTileRows;
    band_rows_ = std::clamp(rows, std::min(kTileRows, traced(view).height), traced(view).height);
}

bool Realtime::draws_pixels(const View& view) const {
    if (options_.gbuffer != GBufferMode::Auto) return options_.gbuffer == GBufferMode::Raster;
    return options_.auto_draws && view.desc().camera.lens_radius == 0 && !view.desc().camera_at_close;
}

// Whether what is seen through mirrors and panes stands in their place: for reconstruction, which compares and filters surfaces.
bool Realtime::follows(const SceneGpu& scene) const {
    return options_.reconstruction && options_.reconstruction->follow && (scene.features() & (shared::kSceneMirrors | shared::kScenePanes)) != 0;
}

// Vertices of the longest path, and so rounds of a band.
uint32_t Realtime::path_length(const SceneGpu& scene, const View& view) const {
    const uint32_t depth = std::min(view.desc().max_bounces, kMostScatterings);
    if ((scene.features() & shared::kSceneLayers) != 0) return depth + 1 + (options_.cache ? kPassings : kPassingsWithoutCache);
    const uint32_t mirrors = follows(scene) ? shared::kMostFollowed - 1 : 0;
    return (options_.cache ? std::min(depth, options_.path_bounces + mirrors) : depth) + 1;
}

void Realtime::trace_band(passes::LightPass pass, uint32_t path_length) {
    passes::begin_band(pass);
    beside_update(pass.frame, [&] { passes::sort_pixels(pass); });
    for (; pass.round < path_length; ++pass.round) {
        const bool last = pass.round + 1 == path_length;  // who still has a ray then ends without it, and it does not count
        if (pass.round == 1) finish_update();
        passes::prepare_wavefront(pass.tracing(), shared::kSizeOfClasses | shared::kEmptyRays | shared::kEmptyShadows);
        beside_update(pass.frame, [&] { passes::shade_paths(pass); });
        beside_update(pass.frame, [&] { passes::prepare_wavefront(pass.tracing(), (last ? 0u : shared::kSizeOfRays) | shared::kSizeOfShadows | shared::kCountShadows | shared::kEmptyClasses); });
        beside_update(pass.frame, [&] {
            passes::connect_paths(pass);
            if (!last) passes::extend(pass.tracing());
        });
        if (after_trace) after_trace(pass.tracing(), passes::WavefrontTraced::ShadowRays);
        if (last) break;
        if (after_trace) after_trace(pass.tracing(), passes::WavefrontTraced::Rays);
        beside_update(pass.frame, [&] { passes::sort_paths(pass); });
    }
    passes::gather_paths(pass);
}

// What the frame's passes have in common; its band is all pixels.
passes::LightPass Realtime::light_pass(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const View& view) const {
    return {.frame = frame,
            .scene = scene,
            .way = way,
            .film = traced(view),
            .gbuffer = gbuffer_,
            .paths = paths_,
            .signals = signals_,
            .tiles = tiles_,
            .cache = cache_ ? &cache_->buffer() : nullptr,
            .reservoirs = reuse_ ? &reuse_->reservoirs : nullptr,
            .settings = {.frame_index = frame_index_,
                         .exposure = options_.exposure,
                         .candidates = candidates(scene),
                         .tiles = options_.tiles,
                         .path_bounces = options_.path_bounces,
                         .follows = follows(scene) ? 1u : 0u,
                         .reservoir_sets = reuse_ ? reservoir_sets(options_) : 0,
                         .later_candidates = later_candidates(scene)},
            .band = {.first_row = 0, .row_count = traced(view).height, .first_sample = frame_index_, .sample_count = 1},
            .keeps_offered = reuse_ && keeps_offered(options_)};
}

// So many that one of all of them would seldom be one that matters.
bool Realtime::has_many_lights(const SceneGpu& scene) const {
    constexpr uint32_t kMany = 64;
    return scene.stats().emitters >= kMany;
}

// Light samples that a first surface chooses among; with reservoirs more of them where lights are many: what is found well is shared.
uint32_t Realtime::candidates(const SceneGpu& scene) const {
    constexpr uint32_t kMore = 8;
    return reuse_ && options_.reuse_options.adapt_offers && has_many_lights(scene) ? std::min(kMore * options_.candidates, kMostCandidates) : options_.candidates;
}

// And surfaces behind it. Where lights are few, one of all of them is nearly as good and costs less.
uint32_t Realtime::later_candidates(const SceneGpu& scene) const {
    constexpr uint32_t kMore = 4;
    if (!has_many_lights(scene)) return 0;
    return reuse_ && options_.reuse_options.adapt_offers ? std::min(kMore * options_.later_candidates, kMostCandidates) : options_.later_candidates;
}

// Partners of each pixel.
uint32_t Realtime::neighbours(const SceneGpu& scene) const {
    const ReuseOptions& options = options_.reuse_options;
    return options.neighbours != 0 && options.adapt_offers && has_many_lights(scene) ? std::max(options.neighbours, kAdaptedNeighbours) : options.neighbours;
}

template <class Do>
void Realtime::for_bands(passes::LightPass pass, Do&& band) const {
    for (uint32_t row = 0; row < pass.film.height; row += band_rows_) {
        pass.band.first_row = row;
        pass.band.row_count = std::min(band_rows_, pass.film.height - row);
        band(pass);
    }
}

void Realtime::trace_paths(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const View& view) {
    const bool layers = (scene.features() & shared::kSceneLayers) != 0;
    if (!paths_.paths || layers != paths_have_layers_)
        paths_ = passes::make_light_paths(device_, band_rows_ * traced(view).width, {.layers = layers, .reservoirs = reuse_.has_value()});
    paths_have_layers_ = layers;
    for_bands(light_pass(frame, scene, way, view), [&](const passes::LightPass& pass) { trace_band(pass, path_length(scene, view)); });
}

// Pixels of a band by their reservoirs' samples.
void Realtime::light_band(passes::LightPass pass, passes::ReusePass reuse) const {
    passes::begin_band(pass);
    for (reuse.settings.set = 0; reuse.settings.set < reservoir_sets(options_); ++reuse.settings.set) {
        passes::prepare_wavefront(pass.tracing(), shared::kEmptyShadows | shared::kEmptyClasses);
        passes::choose_samples(reuse, paths_);
        passes::prepare_wavefront(pass.tracing(), shared::kSizeOfClasses);
        passes::light_pixels(reuse, paths_);
        passes::prepare_wavefront(pass.tracing(), shared::kSizeOfShadows | shared::kCountShadows);
        passes::connect_paths(pass);
    }
    passes::gather_paths(pass);
}

// What paths have offered goes from frame to frame and from pixel to pixel, and lights them.
void Realtime::share_light(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const View& view) {
    const ReuseOptions& options = options_.reuse_options;
    const uint32_t confidence = confidence_for(options, scene.stats().emitters, options_.tiles ? candidates(scene) : 1);
    passes::ReusePass reuse{.frame = frame,
                            .scene = scene,
                            .way = way,
                            .film = traced(view),
                            .gbuffer = gbuffer_,
                            .signals = signals_,
                            .state = *reuse_,
                            .exact = options_.reuse == RealtimeReuse::Unbiased,
                            .settings = {.frame_index = frame_index_,
                                         .candidates = options_.tiles ? candidates(scene) : 0,
                                         .most_confidence = confidence,
                                         .neighbours = neighbours(scene),
                                         .radius_px = options.radius,
                                         .permutation = options.permutation ? 1u : 0u,
                                         .reset = is_cut(view) || confidence == 0,
                                         .changed = unsettled_frames_ != 0,
                                         .keeps_offered = keeps_offered(options_) ? 1u : 0u},
                            .exposure = options_.exposure};
    for (reuse.settings.set = 0; reuse.settings.set < reservoir_sets(options_); ++reuse.settings.set) {
        passes::reuse_before(reuse);
        if (shows_duplicates(view)) passes::show_duplicates(reuse);
        if (options.neighbours != 0) passes::tell_partners(reuse);
    }
    passes::LightPass light = light_pass(frame, scene, way, view);
    light.reservoirs = nullptr;  // nothing is offered any more
    light.adds = true;
    for_bands(light, [&](const passes::LightPass& pass) { light_band(pass, reuse); });
}

// The frame has nothing to do with those before.
bool Realtime::is_cut(const View& view) const {
    const shared::ViewData& data = view.data();
    return cut_ || glm::dot(data.camera.forward_ws, data.camera_before.forward_ws) <= 0.0f || data.camera.orthographic != data.camera_before.orthographic;
}

// The frame's picture into the film.
void Realtime::show(Frame& frame, View& view) {
    const passes::Film& film = view.film();
    const passes::ReconstructionInput input{.film = traced(view), .picture = &film, .jitter_px = view.jitter(), .gbuffer = gbuffer_, .signals = signals_, .exposure = options_.exposure, .cut = is_cut(view)};
    if (keeps_input_) input_.record(frame, input, view.data());
    if (reconstruction_) reconstruction_->record(frame, input, frame_index_);
    else passes::composite(frame, film, gbuffer_, signals_, options_.exposure);
    cut_ = false;
}

// After a change the world cache tells of what was for some frames more: samples of what it said are not to outlive it.
void Realtime::note_changes(const SceneGpu& scene) {
    changed_ = scene_version_ != 0 && scene.version() != scene_version_;
    scene_version_ = scene.version();
    switched_ = std::exchange(light_switches_, scene.light_switches()) != scene.light_switches() && changed_;
    unsettled_frames_ = changed_ ? 1 + (cache_ ? options_.cache_options.change_frames : 0) : unsettled_frames_ - std::min(unsettled_frames_, 1u);
}

void Realtime::begin_update(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const View& view) {
    update_.reset();
    if (!cache_ || !updates_cells) return;
    update_.emplace(
        frame, scene, way, *cache_,
        passes::CacheFrame{.frame_index = frame_index_, .seed = view.desc().seed, .exposure = options_.exposure, .lights_changed = changed_, .lights_switched = switched_, .view = traced(view).view});
}

// Records passes that neither ask the cache nor wait for each other, and beside them the next step of its update, so that they hide how long its few rays take.
void Realtime::beside_update(Frame& frame, const std::function<void()>& passes) {
    frame.together([&] {
        if (update_) update_->step();
        passes();
    });
}

void Realtime::finish_update() {
    if (update_) update_->finish();
    update_.reset();
}

void Realtime::show_cells(Frame& frame, const SceneGpu& scene, const View& view) {
    finish_update();
    passes::show_cache(frame, scene, traced(view), gbuffer_, cache_->buffer(), frame_index_);
}

void Realtime::record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view, bool ends_range) {
    const passes::Film& film = traced(view);
    const auto sample = static_cast<uint32_t>(view.accumulation().samples++);
    const shared::Slice slice{.first_row = 0, .row_count = view.film().height, .first_sample = sample, .sample_count = 1};
    note_changes(scene);
    if (reconstruction_) view.set_jitter(reconstruction_->jitter_px(frame_index_));
    begin_slice(frame, scene, way, view, slice);
    if (rendered_) rendered_->prepare(frame, view);
    if (reuse_) passes::keep_last_frame(*reuse_, gbuffer_);
    begin_update(frame, scene, way, view);
    if (draws_pixels(view)) passes::raster_identity(frame, scene, film, gbuffer_.identity, raster_, frame_index_);
    // The update has these groups to hide behind, and those of a band's first vertices (trace_band); long ones are due where it traces.
    beside_update(frame, [&] {
        if (!draws_pixels(view)) passes::trace_identity(frame, scene, way, film, gbuffer_, frame_index_);
    });
    beside_update(frame, [&] {
        if (options_.tiles) passes::draw_light_tiles(frame, scene, tiles_, frame_index_, view.desc().seed, {film.width, film.height});
    });
    beside_update(frame, [&] { passes::summarise_surfaces(frame, scene, film, gbuffer_, frame_index_, options_.exposure); });
    if (follows(scene)) passes::follow_mirrors(frame, scene, way, film, gbuffer_, frame_index_, options_.exposure);
    if (cache_ && shows_cache(view)) show_cells(frame, scene, view);
    trace_paths(frame, scene, way, view);
    finish_update();  // where paths have one vertex
    if (reuse_) share_light(frame, scene, way, view);
    show(frame, view);
    end_slice(frame, view, slice, ends_range);
    view.end_frame();
    ++frame_index_;
}

}  // namespace parhelion
