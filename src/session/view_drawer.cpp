#include "session/view_drawer.h"

#include <algorithm>

#include "base/error.h"
#include "renderers/realtime.h"
#include "renderers/reference.h"
#include "renderers/wavefront.h"
#include "session/slicer.h"

namespace parhelion {

namespace {

FilmRows rows_of(const Slicer& slicer) {
    const std::vector<uint64_t> counts = slicer.samples_of_rows();
    const auto ahead = std::find(counts.begin(), counts.end(), counts.back());
    return {.samples = counts.back(), .rows_ahead = static_cast<uint32_t>(ahead - counts.begin()), .samples_ahead = counts.front()};
}

// The path tracer, a slice of rows and samples a frame.
class ReferenceDrawer : public ViewDrawer {
public:
    ReferenceDrawer(Size2 size, uint64_t max_samples) : size_(size), max_samples_(max_samples), slicer_(size, {0, max_samples}, kDrawSeconds) {}

    void record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view) override {
        slice_ = slicer_.next();
        if (slice_) record_reference(frame, scene, way, view, *slice_, false);
    }
    void ran(double seconds) override {
        if (!slice_) return;
        slicer_.measured(*slice_, seconds);
        slice_.reset();
        measured_ = true;
    }
    FilmRows rows() const override { return rows_of(slicer_); }
    double seconds_per_sample() const override { return measured_ ? double(size_.width) * size_.height * kDrawSeconds / double(slicer_.budget()) : 0; }
    void restart() override {
        slice_.reset();
        slicer_ = Slicer(size_, {0, max_samples_}, kDrawSeconds, slicer_.budget());
    }

private:
    Size2 size_;
    uint64_t max_samples_;
    Slicer slicer_;
    std::optional<shared::Slice> slice_;
    bool measured_ = false;
};

// The wavefront path tracer: a slice takes several frames, and its samples reach the film when it is finished.
class WavefrontDrawer : public ViewDrawer {
public:
    WavefrontDrawer(const gpu::DevicePtr& device, const WavefrontOptions& options, Size2 size, uint64_t max_samples)
        : machine_(device, options), size_(size), max_samples_(max_samples) {}

    void record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view) override {
        if (finished_) {
            machine_.finish(frame, view);
            end_slice(frame, view, *slice_, false);
            rows_ = rows_of(*slicer_);
            slice_.reset();
            finished_ = false;
        }
        if (!slicer_) slicer_.emplace(size_, IndexRange{0, max_samples_}, kSliceSeconds, budget_, machine_.slice_paths(view));
        if (!slice_ && (slice_ = slicer_->next())) {
            machine_.start(*slice_);
            slice_seconds_ = 0;
        }
        recorded_ = slice_.has_value();
        if (recorded_) machine_.record(frame, scene, way, view);
    }
    void ran(double seconds) override {
        if (!recorded_) return;
        recorded_ = false;
        slice_seconds_ += seconds;
        finished_ = machine_.advance(seconds, kDrawSeconds);
        if (!finished_) return;
        slicer_->measured(*slice_, slice_seconds_);
        seconds_per_sample_ = slice_seconds_ * size_.height / (double(slice_->row_count) * slice_->sample_count);
    }
    FilmRows rows() const override { return rows_; }
    double seconds_per_sample() const override { return seconds_per_sample_; }
    void restart() override {
        if (slice_ && !finished_) machine_.abandon();
        if (slicer_) budget_ = slicer_->budget();
        slice_.reset();
        slicer_.reset();
        rows_ = {};
        finished_ = recorded_ = false;
    }

private:
    static constexpr double kSliceSeconds = 0.5;  // at the end of each the machine runs empty
    Wavefront machine_;
    Size2 size_;
    uint64_t max_samples_, budget_ = 1u << 16;
    std::optional<Slicer> slicer_;
    std::optional<shared::Slice> slice_;
    FilmRows rows_;
    bool finished_ = false, recorded_ = false;
    double slice_seconds_ = 0, seconds_per_sample_ = 0;
};

// A frame is a sample of the film.
class RealtimeDrawer : public ViewDrawer {
public:
    RealtimeDrawer(gpu::DevicePtr device, const RealtimeOptions& options, uint64_t max_samples) : device_(std::move(device)), options_(options), max_samples_(max_samples) {}

    void record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view) override {
        if (samples_ >= max_samples_) return;
        if (!renderer_) renderer_.emplace(device_, view, options_);
        renderer_->record(frame, scene, way, view, false);
        ++samples_;
    }
    void ran(double) override {}
    FilmRows rows() const override { return {.samples = samples_}; }
    double seconds_per_sample() const override { return 0; }
    void restart() override { samples_ = 0; }  // its history goes on
    void set_exposure(float exposure) override {
        options_.exposure = exposure;
        if (renderer_) renderer_->set_exposure(exposure);
    }
    bool has_preview() const override { return false; }
    gpu::Buffer reservoirs() const override { return renderer_ ? renderer_->reservoirs() : gpu::Buffer(); }

private:
    gpu::DevicePtr device_;
    RealtimeOptions options_;
    uint64_t max_samples_, samples_ = 0;
    std::optional<Realtime> renderer_;
};

}  // namespace

std::unique_ptr<ViewDrawer> make_view_drawer(const gpu::DevicePtr& device, const DrawerOptions& options, const RenderSettings& settings) {
    switch (options.kind) {
        case RendererKind::Reference: return std::make_unique<ReferenceDrawer>(options.size, options.max_samples);
        case RendererKind::Wavefront: return std::make_unique<WavefrontDrawer>(device, wavefront_options(settings), options.size, options.max_samples);
        case RendererKind::Realtime: {
            RealtimeOptions realtime = realtime_options(settings, device->caps());
            if (options.denoise == DenoiseKind::Builtin) realtime.reconstruction = settings.reconstruction, realtime.upscale = options.upscale;
            return std::make_unique<RealtimeDrawer>(device, realtime, options.max_samples);
        }
    }
    throw Error(ErrorCode::Failed, "there is no such renderer", "--renderer");
}

}  // namespace parhelion
