#include "session/job.h"

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "base/log.h"
#include "session/film_state.h"
#include "session/frames_job.h"
#include "session/job_base.h"
#include "session/pictures.h"
#include "session/progress.h"

namespace parhelion {

namespace {

class Job : JobBase {
public:
    Job(const RenderOptions& options, gpu::DevicePtr device) : JobBase(options, std::move(device)) {}

    RenderReport run() {
        prepare();
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
        const uint64_t samples = std::clamp<uint64_t>(kPathsPerSlot * Wavefront(device_, wavefront).slots() / pixels, 1, most);
        return measure_wavefront_trace_shares(device_, *scene_gpu_, way_, *view_, wavefront, static_cast<uint32_t>(samples));
    }

private:
    void resume();
    void render();
    [[noreturn]] void rethrow_with_checkpoint(const Error& error) const;
    bool should_stop();
    bool ends_block_first() const;  // a part or a checkpoint has whole blocks: who stops goes on until the end of one
    void show_progress(Progress& progress);
    void save_checkpoint();
    void write_outputs();
    void write_part();
    void write_picture();
    void log_finished() const;

    std::optional<Slicer> slicer_;
    Clock::time_point checkpoint_time_;
    uint64_t checkpoint_end_ = 0;
};

void Job::resume() {
    IndexRange samples = options_.samples;
    std::error_code ignored;
    if (options_.resume && std::filesystem::exists(options_.checkpoint, ignored)) {
        image::FilmSums film = read_checkpoint(options_.checkpoint, sums_of(view_->film_layout(), samples), samples);
        log(LogLevel::Info, "resuming after {} samples", film.sample_end - film.sample_begin);
        samples.begin = checkpoint_end_ = film.sample_end;
        view_->restore_film(film_readback(std::move(film), view_->film_layout()));
        view_->prepare(*frame_);
        frame_->run();
    }
    report_.size = options_.size;
    report_.wanted = options_.samples;
    report_.resumed_at = samples.begin;
    slicer_.emplace(make_slicer(samples));
}

bool Job::ends_block_first() const { return (options_.is_part || !options_.checkpoint.empty()) && slicer_->inside_block_end(); }

bool Job::should_stop() {
    if (report_.interrupt == platform::Interrupt::None) report_.interrupt = platform::interrupt_requested();
    if (report_.interrupt != platform::Interrupt::None) return !ends_block_first();
    if (!is_out_of_time()) return false;
    // Out of time. What is written needs at least one sample in every pixel, a part one block.
    const uint64_t done = slicer_->whole_samples();
    if (done <= options_.samples.begin ||
        (options_.is_part && (done / shared::kSamplesPerBlock * shared::kSamplesPerBlock) <= options_.samples.begin))
        return false;
    report_.out_of_time = true;
    return !ends_block_first();
}

void Job::show_progress(Progress& progress) {
    const uint64_t done = slicer_->whole_samples() - options_.samples.begin;
    progress.update(slicer_->done_work(), fmt::format("{}/{} spp", done, options_.samples.end - options_.samples.begin));
}

void Job::render() {
    const auto begin = checkpoint_time_ = Clock::now();
    Progress progress("rendering", slicer_->total_work());
    show_progress(progress);
    while (!should_stop()) {
        if (slicer_->whole_samples() < options_.samples.end && !stand_at(slicer_->whole_samples(), !ends_block_first())) break;
        const auto slice = slicer_->next();
        if (!slice) break;
        const auto slice_begin = Clock::now();
        draw(*view_, *slice, slice->first_sample + slice->sample_count == options_.samples.end);
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

void Job::save_checkpoint() {
    const uint64_t end = slicer_->whole_samples() / shared::kSamplesPerBlock * shared::kSamplesPerBlock;
    if (end <= options_.samples.begin || end <= checkpoint_end_) return;
    image::write_film_exr(options_.checkpoint, sums_of(view_->read_film(*frame_), {options_.samples.begin, end}));
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
    image::write_film_exr(options_.output.files.front(), sums_of(view_->read_film(*frame_), {options_.samples.begin, report_.finished_end}));
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
    write_pictures(options_.output, picture_of({options_.samples.begin, report_.finished_end}, counts));
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

}  // namespace

RenderReport run_render_job(const RenderOptions& options, gpu::DevicePtr device) {
    if (options.play) return run_frames_job(options, std::move(device));
    return Job(options, std::move(device)).run();
}
TraceShare measure_job_trace_share(const RenderOptions& options, gpu::DevicePtr device) {
    return Job(options, std::move(device)).measure_share();
}
WavefrontTraceShares measure_job_wavefront_trace_shares(const RenderOptions& options, gpu::DevicePtr device) {
    return Job(options, std::move(device)).measure_wavefront_shares();
}

}  // namespace parhelion
