#include "session/frames_job.h"

#include <algorithm>

#include "base/error.h"
#include "base/file.h"
#include "base/log.h"
#include "image/tonemap.h"
#include "scene/load.h"
#include "session/dataset.h"
#include "session/film_state.h"
#include "session/frame_hash.h"
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
        find_kept();
        try {
            if (!is_interrupted()) play();
        } catch (const Error& error) {
            rethrow_with_frames(error);
        }
        if (!sequence() && pictures_ == 0 && report_.finished_end > first_counted()) write(report_.finished_end - 1);
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
    std::vector<std::filesystem::path> files_of(uint64_t frame) const;
    std::optional<uint64_t> cut_history() const;
    std::string hash_of(uint64_t frame) const { return frame_hash(sequence_hash_, frame, cut_history()); }
    bool is_kept(uint64_t frame) const { return frame - play_.frames.begin < kept_.size() && kept_[frame - play_.frames.begin]; }
    bool is_there(uint64_t frame) const;
    bool draws(uint64_t frame) const { return frame >= drawn_.begin && frame < drawn_.end && (realtime() || !is_kept(frame)); }
    void begin();
    void find_kept();
    void choose_drawn();
    void begin_dataset();
    void play();
    bool should_stop();
    bool move_to(uint64_t frame);
    bool draw(uint64_t frame);
    bool draw_slices(View& view, IndexRange samples);
    bool add_to_dataset(uint64_t frame);
    void note(uint64_t frame, double seconds, double gpu_seconds_before);
    void write(uint64_t frame);
    [[noreturn]] void rethrow_with_frames(const Error& error) const;
    void log_finished() const;

    const FramePlay& play_;
    std::optional<PlayedCamera> played_camera_;
    std::optional<Realtime> realtime_;  // where it is what draws
    std::optional<Dataset> dataset_;
    std::optional<View> reference_;  // the dataset's
    uint64_t reference_hash_ = 0, reference_sequence_hash_ = 0;
    RayCounts rays_, film_rays_;  // of all frames; of those that the film holds
    uint64_t sequence_hash_ = 0;
    std::vector<bool> kept_;  // by frame from the first of play_ on; empty: none is
    IndexRange drawn_;        // from the first to after the last frame that is drawn; a path tracer leaves out those that are kept
    uint64_t pictures_ = 0;
};

// So many samples of a path tracer's frame: no two frames have the same.
IndexRange path_samples(uint64_t frame, uint64_t count) {
    const uint64_t blocks = (count + shared::kSamplesPerBlock - 1) / shared::kSamplesPerBlock, first = frame * blocks * shared::kSamplesPerBlock;
    return {first, first + count};
}

IndexRange FramesJob::samples_of(uint64_t frame) const { return realtime() ? IndexRange{frame, frame + 1} : path_samples(frame, options_.samples.end); }

std::vector<std::filesystem::path> FramesJob::files_of(uint64_t frame) const {
    std::vector<std::filesystem::path> files = options_.output.files;
    for (std::filesystem::path& file : files)
        if (is_sequence(file)) file = frame_file(file, frame);
    return files;
}

// Frames before the first that is drawn, of which its history knows nothing, make its picture another one.
std::optional<uint64_t> FramesJob::cut_history() const { return realtime() && drawn_.begin > 0 ? play_.preroll : std::nullopt; }

// All of its files, as this command would write them: with the whole history, or the one of --preroll.
bool FramesJob::is_there(uint64_t frame) const {
    return std::ranges::all_of(files_of(frame), [&](const std::filesystem::path& file) {
        const std::string hash = read_frame_hash(file, options_.size);
        return !hash.empty() && (hash == frame_hash(sequence_hash_, frame, std::nullopt) || (play_.preroll && hash == frame_hash(sequence_hash_, frame, play_.preroll)));
    });
}

void FramesJob::begin() {
    if (sequence())
        for (const std::filesystem::path& file : files_of(play_.frames.begin)) check_writable(file);
    report_.size = options_.size;
    report_.upscale = options_.upscale;
    report_.wanted = {first_counted(), play_.frames.end};
    report_.finished_end = report_.resumed_at = first_counted();
    report_.frame_samples = realtime() ? 1 : options_.samples.end;
    report_.play = PlayReport{.play = play_, .frames = {}, .kept = {}};
    if (is_interrupted()) return;  // before there was a view
    sequence_hash_ = hash_sequence(options_, loaded_.scene, report_.settings_hash, denoiser_ ? denoiser_->version() : std::string());
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

void FramesJob::find_kept() {
    if (options_.resume && !is_interrupted()) {
        const IndexRange frames = play_.frames;
        kept_.resize(frames.end - frames.begin);
        Progress progress("looking at the frames that are there", double(kept_.size()));
        for (uint64_t frame = frames.begin; frame < frames.end && !should_stop(); ++frame) {
            progress.update(double(frame - frames.begin));
            if (!is_there(frame)) continue;
            kept_[frame - frames.begin] = true;
            report_.play->kept.push_back(frame);
        }
        log(LogLevel::Info, "{} of {} frames are there already and are kept", report_.play->kept.size(), kept_.size());
    }
    while (is_kept(report_.finished_end)) ++report_.finished_end;
    choose_drawn();
}

// The realtime renderer leans on the frames before: on all from frame 0 on, or --preroll of them.
void FramesJob::choose_drawn() {
    drawn_ = play_.frames;
    while (drawn_.begin < drawn_.end && is_kept(drawn_.begin)) ++drawn_.begin;
    while (drawn_.end > drawn_.begin && is_kept(drawn_.end - 1)) --drawn_.end;
    if (realtime() && drawn_.begin < drawn_.end) drawn_.begin -= std::min(play_.preroll.value_or(drawn_.begin), drawn_.begin);
}

// Its references are the frames of the reference path tracer with the same options.
void FramesJob::begin_dataset() {
    RenderOptions reference = options_;
    reference.renderer = RendererKind::Reference;
    reference.denoise = DenoiseKind::None;
    reference.samples = {0, options_.reference_samples};
    reference.aovs = {"variance"};
    reference.reconstruction_layers = false;
    const ViewDesc desc = describe_view(reference, settings_, camera_);
    reference_hash_ = hash_render(loaded_.scene, desc, settings_);
    reference_sequence_hash_ = hash_sequence(reference, loaded_.scene, reference_hash_, {});
    reference_.emplace(device_, desc);
    dataset_.emplace(options_.dataset, describe_dataset(options_, report_, reference_hash_));
    if (dataset_->size() != 0) log(LogLevel::Info, "{} has {} frames, which stay", escape_name(options_.dataset.string()), dataset_->size());
}

bool FramesJob::should_stop() {
    if (!is_interrupted()) report_.interrupt = platform::interrupt_requested();
    report_.out_of_time = is_out_of_time() && (sequence() ? pictures_ > 0 : report_.finished_end > first_counted());
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
        open_shutter(seconds);
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
    while (slicer.whole_samples() < samples.end) {
        if (!stand_at(slicer.whole_samples())) return false;
        const auto slice = slicer.next();
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
    report_.play->frames.push_back({.number = frame, .written = false, .time = time_of(frame), .ms = seconds * 1e3, .gpu_ms = (report_.gpu_seconds - gpu_seconds_before) * 1e3, .rays = rays});
    rays_.path += rays.path;
    rays_.shadow += rays.shadow;
}

void FramesJob::play() {
    // The frame before one that is drawn gives the previous frame's transforms and camera.
    const uint64_t first = drawn_.begin == 0 ? 0 : drawn_.begin - 1;
    const auto begin = Clock::now();
    Progress progress("rendering", double(drawn_.end - first));
    for (uint64_t frame = first; frame < drawn_.end && !should_stop(); ++frame) {
        progress.update(double(frame - first), fmt::format("frame {}/{}", frame - first, drawn_.end - first));
        const auto frame_begin = Clock::now();
        const double gpu_seconds = report_.gpu_seconds;
        if (!draws(frame) && !draws(frame + 1)) continue;
        if (!move_to(frame)) break;
        if (!draws(frame)) {
            run_frame();
            continue;
        }
        if (!draw(frame)) break;
        note(frame, seconds_since(frame_begin), gpu_seconds);
        if (frame < first_counted() || is_kept(frame)) continue;
        if (dataset_ && !add_to_dataset(frame)) break;
        report_.finished_end = frame + 1;
        if (sequence()) write(frame);
        report_.play->frames.back().written = sequence() || dataset_;
        while (is_kept(report_.finished_end)) ++report_.finished_end;
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
        pair.reference.attributes[kFrameAttribute] = frame_hash(reference_sequence_hash_, frame, std::nullopt);
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
    output.files = files_of(frame);
    const std::vector<uint64_t> counts(options_.size.height, samples.end - samples.begin);
    image::ImageF picture = picture_of(samples, counts);
    if (options_.reconstruction_layers) add_reconstruction_layers(realtime_->read_input(*frame_), picture);
    if (!play_.average) picture.attributes[kFrameAttribute] = hash_of(frame);
    write_pictures(output, picture);
    if (dataset_) return;
    report_.written = options_.output.files;
    ++pictures_;
}

// A lost device or a full disk leaves the frames before.
void FramesJob::rethrow_with_frames(const Error& error) const {
    if (!sequence() || dataset_ || pictures_ == 0) throw error;
    throw Error(error.code, error.problem, error.where,
                fmt::format("{}{} frames are written: the same command with --resume keeps them", error.hint.empty() ? "" : error.hint + "; ", pictures_));
}

void FramesJob::log_finished() const {
    const char* why = is_interrupted() ? "interrupted" : report_.out_of_time ? "time budget used up" : "done";
    const uint64_t kept = report_.play->kept.size(), wanted = report_.wanted.end - report_.wanted.begin;
    if (pictures_ == 0 && kept == 0) {
        log(LogLevel::Warn, "{} before the first frame was finished: nothing is written", why);
        return;
    }
    std::string names;
    for (const auto& file : report_.written) names += (names.empty() ? "" : ", ") + escape_name(file.string());
    if (kept == 0) log(LogLevel::Info, "{}: {} of {} frames in {}, written to {}", why, report_.sample_count(), wanted, format_duration(report_.render_seconds), names);
    else log(LogLevel::Info, "{}: {} of {} frames kept, {} drawn in {}{}{}", why, kept, wanted, pictures_, format_duration(report_.render_seconds), names.empty() ? "" : ", written to ", names);
    if (sequence() && !dataset_ && kept + pictures_ < wanted) log(LogLevel::Info, "the same command with --resume keeps these frames and draws the others");
}

}  // namespace

RenderReport run_frames_job(const RenderOptions& options, gpu::DevicePtr device) { return FramesJob(options, std::move(device)).run(); }

}  // namespace parhelion
