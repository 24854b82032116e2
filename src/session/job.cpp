#include "session/job.h"

#include <algorithm>
#include <chrono>
#include <optional>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "renderers/reference.h"
#include "renderers/wavefront.h"
#include "scene/load.h"
#include "session/film_state.h"
#include "session/metering.h"
#include "session/pictures.h"
#include "session/progress.h"
#include "session/render_settings.h"
#include "session/scene_setup.h"
#include "session/slicer.h"
#include "session/view_setup.h"

namespace parhelion {

namespace {

using Clock = std::chrono::steady_clock;

constexpr uint64_t kPathsPerSlot = 16;  // of the wavefront's first slice

double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

RenderSettings read_settings(const RenderOptions& options) {
    RenderSettings settings;
    for (const std::string& assignment : options.assignments) apply_assignment(settings, assignment);
    return settings;
}

void check_targets(const RenderOptions& options) {
    for (const std::filesystem::path& file : options.output.files) check_writable(file);
    if (!options.checkpoint.empty()) check_writable(options.checkpoint);
}

uint64_t count_triangles(const Scene& scene) {
    uint64_t count = 0;
    for (const auto& [handle, instance] : scene.instances()) count += scene.get(instance.drawn_mesh()).triangle_count;
    return count;
}

// Adds the GPU times of the frame that has just been completed.
void add_times(std::vector<PassTime>& times, const Frame& frame) {
    for (const PassInfo& pass : frame.passes()) {
        const std::string name = pass.variant.empty() ? pass.name : fmt::format("{} [{}]", pass.name, pass.variant);
        auto found = std::find_if(times.begin(), times.end(), [&](const PassTime& time) { return time.name == name; });
        if (found == times.end()) found = times.insert(times.end(), PassTime{name});
        found->ms += pass.gpu_ms;
        ++found->count;
    }
}

class Job {
public:
    Job(const RenderOptions& options, gpu::DevicePtr device)
        : options_(options), settings_(read_settings(options)), device_(std::move(device)), began_(Clock::now()) {}

    RenderReport run() {
        check_targets(options_);
        check_way(options_.trace == TraceChoice::Auto || options_.trace == TraceChoice::Pipeline);
        load();
        open_device();
        set_up();
        if (is_interrupted()) {
            log_finished();
        } else {
            resume();
            try {
                render();
            } catch (const Error& error) {
                rethrow_with_checkpoint(error);
            }
            write_outputs();
        }
        finish_report();
        return std::move(report_);
    }

    TraceShare measure_share() {
        load();
        open_device();
        set_up();
        return is_interrupted() ? TraceShare{} : measure_trace_share(device_, *scene_gpu_, way_, *view_);
    }

    WavefrontTraceShares measure_wavefront_shares() {
        load();
        open_device();
        set_up();
        if (is_interrupted()) return {};
        const WavefrontOptions wavefront = wavefront_options(settings_);
        const uint64_t pixels = uint64_t{options_.size.width} * options_.size.height, most = std::min<uint64_t>(options_.samples.end, shared::kSamplesPerBlock);
        const Wavefront machine(device_, wavefront);
        const uint64_t paths = std::min(kPathsPerSlot * machine.slots(), machine.slice_paths(*view_));
        const uint64_t samples = std::clamp<uint64_t>(paths / pixels, 1, most);
        return measure_wavefront_trace_shares(device_, *scene_gpu_, way_, *view_, wavefront, static_cast<uint32_t>(samples));
    }

private:
    void check_way(bool pipeline) const { check_reference({.texture_lod = settings_.texture_lod, .shade_in = settings_.shade_in}, pipeline); }
    void load();
    void open_device();
    void set_up();
    bool bring_in_scene();
    void resume();
    void render();
    void draw(const shared::Slice& slice);
    void run_slice_frame();
    [[noreturn]] void rethrow_with_checkpoint(const Error& error) const;
    bool should_stop();
    bool is_interrupted() const { return report_.interrupt != platform::Interrupt::None; }
    void show_progress(Progress& progress);
    void save_checkpoint();
    image::FilmSums sums_of(FilmReadback film, uint64_t end) const;
    void write_outputs();
    void write_part();
    void write_picture();
    void finish_report();
    void log_finished() const;

    const RenderOptions& options_;
    RenderSettings settings_;
    gpu::DevicePtr device_;
    Clock::time_point began_;
    LoadedScene loaded_;
    MovingCamera camera_;
    TraceDecision trace_;
    gpu::TraceWay way_ = gpu::TraceWay::Compute;
    std::unique_ptr<SceneGpu> scene_gpu_;
    std::unique_ptr<Frame> frame_;
    std::unique_ptr<View> view_;
    std::optional<Wavefront> wavefront_;  // where it is what draws
    std::optional<Slicer> slicer_;
    bool slice_is_listed_ = false;
    Clock::time_point checkpoint_time_;
    uint64_t checkpoint_end_ = 0;
    RenderReport report_;
};

void Job::load() {
    const auto begin = Clock::now();
    loaded_ = load_scene(options_.scene, options_.load);
    add_light(loaded_.scene, options_, sky_options(settings_));
    camera_ = set_up_camera(loaded_, options_, settings_.culling == Culling::Gltf, report_.camera);
    report_.scene = options_.scene;
    report_.triangles = count_triangles(loaded_.scene);
    report_.instances = loaded_.scene.instances().size();
    report_.load_seconds = seconds_since(begin);
    log(LogLevel::Info, "scene {}: {} triangles in {} instances, camera {}", escape_name(report_.scene), report_.triangles,
        report_.instances, escape_name(report_.camera));
}

void Job::open_device() {
    if (!device_) device_ = gpu::Device::open({.selector = options_.device, .validate = options_.validate});
    trace_ = decide_trace(device_->caps(), options_.trace, settings_.node_layout);
    way_ = trace_.way;
    report_.trace_source = trace_.source;
    check_way(way_ == gpu::TraceWay::Pipeline);
    report_.device = device_->caps().name;
    report_.driver = device_->caps().driver;
    report_.trace = trace_way_name(way_);
    report_.shade_in_hit = settings_.shade_in == ShadeIn::ClosestHit;
    log(LogLevel::Info, "device {} ({}), traces by {}", escape_name(report_.device), escape_name(report_.driver), report_.trace);
}

void Job::set_up() {
    const auto begin = Clock::now();
    frame_ = std::make_unique<Frame>(device_);
    scene_gpu_ = std::make_unique<SceneGpu>(device_, describe_scene_gpu(settings_, trace_));
    scene_gpu_->sync(loaded_.scene);
    if (!bring_in_scene()) return;
    const ViewDesc desc = describe_view(options_, settings_, camera_);
    view_ = std::make_unique<View>(device_, desc);
    view_->prepare(*frame_);
    frame_->run();
    add_times(report_.passes, *frame_);
    if (options_.list_frame) report_.listing += "set-up\n" + frame_->listing(true);
    if (options_.renderer == RendererKind::Wavefront) wavefront_.emplace(device_, wavefront_options(settings_)).allocate(*scene_gpu_, *view_);
    report_.lights = scene_gpu_->stats().emitters;
    report_.exposure_metered = !options_.exposure_ev;
    report_.exposure_ev = options_.exposure_ev ? *options_.exposure_ev : meter_scene(device_, *frame_, *scene_gpu_, way_, desc);
    log(LogLevel::Info, "exposure EV100 {:.2f}{}", report_.exposure_ev, report_.exposure_metered ? ", metered from the scene" : "");
    report_.settings_hash = hash_render(loaded_.scene, desc, settings_);
    report_.setup_seconds = seconds_since(begin);
}

// False: interrupted.
bool Job::bring_in_scene() {
    Progress progress("bringing the scene to the device", 1);
    while (true) {
        const SceneProgress state = scene_gpu_->update(*frame_);
        progress.update(state.done / state.total, fmt::format("{:.0f} MB", state.done / 1e6));
        if (state.complete) break;
        frame_->run();
        add_times(report_.passes, *frame_);
        if (options_.list_frame) report_.listing += "scene\n" + frame_->listing(true) + "\n";
        report_.interrupt = platform::interrupt_requested();
        if (is_interrupted()) return false;
    }
    report_.node_layout = scene_gpu_->stats().node_layout;
    report_.own_bottom_bytes = scene_gpu_->stats().own_bottom_bytes;
    report_.own_top_bytes = scene_gpu_->stats().own_top_bytes;
    report_.bottom_bytes_built = scene_gpu_->stats().bottom_bytes_built;
    report_.bottom_bytes = scene_gpu_->stats().bottom_bytes;
    return true;
}

void Job::resume() {
    IndexRange samples = options_.samples;
    std::error_code ignored;
    if (options_.resume && std::filesystem::exists(options_.checkpoint, ignored)) {
        image::FilmSums film = read_checkpoint(options_.checkpoint, sums_of(view_->film_layout(), samples.end), samples);
        log(LogLevel::Info, "resuming after {} samples", film.sample_end - film.sample_begin);
        samples.begin = checkpoint_end_ = film.sample_end;
        view_->restore_film(film_readback(std::move(film), view_->film_layout()));
        view_->prepare(*frame_);
        frame_->run();
    }
    report_.size = options_.size;
    report_.wanted = options_.samples;
    report_.resumed_at = samples.begin;
    if (wavefront_) {
        // Its frames are short however long a slice is; but at the end of each the machine runs empty.
        constexpr double kSliceSeconds = 1.0;
        report_.renderer = "wavefront";
        slicer_.emplace(options_.size, samples, kSliceSeconds, kPathsPerSlot * wavefront_->slots(), wavefront_->slice_paths(*view_));
    } else {
        slicer_.emplace(options_.size, samples);
    }
}

bool Job::should_stop() {
    const bool in_block = options_.is_part || !options_.checkpoint.empty();
    if (report_.interrupt == platform::Interrupt::None) report_.interrupt = platform::interrupt_requested();
    if (report_.interrupt != platform::Interrupt::None) return !(in_block && slicer_->inside_block_end());
    if (!options_.time_budget_seconds || seconds_since(began_) < *options_.time_budget_seconds) return false;
    // Out of time. What is written needs at least one sample in every pixel, a part one block.
    const uint64_t done = slicer_->whole_samples();
    if (done <= options_.samples.begin ||
        (options_.is_part && (done / shared::kSamplesPerBlock * shared::kSamplesPerBlock) <= options_.samples.begin))
        return false;
    report_.out_of_time = true;
    return !(in_block && slicer_->inside_block_end());
}

void Job::show_progress(Progress& progress) {
    const uint64_t done = slicer_->whole_samples() - options_.samples.begin;
    progress.update(slicer_->done_work(), fmt::format("{}/{} spp", done, options_.samples.end - options_.samples.begin));
}

// Runs the frame that draws a slice, or a part of it.
void Job::run_slice_frame() {
    frame_->run();
    add_times(report_.passes, *frame_);
    report_.gpu_seconds += frame_->gpu_ms() / 1000;
    if (!options_.list_frame || slice_is_listed_) return;
    slice_is_listed_ = true;
    report_.listing += "\nslice\n" + frame_->listing(true);
}

void Job::draw(const shared::Slice& slice) {
    const bool ends_range = slice.first_sample + slice.sample_count == options_.samples.end;
    if (!wavefront_) {
        record_reference(*frame_, *scene_gpu_, way_, *view_, slice, ends_range);
        return run_slice_frame();
    }
    wavefront_->start(slice);
    for (bool finished = false; !finished;) {
        const auto begin = Clock::now();
        wavefront_->record(*frame_, *scene_gpu_, way_, *view_);
        run_slice_frame();
        finished = wavefront_->advance(seconds_since(begin));
    }
    wavefront_->finish(*frame_, *view_);
    end_slice(*frame_, *view_, slice, ends_range);
    run_slice_frame();
}

void Job::render() {
    const auto begin = checkpoint_time_ = Clock::now();
    Progress progress("rendering", slicer_->total_work());
    show_progress(progress);
    while (!should_stop()) {
        const auto slice = slicer_->next();
        if (!slice) break;
        const auto slice_begin = Clock::now();
        draw(*slice);
        slicer_->measured(*slice, seconds_since(slice_begin));
        show_progress(progress);
        if (options_.list_frame && options_.output.files.empty()) break;
        const bool at_block_end = slicer_->whole_samples() % shared::kSamplesPerBlock == 0 && slicer_->whole_samples() > checkpoint_end_;
        if (!options_.checkpoint.empty() && at_block_end && seconds_since(checkpoint_time_) > options_.checkpoint_seconds)
            save_checkpoint();
    }
    report_.render_seconds = seconds_since(begin);
    report_.finished_end = slicer_->whole_samples();
}

// A lost device takes its film with it; what a checkpoint holds is still there.
void Job::rethrow_with_checkpoint(const Error& error) const {
    if (checkpoint_end_ <= options_.samples.begin) throw error;
    const std::string hint =
        fmt::format("{}{} samples are in {}: the same command with --resume continues there", error.hint.empty() ? "" : error.hint + "; ",
                    checkpoint_end_ - options_.samples.begin, escape_name(options_.checkpoint.string()));
    throw Error(error.code, error.problem, error.where, hint);
}

image::FilmSums Job::sums_of(FilmReadback film, uint64_t end) const {
    return make_film_sums(std::move(film), options_.size, {options_.samples.begin, end},
                          film_attributes(report_.settings_hash, report_.exposure_ev));
}

void Job::save_checkpoint() {
    const uint64_t end = slicer_->whole_samples() / shared::kSamplesPerBlock * shared::kSamplesPerBlock;
    if (end <= options_.samples.begin || end <= checkpoint_end_) return;
    image::write_film_exr(options_.checkpoint, sums_of(view_->read_film(*frame_), end));
    checkpoint_end_ = end;
    checkpoint_time_ = Clock::now();
}

void Job::write_outputs() {
    const bool complete = report_.finished_end == options_.samples.end;
    // A last block that is not full has already been added: its sums cannot be continued.
    if (!options_.checkpoint.empty() && (!complete || options_.samples.end % shared::kSamplesPerBlock == 0)) save_checkpoint();
    if (options_.output.files.empty()) return;
    if (options_.is_part)
        write_part();
    else
        write_picture();
    log_finished();
}

void Job::write_part() {
    report_.finished_end = report_.finished_end / shared::kSamplesPerBlock * shared::kSamplesPerBlock;
    if (report_.finished_end <= options_.samples.begin) return;
    image::write_film_exr(options_.output.files.front(), sums_of(view_->read_film(*frame_), report_.finished_end));
    report_.written = options_.output.files;
}

void Job::write_picture() {
    if (report_.finished_end <= options_.samples.begin) return;
    if (report_.finished_end != options_.samples.end) {
        end_block(*frame_, *view_);
        frame_->run();
    }
    std::vector<uint64_t> counts = slicer_->samples_of_rows();
    for (uint64_t& count : counts) count -= options_.samples.begin;
    write_pictures(options_.output, resolve_rows(sums_of(view_->read_film(*frame_), report_.finished_end), counts));
    report_.written = options_.output.files;
}

void Job::log_finished() const {
    const uint64_t wanted = options_.samples.end - options_.samples.begin;
    const char* why = report_.interrupt != platform::Interrupt::None ? "interrupted" : report_.out_of_time ? "time budget used up" : "done";
    if (report_.written.empty()) {
        log(LogLevel::Warn, "{} before {} was finished: nothing is written", why,
            options_.is_part ? "the first block of 64 samples" : "the first sample of every pixel");
        return;
    }
    std::string names;
    for (const auto& file : report_.written) names += (names.empty() ? "" : ", ") + escape_name(file.string());
    log(LogLevel::Info, "{}: {} of {} samples in {}, written to {}", why, report_.sample_count(), wanted,
        format_duration(report_.render_seconds), names);
}

void Job::finish_report() {
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

}  // namespace

RenderReport run_render_job(const RenderOptions& options, gpu::DevicePtr device) { return Job(options, std::move(device)).run(); }
TraceShare measure_job_trace_share(const RenderOptions& options, gpu::DevicePtr device) {
    return Job(options, std::move(device)).measure_share();
}
WavefrontTraceShares measure_job_wavefront_trace_shares(const RenderOptions& options, gpu::DevicePtr device) {
    return Job(options, std::move(device)).measure_wavefront_shares();
}

}  // namespace parhelion
