#include "session/interactive.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "renderers/reference.h"
#include "scene/load.h"
#include "session/scene_setup.h"

namespace parhelion {

InteractiveState initial_state(const RenderOptions& options) {
    InteractiveState state{.options = options, .metered = options.exposure_ev.has_value(), .seconds = options.load.time};
    for (const std::string& assignment : options.assignments) apply_assignment(state.settings, assignment);
    state.show = {.exposure_ev = options.exposure_ev.value_or(0), .curve = options.output.tonemap};
    if (!options.aovs.empty()) state.layer = options.aovs.front();
    return state;
}

Interactive::Interactive(const InteractiveState& state, gpu::DevicePtr device)
    : show(state.show), accumulate(state.accumulate), play(state.play), seconds(state.seconds), options_(state.options), settings_(state.settings), device_(std::move(device)),
      has_camera_(state.camera.has_value()), layer_(state.layer), meter_(!state.metered) {
    if (state.camera) camera_ = *state.camera;
    trace_ = decide_trace(device_->caps(), options_.trace, settings_.node_layout);
    check_reference({.texture_lod = settings_.texture_lod, .shade_in = settings_.shade_in}, trace_.way == gpu::TraceWay::Pipeline);
    make_drawer(options_.renderer, settings_, options_.denoise);
    if (options_.denoise == DenoiseKind::Oidn) denoiser_ = std::make_unique<AsyncDenoiser>();
    frame_ = std::make_unique<Frame>(device_);
    if (state.shaders) use_shaders(state.shaders);
    reload();
}

InteractiveState Interactive::state() const {
    InteractiveState out{.options = options_, .settings = settings_, .shaders = shaders_, .show = show, .metered = !meter_, .layer = layer_, .accumulate = accumulate, .play = play, .seconds = seconds};
    if (has_camera_) out.camera = camera_;
    return out;
}

// A scene that is still being loaded is waited for: nothing can end a thread.
Interactive::~Interactive() = default;

Interactive::Loaded Interactive::load(const RenderOptions& options, const RenderSettings& settings) {
    Loaded out{.options = options, .scene = std::make_unique<LoadedScene>(load_scene(options.scene, options.load))};
    add_light(out.scene->scene, options, sky_options(settings));
    out.camera = set_up_camera(*out.scene, options, settings.culling == Culling::Gltf, out.camera_name).opens;
    if (!options.camera_path.empty()) out.path = read_camera_path(options.camera_path);
    return out;
}

void Interactive::load_with(RenderOptions options) {
    if (loading_.valid()) {
        next_load_ = std::move(options);
        return;
    }
    loading_ = std::async(std::launch::async, [options = std::move(options), settings = settings_] { return load(options, settings); });
}

void Interactive::reload() {
    RenderOptions options = options_;
    options.load.time = seconds;
    load_with(std::move(options));
}

void Interactive::open_scene(const std::string& name) {
    RenderOptions options = options_;
    options.scene = name;
    options.load.animate.clear(), options.load.animation.clear(), options.load.variant.clear();
    options.camera.clear(), options.camera_path.clear();
    options.look_from.reset(), options.look_at.reset(), options.fov_degrees.reset(), options.ortho_height.reset();
    options.aperture_radius = 0;
    options.load.time = 0;
    load_with(std::move(options));
}

void Interactive::open_environment(const std::string& file) {
    RenderOptions options = options_;
    options.environment = file;
    options.load.time = seconds;
    load_with(std::move(options));
}

void Interactive::take_loaded() {
    if (!loading_.valid() || loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    Loaded next;
    try {
        next = loading_.get();
    } catch (const Error& error) {
        if (!loaded_) throw;
        note_ = error.line;  // the scene of before stays
        log_line(LogLevel::Error, error.line);
    }
    if (next_load_) load_with(*std::exchange(next_load_, std::nullopt));
    if (!next.scene) return;
    const bool other = next.options.scene != options_.scene;
    loaded_ = std::move(next.scene);
    camera_path_ = std::move(next.path);
    note_ = fmt::format("{}, camera {}", escape_name(next.options.scene), escape_name(next.camera_name));
    log(LogLevel::Info, "scene {}", note_);
    // What is no affair of the scene may have changed since.
    RenderOptions now = std::move(next.options);
    now.size = options_.size, now.renderer = options_.renderer, now.denoise = options_.denoise, now.upscale = options_.upscale, now.max_bounces = options_.max_bounces, now.aovs = options_.aovs;
    options_ = start_ = std::move(now);
    if (other) seconds = options_.load.time, meter_ = true, play = false;
    time_set_ |= seconds != options_.load.time;
    first_camera_ = SteeredCamera(next.camera, orbit_distance(next.camera, loaded_->scene.bounds()));
    if (other || !has_camera_) camera_ = first_camera_;
    has_camera_ = true;
    set_up_scene();
    if (other) set_camera(camera_);
    place_camera();
}

// Where the options' camera stands in the scene of now, in a window of this shape, as `parhelion render` finds it.
CameraView Interactive::camera_of_options() const {
    std::string ignored;
    CameraView view = camera_path_ ? camera_path_->view_at(seconds) : parhelion::choose_camera(loaded_->scene, options_, ignored);
    if (camera_path_) apply_fov(view, options_);
    view.lens_radius = camera_.view().lens_radius;
    view.focus_distance = camera_.view().focus_distance;
    return view;
}

void Interactive::place_camera() {
    if (!loaded_ || camera_.has_moved()) return;
    const CameraView view = camera_of_options();
    const CameraView& now = camera_.view();
    const bool same = view.position == now.position && view.forward == now.forward && view.up == now.up && view.yfov == now.yfov && view.half_extents == now.half_extents;
    if (!same) set_camera(SteeredCamera(view, orbit_distance(view, loaded_->scene.bounds())));
}

void Interactive::set_up_scene() {
    if (!scene_gpu_) scene_gpu_ = std::make_unique<SceneGpu>(device_, describe_scene_gpu(settings_, trace_, may_draw_pixels(settings_, device_->caps())));
    scene_gpu_->sync(loaded_->scene);
    if (!view_) set_up_view();
}

// What a frame is drawn with: perhaps coarser than the window, and with the layers that are shown or looked into.
RenderOptions Interactive::drawn_options() const {
    RenderOptions options = options_;
    options.size = {std::max(1u, options_.size.width / shrink_), std::max(1u, options_.size.height / shrink_)};
    options.aovs = layer_.empty() ? std::vector<std::string>{} : std::vector{layer_};
    if (probes_layers_)
        for (std::string& layer : realtime_probe_layers())
            if (layer != layer_) options.aovs.push_back(std::move(layer));
    return options;
}

std::unique_ptr<ViewDrawer> Interactive::make_drawer(RendererKind kind, const RenderSettings& settings, DenoiseKind denoise) const {
    const double upscale = layer_.empty() && denoise == DenoiseKind::Builtin ? options_.upscale : 1;  // a layer has a value a traced pixel
    RenderSettings drawn = settings;
    drawn.cache.budget = std::max(1u, settings.cache.budget / (shrink_ * shrink_));  // as much less work as pixels
    return make_view_drawer(device_, {.kind = kind, .size = drawn_options().size, .max_samples = options_.samples.end, .denoise = denoise, .upscale = upscale}, drawn);
}

// Another film; the renderer goes on with its histories.
void Interactive::replace_view() {
    view_ = std::make_unique<View>(device_, describe_view(drawn_options(), settings_, {.opens = camera_.view()}));
    clear_film();
}

void Interactive::set_up_view() {
    options_.aovs = layer_.empty() ? std::vector<std::string>{} : std::vector{layer_};
    if (options_.renderer != RendererKind::Realtime) probes_layers_ = false;
    drawer_ = make_drawer(options_.renderer, settings_, options_.denoise);
    replace_view();
    preview_.reset();
    close_beside();
}

// The film's samples are of something that is no more.
void Interactive::clear_film() {
    view_->clear_film();
    drawer_->restart();
    if (denoiser_) denoiser_->discard();
    denoised_ = {};
    denoised_samples_ = 0;
    preview_samples_ = 0;
    ahead_ = 0;
    fresh_ = true;
}

// Of the film's layers those that were looked into go as well.
void Interactive::forget_pick() {
    picked_.reset();
    to_pick_.reset();
    probes_frame_ = false;
    if (std::exchange(probes_layers_, false) && view_) replace_view();
}

void Interactive::clear() {
    if (!view_) return;
    clear_film();
    if (beside_) beside_->clear();
}

void Interactive::begin_anew() {
    if (view_) set_up_view();
}

void Interactive::use_shaders(std::shared_ptr<const gpu::ShaderPack> pack) {
    frame_->use_pack(*pack);
    shaders_ = std::move(pack);
    clear();
}

void Interactive::set_camera(const SteeredCamera& camera) {
    camera_ = camera;
    moved_at_ = std::chrono::steady_clock::now();
    if (!view_) return;
    const ViewDesc& desc = view_->desc();
    const shared::Camera placed = shader_camera(camera_.view(), static_cast<float>(desc.width) / static_cast<float>(desc.height));
    view_->set_camera(placed);
    if (beside_) beside_->set_camera(placed);
    clear();
}

void Interactive::choose_camera(const std::string& name) {
    if (!loaded_) return;
    if (!name.empty()) find_camera(loaded_->scene, name);
    options_.camera = name.empty() ? start_.camera : name;
    options_.look_from = name.empty() ? start_.look_from : std::nullopt;
    options_.look_at = name.empty() ? start_.look_at : std::nullopt;
    options_.fov_degrees = name.empty() ? start_.fov_degrees : std::nullopt;
    options_.ortho_height = name.empty() ? start_.ortho_height : std::nullopt;
    options_.camera_path = name.empty() ? start_.camera_path : std::filesystem::path();
    if (options_.camera_path.empty()) camera_path_.reset();
    else camera_path_ = read_camera_path(options_.camera_path);
    if (name.empty()) camera_ = first_camera_;  // its lens
    const CameraView view = camera_of_options();
    set_camera(SteeredCamera(view, orbit_distance(view, loaded_->scene.bounds())));
}

void Interactive::set_renderer(RendererKind kind) {
    const DenoiseKind denoise = kind != RendererKind::Realtime && options_.denoise == DenoiseKind::Builtin ? DenoiseKind::None : options_.denoise;
    make_drawer(kind, settings_, denoise);
    options_.renderer = kind;
    options_.denoise = denoise;
    if (denoise == DenoiseKind::None) options_.upscale = 1;
    if (kind != RendererKind::Realtime && layer_.starts_with("debug.")) layer_.clear();
    shrink_ = 1, pixel_seconds_ = 0;
    if (view_) set_up_view();
}

void Interactive::set_denoise(DenoiseKind kind) {
    if (kind == DenoiseKind::Builtin && options_.renderer != RendererKind::Realtime)
        throw Error(ErrorCode::Usage, "it puts frames of the realtime renderer together", "--denoise builtin", "choose that, or --denoise oidn");
    std::unique_ptr<AsyncDenoiser> denoiser;
    if (kind == DenoiseKind::Oidn) denoiser = std::make_unique<AsyncDenoiser>();
    make_drawer(options_.renderer, settings_, kind);
    denoiser_ = std::move(denoiser);
    options_.denoise = kind;
    if (kind != DenoiseKind::Builtin) options_.upscale = 1;
    if (view_) set_up_view();
}

void Interactive::set_settings(const RenderSettings& settings) {
    const RenderSettings before = settings_;
    const TraceDecision trace = decide_trace(device_->caps(), options_.trace, settings.node_layout);
    check_reference({.texture_lod = settings.texture_lod, .shade_in = settings.shade_in}, trace.way == gpu::TraceWay::Pipeline);
    make_drawer(options_.renderer, settings, options_.denoise);
    settings_ = settings;
    trace_ = trace;
    if (settings.sun_elevation != before.sun_elevation || settings.sun_azimuth != before.sun_azimuth) reload();
    if (!loaded_) return;
    if (settings.culling != before.culling || settings.infinite_share != before.infinite_share || settings.node_layout != before.node_layout ||
        settings.bvh_loop != before.bvh_loop || settings.gbuffer_mode != before.gbuffer_mode || settings.proxy_ratio != before.proxy_ratio || settings.proxy_error != before.proxy_error) {
        scene_gpu_.reset();
        progress_ = {};
        set_up_scene();
    }
    set_up_view();
}

void Interactive::set_max_bounces(uint32_t count) {
    options_.max_bounces = count;
    if (view_) set_up_view();
}

void Interactive::set_upscale(double factor) {
    rendered_extent({options_.size.width, options_.size.height}, factor);
    options_.upscale = factor;
    if (view_) set_up_view();
}

void Interactive::set_layer(const std::string& name) {
    layer_ = name;
    if (view_) set_up_view();
}

std::vector<std::string> Interactive::layers() const {
    std::vector<std::string> names{""};
    for (const FilmGroup& group : film_groups())
        if (group.group != shared::kFilmBeauty && group.aov == group.name && (options_.renderer == RendererKind::Realtime || !group.name.starts_with("debug."))) names.emplace_back(group.name);
    return names;
}

bool Interactive::can_play() const { return loaded_ && (!options_.load.animate.empty() || !loaded_->scene.animations().empty()); }

void Interactive::set_time(double time) {
    seconds = std::max(0.0, time);
    time_set_ = true;
    moved_at_ = std::chrono::steady_clock::now();
}

void Interactive::resize(Size2 size) {
    if (size.width == 0 || size.height == 0 || (size.width == options_.size.width && size.height == options_.size.height)) return;
    options_.size = size;
    camera_.set_aspect(static_cast<float>(size.width) / static_cast<float>(size.height));
    if (view_) set_up_view();
    place_camera();
}

uint64_t Interactive::samples() const {
    return drawer_ ? drawer_->rows().samples : 0;
}

// The newest pictures of both sides, where both can be.
bool Interactive::is_compared() const {
    if (!split) return true;
    if (!beside_ || !beside_->is_finished() || beside_->is_comparing()) return false;
    return !layer_.empty() || (beside_->difference() && beside_->difference()->samples == shown_rows_.samples && beside_->difference()->reference_samples == beside_->rows().samples);
}

bool Interactive::is_finished() const {
    const bool rests = loaded_ && !is_loading() && progress_.complete && !play && !time_set_ && !meter_ && !is_saving() && !is_picking();
    return rests && shrink_ == 1 && samples() >= options_.samples.end && is_denoised() && is_compared();
}

}  // namespace parhelion
