#include "session/job_base.h"

#include <algorithm>

#include "base/error.h"
#include "base/file.h"
#include "base/hash.h"
#include "base/log.h"
#include "renderers/reference.h"
#include "sampling/shutter.h"
#include "scene/load.h"
#include "session/film_state.h"
#include "session/metering.h"
#include "session/pictures.h"
#include "session/progress.h"
#include "session/scene_setup.h"
#include "session/view_setup.h"

namespace parhelion {

namespace {

RenderSettings read_settings(const RenderOptions& options) {
    RenderSettings settings;
    for (const std::string& assignment : options.assignments) apply_assignment(settings, assignment);
    return settings;
}

void check_targets(const RenderOptions& options) {
    for (const std::filesystem::path& file : options.output.files) check_writable(file);
    if (!options.checkpoint.empty()) check_writable(options.checkpoint);
}

constexpr double kSliceSeconds = 0.06, kWavefrontSliceSeconds = 1.0;
constexpr uint64_t kFirstSlice = 1u << 15;  // pixel-samples

bool changes_picture(const ChangeSet& changes) { return !changes.instances.empty() || !changes.lights.empty() || !changes.materials.empty() || changes.environment; }

uint64_t count_triangles(const Scene& scene) {
    uint64_t count = 0;
    for (const auto& [handle, instance] : scene.instances()) count += scene.get(instance.drawn_mesh()).triangle_count;
    return count;
}

}  // namespace

JobBase::JobBase(const RenderOptions& options, gpu::DevicePtr device)
    : options_(options), settings_(read_settings(options)), device_(std::move(device)), began_(Clock::now()) {}

void JobBase::prepare() {
    check_targets(options_);
    if (options_.denoise == DenoiseKind::Oidn) denoiser_.emplace();
    check_way(options_.trace == TraceChoice::Auto || options_.trace == TraceChoice::Pipeline);
    load();
    open_device();
    set_up();
}

void JobBase::check_way(bool pipeline) const {
    if (options_.renderer == RendererKind::Realtime) check_realtime(settings_);
    check_reference({.texture_lod = settings_.texture_lod, .shade_in = settings_.shade_in}, pipeline);
}

// Adds the GPU times of the frame that has just been completed.
void JobBase::add_times() {
    for (const PassInfo& pass : frame_->passes()) {
        const std::string name = pass.variant.empty() ? pass.name : fmt::format("{} [{}]", pass.name, pass.variant);
        auto found = std::find_if(report_.passes.begin(), report_.passes.end(), [&](const PassTime& time) { return time.name == name; });
        if (found == report_.passes.end()) found = report_.passes.insert(report_.passes.end(), PassTime{name});
        found->ms += pass.gpu_ms;
        ++found->count;
    }
}

void JobBase::load() {
    const auto begin = Clock::now();
    loaded_ = load_scene(options_.scene, options_.load);
    add_light(loaded_.scene, options_, sky_options(settings_));
    camera_ = set_up_camera(loaded_, options_, settings_.culling == Culling::Gltf, report_.camera);
    open_shutter(options_.load.time);
    if (options_.shutter_seconds > 0 && !camera_.closes && !shutter_) log(LogLevel::Warn, "nothing moves while the shutter is open");
    report_.scene = options_.scene;
    report_.triangles = count_triangles(loaded_.scene);
    report_.instances = loaded_.scene.instances().size();
    report_.load_seconds = seconds_since(begin);
    log(LogLevel::Info, "scene {}: {} triangles in {} instances, camera {}", escape_name(report_.scene), report_.triangles,
        report_.instances, escape_name(report_.camera));
}

void JobBase::open_device() {
    if (!device_) device_ = gpu::Device::open({.selector = options_.device, .validate = options_.validate});
    trace_ = decide_trace(device_->caps(), options_.trace, settings_.node_layout);
    way_ = trace_.way;
    report_.trace_source = trace_.source;
    check_way(way_ == gpu::TraceWay::Pipeline);
    report_.device = device_->caps().name;
    report_.driver = device_->caps().driver;
    report_.trace = trace_way_name(way_);
    report_.renderer = split_choices(find_option(Command::Render, "--renderer")->choices)[static_cast<size_t>(options_.renderer)];
    report_.shade_in_hit = settings_.shade_in == ShadeIn::ClosestHit;
    log(LogLevel::Info, "device {} ({}), traces by {}", escape_name(report_.device), escape_name(report_.driver), report_.trace);
}

void JobBase::set_up() {
    const auto begin = Clock::now();
    frame_ = std::make_unique<Frame>(device_);
    scene_gpu_ = std::make_unique<SceneGpu>(device_, describe_scene_gpu(settings_, trace_, options_.renderer == RendererKind::Realtime && may_draw_pixels(settings_, device_->caps())));
    scene_gpu_->sync(loaded_.scene);
    if (!bring_in_scene(true)) return;
    const ViewDesc desc = describe_view(options_, settings_, camera_);
    view_ = std::make_unique<View>(device_, desc);
    view_->prepare(*frame_);
    frame_->run();
    add_times();
    if (options_.list_frame) report_.listing += "set-up\n" + frame_->listing(true);
    if (options_.renderer == RendererKind::Wavefront) wavefront_.emplace(device_, wavefront_options(settings_)).allocate(*scene_gpu_, *view_);
    report_.lights = scene_gpu_->stats().emitters;
    report_.exposure_metered = !options_.exposure_ev;
    report_.exposure_ev = options_.exposure_ev ? *options_.exposure_ev : meter_scene(device_, *frame_, *scene_gpu_, way_, desc);
    log(LogLevel::Info, "exposure EV100 {:.2f}{}", report_.exposure_ev, report_.exposure_metered ? ", metered from the scene" : "");
    report_.settings_hash = hash_render(loaded_.scene, desc, settings_, options_.upscale);
    if (shutter_) {
        Hasher hasher;
        hasher.add(report_.settings_hash).add(hash_motion(loaded_.scene)).add(shutter_->opens).add(options_.shutter_seconds);
        report_.settings_hash = hasher.text(options_.load.animation).text(options_.load.animate).value();
    }
    report_.setup_seconds = seconds_since(begin);
}

bool JobBase::bring_in_scene(bool shown, bool may_stop) {
    std::optional<Progress> progress;
    if (shown) progress.emplace("bringing the scene to the device", 1);
    while (true) {
        const SceneProgress state = scene_gpu_->update(*frame_);
        if (progress) progress->update(state.done / state.total, fmt::format("{:.0f} MB", state.done / 1e6));
        if (state.complete) break;
        frame_->run();
        add_times();
        if (options_.list_frame && shown) report_.listing += "scene\n" + frame_->listing(true) + "\n";
        report_.interrupt = platform::interrupt_requested();
        if (may_stop && is_interrupted()) return false;
    }
    const SceneGpuStats& stats = scene_gpu_->stats();
    report_.traced_triangles = stats.instanced_traced_triangles;
    report_.node_layout = stats.node_layout;
    report_.own_bottom_bytes = stats.own_bottom_bytes;
    report_.own_top_bytes = stats.own_top_bytes;
    report_.bottom_bytes_built = stats.bottom_bytes_built;
    report_.bottom_bytes = stats.bottom_bytes;
    return true;
}

void JobBase::open_shutter(double opens) {
    const bool can_move = !options_.load.animate.empty() || !loaded_.scene.animations().empty();
    shutter_.reset();
    if (options_.shutter_seconds > 0 && can_move) shutter_ = OpenShutter{opens};
}

bool JobBase::stand_at(uint64_t sample, bool may_stop) {
    if (!shutter_ || shutter_->sample == sample) return true;
    shutter_->sample = sample;
    const double share = sampling::shutter_share(static_cast<uint32_t>(sample), options_.seed);
    const ChangeSet changes = loaded_.scene.apply(state_at(loaded_, options_.load, shutter_->opens + share * options_.shutter_seconds));
    if (changes_picture(changes) && std::ranges::count(options_.aovs, "motion") != 0)
        throw Error(ErrorCode::Usage, "what moves while the shutter is open has no one place in the picture", "--aov motion", "leave out --shutter or this layer");
    scene_gpu_->sync(loaded_.scene, changes);
    return bring_in_scene(false, may_stop);
}

Slicer JobBase::make_slicer(IndexRange samples) const {
    const uint64_t most_samples = shutter_ ? 1 : shared::kSamplesPerBlock;
    if (!wavefront_) return {options_.size, samples, kSliceSeconds, kFirstSlice, Slicer::kMostWork, most_samples};
    // Its frames are short however long a slice is; but at the end of each the machine runs empty.
    return {options_.size, samples, kWavefrontSliceSeconds, kPathsPerSlot * wavefront_->slots(), wavefront_->slice_paths(*view_), most_samples};
}

void JobBase::run_frame() {
    frame_->run();
    add_times();
    report_.gpu_seconds += frame_->gpu_ms() / 1000;
    if (!options_.list_frame || slice_is_listed_) return;
    slice_is_listed_ = true;
    report_.listing += "\nslice\n" + frame_->listing(true);
}

void JobBase::draw(View& view, const shared::Slice& slice, bool ends_range) {
    if (!wavefront_) {
        record_reference(*frame_, *scene_gpu_, way_, view, slice, ends_range);
        return run_frame();
    }
    wavefront_->start(slice);
    for (bool finished = false; !finished;) {
        const auto begin = Clock::now();
        wavefront_->record(*frame_, *scene_gpu_, way_, view);
        run_frame();
        finished = wavefront_->advance(seconds_since(begin));
    }
    wavefront_->finish(*frame_, view);
    end_slice(*frame_, view, slice, ends_range);
    run_frame();
}

image::FilmSums JobBase::sums_of(FilmReadback film, IndexRange samples) const {
    return make_film_sums(std::move(film), options_.size, samples, film_attributes(report_.settings_hash, report_.exposure_ev));
}

image::ImageF JobBase::picture_of(IndexRange samples, std::span<const uint64_t> samples_of_rows) {
    image::ImageF picture = resolve_rows(sums_of(view_->read_film(*frame_), samples), samples_of_rows);
    if (!denoiser_) return picture;
    const auto begin = Clock::now();
    denoise_picture(*denoiser_, options_.aovs, options_.keep_noisy, picture);
    report_.denoiser = picture.attributes.at(kDenoiserAttribute);
    report_.denoise_seconds += seconds_since(begin);
    return picture;
}

void JobBase::finish_report() {
    report_.max_bounces = options_.max_bounces;
    if (view_) report_.rays = view_->read_rays(*frame_);
    if (wavefront_) {
        report_.wavefront = {wavefront_options(settings_), wavefront_->stats()};
        log(LogLevel::Info, "wavefront: {}", wavefront_line(*report_.wavefront));
        if (options_.list_frame) report_.listing += "\nwavefront\n" + wavefront_table(*report_.wavefront);
    }
    report_.memory = device_->memory_use();
    report_.peak_device_bytes = device_->peak_memory_bytes();
    report_.peak_host_bytes = platform::peak_resident_bytes();
    if (const uint64_t count = options_.validate ? device_->validation_message_count() : 0; count != 0)
        throw Error(ErrorCode::Failed, fmt::format("the validation layers reported {} messages", count), "--validate",
                    "they are printed above");
}

}  // namespace parhelion
