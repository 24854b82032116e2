#include "session/interactive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "renderers/reference.h"
#include "scene/load.h"
#include "session/film_state.h"
#include "session/metering.h"
#include "session/pictures.h"
#include "session/scene_setup.h"

namespace parhelion {

namespace {

constexpr double kSecondsOfUnknownCpu = 0.6;  // a sample of a picture that nobody has measured yet
constexpr uint32_t kCoarsest = 8;             // pixels of the picture along the side of one of a preview
constexpr uint32_t kPreviewSamples = 8;       // of it, if nothing moves, before the picture itself is begun

gpu::Extent extent_of(Size2 size) { return {size.width, size.height, 1}; }

// How values of a layer are shown: light is exposed, what lies in [0, 1] is not, directions are moved there.
enum class LayerKind { Light, Share, Direction };
LayerKind layer_kind(const std::string& name) {
    if (name == "normal") return LayerKind::Direction;
    return name == "albedo" || name == "roughness" ? LayerKind::Share : LayerKind::Light;
}

// Passes of one name together, in order of their first.
std::vector<PassTime> sum_passes(const Frame& frame) {
    std::vector<PassTime> times;
    for (const PassInfo& pass : frame.passes()) {
        auto found = std::find_if(times.begin(), times.end(), [&](const PassTime& time) { return time.name == pass.name; });
        if (found == times.end()) found = times.insert(times.end(), PassTime{pass.name});
        found->ms += pass.gpu_ms;
        ++found->count;
    }
    return times;
}

}  // namespace

Interactive::Interactive(const RenderOptions& options, gpu::DevicePtr device) : options_(options), device_(std::move(device)) {
    seconds = options_.load.time;
    for (const std::string& assignment : options_.assignments) apply_assignment(settings_, assignment);
    trace_ = decide_trace(device_->caps(), options_.trace, settings_.node_layout);
    check_reference({.texture_lod = settings_.texture_lod, .shade_in = settings_.shade_in}, trace_.way == gpu::TraceWay::Pipeline);
    make_drawer(options_.renderer, settings_);
    if (options_.denoise == DenoiseKind::Oidn) denoiser_ = std::make_unique<AsyncDenoiser>();
    show = {.exposure_ev = options_.exposure_ev.value_or(0), .curve = options_.output.tonemap};
    meter_ = !options_.exposure_ev;
    if (!options_.aovs.empty()) layer_ = options_.aovs.front();
    frame_ = std::make_unique<Frame>(device_);
    reload();
}

// A scene that is still being loaded is waited for: nothing can end a thread.
Interactive::~Interactive() = default;

Interactive::Loaded Interactive::load(const RenderOptions& options, const RenderSettings& settings) {
    Loaded out{.scene = std::make_unique<LoadedScene>(load_scene(options.scene, options.load))};
    add_light(out.scene->scene, options, sky_options(settings));
    out.camera = set_up_camera(*out.scene, options, settings.culling == Culling::Gltf, out.camera_name).opens;
    return out;
}

void Interactive::reload() {
    if (is_loading()) return;
    options_.load.time = seconds;
    loading_ = std::async(std::launch::async, [options = options_, settings = settings_] { return load(options, settings); });
}

void Interactive::take_loaded() {
    if (!loading_.valid() || loading_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return;
    try {
        Loaded next = loading_.get();
        const bool first = !loaded_;
        loaded_ = std::move(next.scene);
        first_camera_ = SteeredCamera(next.camera, orbit_distance(next.camera, loaded_->scene.bounds()));
        if (first) camera_ = first_camera_;
        note_ = fmt::format("{}, camera {}", escape_name(options_.scene), escape_name(next.camera_name));
        log(LogLevel::Info, "scene {}", note_);
        set_up_scene();
    } catch (const Error& error) {
        if (!loaded_) throw;
        note_ = error.line;  // the scene of before stays
        log_line(LogLevel::Error, error.line);
    }
}

void Interactive::set_up_scene() {
    if (!scene_gpu_) scene_gpu_ = std::make_unique<SceneGpu>(device_, describe_scene_gpu(settings_, trace_, may_draw_pixels(settings_, device_->caps())));
    scene_gpu_->sync(loaded_->scene);
    if (!view_) set_up_view();
}

std::unique_ptr<ViewDrawer> Interactive::make_drawer(RendererKind kind, const RenderSettings& settings) const {
    const double upscale = layer_.empty() ? options_.upscale : 1;  // a layer has a value a traced pixel
    return make_view_drawer(device_, {.kind = kind, .size = options_.size, .max_samples = options_.samples.end, .denoise = options_.denoise, .upscale = upscale}, settings);
}

void Interactive::set_up_view() {
    options_.aovs = layer_.empty() ? std::vector<std::string>{} : std::vector{layer_};
    view_ = std::make_unique<View>(device_, describe_view(options_, settings_, {.opens = camera_.view()}));
    drawer_ = make_drawer(options_.renderer, settings_);
    preview_.reset();
    clear();
}

// The film's samples are of something that is no more.
void Interactive::clear() {
    if (!view_) return;
    view_->clear_film();
    drawer_->restart();
    if (denoiser_) denoiser_->discard();
    denoised_ = {};
    denoised_samples_ = 0;
    preview_samples_ = 0;
    fresh_ = true;
}

void Interactive::set_camera(const SteeredCamera& camera) {
    camera_ = camera;
    if (!view_) return;
    const float aspect = static_cast<float>(options_.size.width) / static_cast<float>(options_.size.height);
    view_->set_camera(shader_camera(camera_.view(), aspect));
    clear();
}

void Interactive::choose_camera(const std::string& name) {
    if (!loaded_) return;
    if (name.empty()) return set_camera(first_camera_);
    const float aspect = static_cast<float>(options_.size.width) / static_cast<float>(options_.size.height);
    CameraView view = view_of(loaded_->scene.get(find_camera(loaded_->scene, name)), aspect);
    view.lens_radius = camera_.view().lens_radius;
    view.focus_distance = camera_.view().focus_distance;
    set_camera(SteeredCamera(view, orbit_distance(view, loaded_->scene.bounds())));
}

void Interactive::set_renderer(RendererKind kind) {
    std::unique_ptr<ViewDrawer> drawer = make_drawer(kind, settings_);
    options_.renderer = kind;
    if (!view_) return;
    drawer_ = std::move(drawer);
    clear();
}

void Interactive::set_settings(const RenderSettings& settings) {
    const RenderSettings before = settings_;
    const TraceDecision trace = decide_trace(device_->caps(), options_.trace, settings.node_layout);
    check_reference({.texture_lod = settings.texture_lod, .shade_in = settings.shade_in}, trace.way == gpu::TraceWay::Pipeline);
    make_drawer(options_.renderer, settings);
    settings_ = settings;
    trace_ = trace;
    if (settings.sun_elevation != before.sun_elevation || settings.sun_azimuth != before.sun_azimuth) reload();
    if (!loaded_) return;
    if (settings.culling != before.culling || settings.infinite_share != before.infinite_share || settings.node_layout != before.node_layout ||
        settings.bvh_loop != before.bvh_loop || settings.gbuffer_mode != before.gbuffer_mode || settings.proxy_ratio != before.proxy_ratio || settings.proxy_error != before.proxy_error) {
        scene_gpu_.reset();
        set_up_scene();
    }
    set_up_view();
}

void Interactive::set_max_bounces(uint32_t count) {
    options_.max_bounces = count;
    if (view_) set_up_view();
}

void Interactive::set_upscale(double factor) {
    rendered_extent(extent_of(options_.size), factor);
    options_.upscale = factor;
    if (view_) set_up_view();
}

void Interactive::set_layer(const std::string& name) {
    layer_ = name;
    if (view_) set_up_view();
}

std::vector<std::string> Interactive::layers() {
    std::vector<std::string> names{""};
    for (const FilmGroup& group : film_groups())
        if (group.group != shared::kFilmBeauty && group.aov == group.name) names.emplace_back(group.name);
    return names;
}

bool Interactive::can_play() const { return loaded_ && (!options_.load.animate.empty() || !loaded_->scene.animations().empty()); }

void Interactive::resize(Size2 size) {
    if (size.width == 0 || size.height == 0 || (size.width == options_.size.width && size.height == options_.size.height)) return;
    options_.size = size;
    camera_.set_aspect(static_cast<float>(size.width) / static_cast<float>(size.height));
    if (view_) set_up_view();
}

uint64_t Interactive::samples() const {
    return drawer_ ? drawer_->rows().samples : 0;
}

bool Interactive::is_finished() const {
    return loaded_ && !is_loading() && progress_.complete && !play && !meter_ && !is_saving() && samples() >= options_.samples.end && is_denoised();
}

// ---- a frame ----

void Interactive::play_scene() {
    if (!loaded_) return;
    Scene& scene = loaded_->scene;
    ChangeSet changes = scene.begin_frame();
    if (play) {
        seconds += std::min(frame_seconds_, 0.1);
        changes.append(scene.apply(state_at(*loaded_, options_.load, seconds)));
    }
    scene_gpu_->sync(scene, changes);
}

gpu::Image Interactive::record() {
    take_loaded();
    play_scene();
    if (!to_save_.empty() && samples() > 0) write_picture();
    if (denoiser_) denoise();
    if (scene_gpu_) progress_ = scene_gpu_->update(*frame_);
    if (progress_.drawable) draw();
    if (!picture_) {
        picture_ = gpu::Image(device_, "view/nothing", {.format = gpu::Format::Rgba8Unorm, .extent = {1, 1, 1}});
        constexpr std::array<uint8_t, 4> kGrey{24, 24, 24, 255};
        frame_->upload_image(picture_, std::as_bytes(std::span(kGrey)));
    }
    const gpu::Image canvas = frame_->image("view/canvas", extent_of(options_.size), gpu::Format::Rgba8Unorm);
    frame_->scale(picture_, canvas);
    return canvas;
}

void Interactive::draw() {
    if (meter_ && progress_.complete) {
        show.exposure_ev = meter_scene(device_, *frame_, *scene_gpu_, trace_.way, view_->desc());
        meter_ = false;
        log(LogLevel::Info, "exposure EV100 {:.2f}, metered from the scene", show.exposure_ev);
    }
    if (version_ != scene_gpu_->version() || (!accumulate && !drawer_->has_preview())) clear();
    version_ = scene_gpu_->version();
    if (preview_samples_ == 0) preview_factor_ = preview_factor();
    if (preview_factor_ > 1 && preview_samples_ < kPreviewSamples) return draw_preview();
    drawer_->set_exposure(static_cast<float>(image::exposure_scale_from_ev100(show.exposure_ev)));
    drawer_->record(*frame_, *scene_gpu_, trace_.way, *view_);
    if (denoiser_) take_denoised();
    // A newer noisy picture does not take its place: the next one without noise does.
    if (denoised_) {
        if (fresh_ || show != shown_with_) show_denoised();
        fresh_ = false;
        return;
    }
    // Until every pixel has a sample the preview is shown.
    if (const FilmRows rows = drawer_->rows(); rows.samples > 0 && is_due(rows)) {
        show_film(*view_, rows);
        shown_rows_ = rows;
        fresh_ = false;
    }
}

// A picture that only gets better is not shown every time that it does: a CPU has more to do with its time.
bool Interactive::is_due(const FilmRows& rows) const {
    constexpr std::chrono::milliseconds kOften(200);
    if (fresh_ || show != shown_with_ || has_whole_frames()) return true;
    return rows != shown_rows_ && (rows.samples >= options_.samples.end || std::chrono::steady_clock::now() - shown_at_ >= kOften);
}

// How much coarser a picture must be to be drawn while a person waits.
uint32_t Interactive::preview_factor() const {
    if (!drawer_->has_preview()) return 1;
    double seconds_per_sample = drawer_->seconds_per_sample();
    if (seconds_per_sample == 0 && device_->caps().type == gpu::DeviceType::Cpu) seconds_per_sample = kSecondsOfUnknownCpu;
    const double factor = std::ceil(std::sqrt(seconds_per_sample / kDrawSeconds));
    return std::clamp(static_cast<uint32_t>(factor), 1u, kCoarsest);
}

void Interactive::draw_preview() {
    ViewDesc desc = view_->desc();
    desc.width = std::max(1u, desc.width / preview_factor_);
    desc.height = std::max(1u, desc.height / preview_factor_);
    if (!preview_ || preview_->desc().width != desc.width || preview_->desc().height != desc.height) preview_ = std::make_unique<View>(device_, desc);
    else if (preview_samples_ == 0) preview_->set_camera(desc.camera);
    record_reference(*frame_, *scene_gpu_, trace_.way, *preview_, {0, desc.height, preview_samples_++, 1}, false);
    show_film(*preview_, {.samples = preview_samples_});
}

void Interactive::show_film(const View& view, const FilmRows& rows) {
    const passes::Film& film = view.film();
    passes::Shown shown{.samples = rows.samples, .rows_ahead = rows.rows_ahead, .samples_ahead = rows.samples_ahead};
    const LayerKind kind = layer_kind(layer_);
    if (!layer_.empty()) {
        const auto& channels = view.channels();
        const auto of_layer = [&](const std::string& name) { return name == layer_ || name.starts_with(layer_ + "."); };
        const auto first = std::find_if(channels.begin(), channels.end(), of_layer);
        if (first != channels.end()) shown.first_channel = static_cast<uint32_t>(first - channels.begin());
        if (first != channels.end()) shown.channel_count = static_cast<uint32_t>(std::count_if(channels.begin(), channels.end(), of_layer));
    }
    if (kind == LayerKind::Direction) shown.gain = shown.bias = 0.5f;
    const float scale = kind == LayerKind::Light ? static_cast<float>(image::exposure_scale_from_ev100(show.exposure_ev)) : 1.0f;
    const auto curve = kind == LayerKind::Light ? static_cast<passes::ToneCurve>(show.curve) : passes::ToneCurve::Linear;
    const gpu::Image hdr = passes::resolve(*frame_, film.sums, film.block, film.width, film.height, shown);
    picture_ = frame_->image("view/picture", hdr.extent(), gpu::Format::Rgba8Unorm);
    passes::tonemap(*frame_, hdr, picture_, scale, curve);
    shown_with_ = show;
    shown_at_ = std::chrono::steady_clock::now();
}

// ---- without noise ----

bool Interactive::is_denoised() const { return !denoiser_ || !layer_.empty() || (denoised_samples_ >= options_.samples.end && denoiser_->is_idle()); }

// A film is given away when it has twice the samples of the one before, and when it is finished.
void Interactive::denoise() {
    const uint64_t have = samples(), wanted = std::min(std::max<uint64_t>(1, 2 * denoised_samples_), options_.samples.end);
    if (!layer_.empty() || !denoiser_->is_idle() || have < wanted || have == denoised_samples_) return;
    denoised_samples_ = have;
    denoiser_->start(copy_film());
}

void Interactive::take_denoised() {
    try {
        const std::optional<image::ImageF> picture = denoiser_->take();
        if (!picture) return;
        const image::RgbPlanes colours = image::rgb_planes(*picture);
        std::vector<float> texels(4 * picture->pixel_count(), 1.0f);
        for (size_t i = 0; i < picture->pixel_count(); ++i) texels[4 * i] = colours.r[i], texels[4 * i + 1] = colours.g[i], texels[4 * i + 2] = colours.b[i];
        denoised_ = gpu::Image(device_, "view/denoised", {.format = gpu::Format::Rgba32Float, .extent = extent_of(options_.size)});
        frame_->upload_image(denoised_, std::as_bytes(std::span(texels)));
        fresh_ = true;
    } catch (const Error& error) {
        note_ = error.line;  // the noisy picture stays
        log_line(LogLevel::Error, error.line);
    }
}

void Interactive::show_denoised() {
    picture_ = frame_->image("view/picture", denoised_.extent(), gpu::Format::Rgba8Unorm);
    passes::tonemap(*frame_, denoised_, picture_, static_cast<float>(image::exposure_scale_from_ev100(show.exposure_ev)), static_cast<passes::ToneCurve>(show.curve));
    shown_with_ = show;
    shown_at_ = std::chrono::steady_clock::now();
}

void Interactive::finish() {
    frame_->run();
    const auto now = std::chrono::steady_clock::now();
    frame_seconds_ = std::chrono::duration<double>(now - std::exchange(last_finish_, now)).count();
    passes_ = sum_passes(*frame_);
    // Not what the display takes its time for.
    double busy = 0;
    for (const PassTime& pass : passes_)
        if (pass.name != "transfer/show") busy += pass.ms / 1000;
    if (drawer_) drawer_->ran(busy > 0 ? busy : frame_seconds_);
}

// ---- a picture for the disk ----

void Interactive::save_picture(const std::vector<std::filesystem::path>& files) { to_save_ = files; }

// The film goes on as if nothing had happened: its last block is ended on a copy.
FilmCopy Interactive::copy_film() {
    const FilmRows rows = drawer_->rows();
    const passes::Film& film = view_->film();
    const gpu::Buffer block(device_, "film/kept_block", film.block.bytes()), sums(device_, "film/kept_sums", film.sums.bytes());
    frame_->copy(film.block, 0, block, 0, film.block.bytes());
    frame_->copy(film.sums, 0, sums, 0, film.sums.bytes());
    end_block(*frame_, *view_);
    FilmReadback read = view_->read_film(*frame_);
    frame_->copy(block, 0, film.block, 0, film.block.bytes());
    frame_->copy(sums, 0, film.sums, 0, film.sums.bytes());
    const uint64_t hash = hash_render(loaded_->scene, view_->desc(), settings_);
    std::vector<uint64_t> counts(options_.size.height, rows.samples);
    std::fill_n(counts.begin(), rows.rows_ahead, rows.samples_ahead);
    return {make_film_sums(std::move(read), options_.size, {0, rows.samples}, film_attributes(hash, show.exposure_ev)), std::move(counts)};
}

void Interactive::write_picture() {
    const FilmCopy film = copy_film();
    OutputOptions output{.files = std::exchange(to_save_, {}), .exr_float = options_.output.exr_float, .tonemap = show.curve};
    try {
        image::ImageF picture = resolve_rows(film.sums, film.samples_of_rows);
        if (denoiser_) denoise_picture(image::Denoiser(), options_.aovs, false, picture);
        write_pictures(output, picture);
        note_ = fmt::format("{} samples written to", film.sums.sample_end);
        for (const std::filesystem::path& file : output.files) note_ += " " + escape_name(file.string());
        log(LogLevel::Info, "{}", note_);
    } catch (const Error& error) {
        note_ = error.line;
        log_line(LogLevel::Error, error.line);
    }
}

}  // namespace parhelion
