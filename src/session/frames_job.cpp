#include "session/frames_job.h"

#include <algorithm>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "image/tonemap.h"
#include "scene/load.h"
#include "session/dataset.h"
#include "session/film_state.h"
#include "session/job_base.h"
#include "session/pictures.h"
#include "session/progress.h"
#include "session/reconstruction_layers.h"
#include "session/scene_setup.h"
#include "session/view_setup.h"

namespace parhelion {

namespace {

class FramesJob : JobBase {
public:
    FramesJob(const RenderOptions& options, gpu::DevicePtr device) : JobBase(options, std::move(device)), play_(*options.play) {}

    RenderReport run() {
        if (!options_.dataset.empty()) check_dataset_folder(options_.dataset);
        prepare();
        begin();
        if (!is_interrupted()) play();
        if (pictures_ == 0 && report_.finished_end > first_counted()) write(report_.finished_end - 1);
        log_finished();
        finish_report();
        report_.rays = rays_;
        return std::move(report_);
    }

private:
    bool realtime() const { return options_.renderer == RendererKind::Realtime; }
    bool sequence() const { return !options_.output.files.empty() && is_sequence(options_.output.files.front()); }
    uint64_t first_counted() const { return play_.average ? play_.warmup : play_.frames.begin; }
    bool keeps_film(uint64_t frame) const { return play_.average && frame != play_.warmup && frame != 0; }
    double time_of(uint64_t frame) const { return options_.load.time + (play_.fps > 0 ? static_cast<double>(frame) / play_.fps : 0.0); }
    // Samples of the film that a frame's are; the same frame always has the same ones.
    IndexRange samples_of(uint64_t frame) const;
    void begin();
    void begin_dataset();
    void play();
    bool should_stop();
    bool move_to(uint64_t frame);
    bool draw(uint64_t frame);
    bool draw_slices(View& view, IndexRange samples);
    bool add_to_dataset(uint64_t frame);
    void note(uint64_t frame, double seconds, double gpu_seconds_before);
    void write(uint64_t frame);
    void log_finished() const;

    const FramePlay& play_;
    std::optional<PlayedCamera> played_camera_;
    std::optional<Realtime> realtime_;  // where it is what draws
    std::optional<Dataset> dataset_;
    std::optional<View> reference_;  // the dataset's
    uint64_t reference_hash_ = 0;
    RayCounts rays_, film_rays_;  // of all frames; of those that the film holds
    uint64_t pictures_ = 0;
};

// So many samples of a path tracer's frame: no two frames have the same.
IndexRange path_samples(uint64_t frame, uint64_t count) {
    const uint64_t blocks = (count + shared::kSamplesPerBlock - 1) / shared::kSamplesPerBlock, first = frame * blocks * shared::kSamplesPerBlock;
    return {first, first + count};
}

IndexRange FramesJob::samples_of(uint64_t frame) const { return realtime() ? IndexRange{frame, frame + 1} : path_samples(frame, options_.samples.end); }

void FramesJob::begin() {
    for (const std::filesystem::path& file : options_.output.files)
        if (is_sequence(file)) check_writable(frame_file(file, play_.frames.begin));
    report_.size = options_.size;
    report_.upscale = options_.upscale;
    report_.wanted = {first_counted(), play_.frames.end};
    report_.finished_end = report_.resumed_at = first_counted();
    report_.frame_samples = realtime() ? 1 : options_.samples.end;
    report_.play = PlayReport{.play = play_, .frames = {}};
    if (is_interrupted()) return;  // before there was a view
    if (realtime()) {
        RealtimeOptions settings = realtime_options(settings_, device_->caps());
        settings.exposure = static_cast<float>(image::exposure_scale_from_ev100(report_.exposure_ev));
        if (options_.denoise == DenoiseKind::Builtin) settings.reconstruction = settings_.reconstruction;
        settings.upscale = options_.upscale;
        realtime_.emplace(device_, *view_, settings);
        realtime_->keep_input(options_.reconstruction_layers || !options_.dataset.empty());
    }
    if (!options_.dataset.empty()) begin_dataset();
    played_camera_.emplace(loaded_.scene, options_, camera_.opens);
}

// Its references are the frames of the reference path tracer with the same options.
void FramesJob::begin_dataset() {
    RenderOptions reference = options_;
    reference.renderer = RendererKind::Reference;
    reference.aovs = {"variance"};
    const ViewDesc desc = describe_view(reference, settings_, camera_);
    reference_hash_ = hash_render(loaded_.scene, desc, settings_);
    reference_.emplace(device_, desc);
    dataset_.emplace(options_.dataset, describe_dataset(options_, report_, reference_hash_));
    if (dataset_->size() != 0) log(LogLevel::Info, "{} has {} frames, which stay", escape_name(options_.dataset.string()), dataset_->size());
}

bool FramesJob::should_stop() {
    if (!is_interrupted()) report_.interrupt = platform::interrupt_requested();
    report_.out_of_time = is_out_of_time() && report_.finished_end > first_counted();
    return is_interrupted() || report_.out_of_time;
}

// What the shutter's closing shows is read on the way: the previous frame's transforms stay those of the previous frame.
bool FramesJob::move_to(uint64_t frame) {
    const double seconds = time_of(frame), closes = seconds + options_.shutter_seconds;
    Scene& scene = loaded_.scene;
    ChangeSet changes = scene.begin_frame();
    if (play_.fps > 0 && frame > 0) {
        if (options_.shutter_seconds > 0) {
            changes.append(scene.apply(state_at(loaded_, options_.load, closes)));
            camera_.closes = played_camera_->at(scene, closes);
        }
        changes.append(scene.apply(state_at(loaded_, options_.load, seconds)));
        camera_.opens = played_camera_->at(scene, seconds);
    }
    const float aspect = static_cast<float>(options_.size.width) / static_cast<float>(options_.size.height);
    view_->set_camera(shader_camera(camera_.opens, aspect), camera_.closes ? std::optional(shader_camera(*camera_.closes, aspect)) : std::nullopt,
                      keeps_film(frame));
    scene_gpu_->sync(scene, changes);
    return bring_in_scene(false);
}

// False: stopped before it was finished.
bool FramesJob::draw(uint64_t frame) {
    if (realtime()) {
        realtime_->set_frame_index(static_cast<uint32_t>(frame));
        realtime_->record(*frame_, *scene_gpu_, way_, *view_, false);
        run_frame();
        return true;
    }
    return draw_slices(*view_, samples_of(frame));
}

bool FramesJob::draw_slices(View& view, IndexRange samples) {
    Slicer slicer = make_slicer(samples);
    while (const auto slice = slicer.next()) {
        const auto begin = Clock::now();
        JobBase::draw(view, *slice, slice->first_sample + slice->sample_count == samples.end);
        slicer.measured(*slice, seconds_since(begin));
        if (should_stop()) return slicer.whole_samples() == samples.end;
    }
    return true;
}

void FramesJob::note(uint64_t frame, double seconds, double gpu_seconds_before) {
    const RayCounts before = std::exchange(film_rays_, view_->read_rays(*frame_));
    RayCounts rays = film_rays_;
    if (keeps_film(frame)) rays.path -= before.path, rays.shadow -= before.shadow;
    report_.play->frames.push_back({.number = frame, .time = time_of(frame), .ms = seconds * 1e3, .gpu_ms = (report_.gpu_seconds - gpu_seconds_before) * 1e3, .rays = rays});
    rays_.path += rays.path;
    rays_.shadow += rays.shadow;
}

void FramesJob::play() {
    // The frame before the first gives the previous frame's transforms and camera.
    const uint64_t first = realtime() || play_.frames.begin == 0 ? 0 : play_.frames.begin - 1;
    const auto begin = Clock::now();
    Progress progress("rendering", double(play_.frames.end - first));
    for (uint64_t frame = first; frame < play_.frames.end && !should_stop(); ++frame) {
        progress.update(double(frame - first), fmt::format("frame {}/{}", frame - first, play_.frames.end - first));
        const auto frame_begin = Clock::now();
        const double gpu_seconds = report_.gpu_seconds;
        if (!move_to(frame)) break;
        if (!realtime() && frame < play_.frames.begin) {
            run_frame();
            continue;
        }
        if (!draw(frame)) break;
        note(frame, seconds_since(frame_begin), gpu_seconds);
        if (frame < first_counted()) continue;
        if (dataset_ && !add_to_dataset(frame)) break;
        report_.finished_end = frame + 1;
        if (sequence()) write(frame);
        if (options_.list_frame && options_.output.files.empty() && !dataset_) break;
    }
    report_.render_seconds = seconds_since(begin);
}

// The frame's input, and its reference beside it: the realtime renderer does not notice. False: stopped before that was finished.
bool FramesJob::add_to_dataset(uint64_t frame) {
    if (!dataset_->has(frame)) {
        const IndexRange samples = path_samples(frame, options_.reference_samples);
        reference_->set_camera(view_->desc().camera);
        if (!draw_slices(*reference_, samples)) return false;
        const std::vector<uint64_t> counts(options_.size.height, options_.reference_samples);
        Dataset::Pair pair{.frame = frame, .time = time_of(frame), .input = realtime_->read_input(*frame_)};
        pair.layers = {.width = pair.input.size.width, .height = pair.input.size.height, .attributes = film_attributes(report_.settings_hash, report_.exposure_ev)};
        pair.reference = resolve_rows(make_film_sums(reference_->read_film(*frame_), options_.size, samples, film_attributes(reference_hash_, report_.exposure_ev)), counts);
        dataset_->add(std::move(pair), options_.output);
    }
    report_.written = options_.output.files;
    report_.written.push_back(options_.dataset);
    ++pictures_;
    return true;
}

// A frame of a sequence, the last one, or the mean of all that the film holds.
void FramesJob::write(uint64_t frame) {
    if (options_.output.files.empty()) return;
    if (realtime()) {
        end_block(*frame_, *view_);
        frame_->run();
    }
    IndexRange samples = samples_of(frame);
    if (play_.average) samples.begin = play_.warmup;
    OutputOptions output = options_.output;
    if (sequence())
        for (std::filesystem::path& file : output.files) file = frame_file(file, frame);
    const std::vector<uint64_t> counts(options_.size.height, samples.end - samples.begin);
    image::ImageF picture = picture_of(samples, counts);
    if (options_.reconstruction_layers) add_reconstruction_layers(realtime_->read_input(*frame_), picture);
    write_pictures(output, picture);
    if (dataset_) return;
    report_.written = options_.output.files;
    ++pictures_;
}

void FramesJob::log_finished() const {
    const char* why = is_interrupted() ? "interrupted" : report_.out_of_time ? "time budget used up" : "done";
    if (pictures_ == 0) {
        log(LogLevel::Warn, "{} before the first frame was finished: nothing is written", why);
        return;
    }
    std::string names;
    for (const auto& file : report_.written) names += (names.empty() ? "" : ", ") + escape_name(file.string());
    log(LogLevel::Info, "{}: {} of {} frames in {}, written to {}", why, report_.sample_count(), report_.wanted.end - report_.wanted.begin,
        format_duration(report_.render_seconds), names);
}

}  // namespace

RenderReport run_frames_job(const RenderOptions& options, gpu::DevicePtr device) { return FramesJob(options, std::move(device)).run(); }

}  // namespace parhelion
