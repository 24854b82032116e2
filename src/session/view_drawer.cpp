#include "session/view_drawer.h"

#include <algorithm>

#include "base/error.h"
#include "renderers/reference.h"
#include "renderers/wavefront.h"
#include "session/slicer.h"

namespace parhelion {

namespace {

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
    double seconds_per_sample() const override { return measured_ ? double(size_.width) * size_.height * kDrawSeconds / double(slicer_.budget()) : 0; }
    std::optional<FilmRows> rows() const override {
        const std::vector<uint64_t> counts = slicer_.samples_of_rows();
        const auto ahead = std::find(counts.begin(), counts.end(), counts.back());
        return FilmRows{.samples = counts.back(), .rows_ahead = static_cast<uint32_t>(ahead - counts.begin()), .samples_ahead = counts.front()};
    }
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

// The wavefront path tracer: a slice is a sample or more of the whole picture, drawn in as many frames as it takes.
class WavefrontDrawer : public ViewDrawer {
public:
    WavefrontDrawer(const gpu::DevicePtr& device, const WavefrontOptions& options, Size2 size, uint64_t max_samples)
        : machine_(device, options), size_(size), max_samples_(max_samples) {}

    void record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view) override {
        recorded_ = false;
        if (ended_) {  // this frame shows the picture between two slices
            end_slice(frame, view, *ended_, false);
            ended_.reset();
            return;
        }
        if (!slice_ && samples_ < max_samples_) begin_next_slice();
        recorded_ = slice_.has_value();
        if (recorded_) machine_.record(frame, scene, way, view);
    }
    void ran(double seconds) override {
        if (!recorded_) return;
        slice_seconds_ += seconds;
        if (!machine_.advance(seconds, kDrawSeconds)) return;
        samples_ += slice_->sample_count;
        seconds_per_sample_ = slice_seconds_ / slice_->sample_count;
        const double wanted = slice_->sample_count * kSliceSeconds / std::max(slice_seconds_, 1e-6);
        wanted_samples_ = static_cast<uint32_t>(std::clamp(wanted, 1.0, 2.0 * slice_->sample_count));
        ended_ = slice_;
        slice_.reset();
    }
    std::optional<FilmRows> rows() const override { return slice_ ? std::nullopt : std::optional(FilmRows{.samples = samples_}); }
    double seconds_per_sample() const override { return seconds_per_sample_; }
    void restart() override {
        if (slice_) machine_.abandon();
        slice_.reset();
        ended_.reset();
        samples_ = 0;
    }

private:
    void begin_next_slice() {
        const uint64_t block_end = (samples_ / shared::kSamplesPerBlock + 1) * shared::kSamplesPerBlock;
        const uint64_t most = std::min(block_end, max_samples_) - samples_;
        slice_ = shared::Slice{0, size_.height, static_cast<uint32_t>(samples_), static_cast<uint32_t>(std::min<uint64_t>(wanted_samples_, most))};
        slice_seconds_ = 0;
        machine_.start(*slice_);
    }

    static constexpr double kSliceSeconds = 0.5;  // at the end of each the machine runs empty
    Wavefront machine_;
    Size2 size_;
    uint64_t max_samples_, samples_ = 0;
    std::optional<shared::Slice> slice_, ended_;
    bool recorded_ = false;
    double slice_seconds_ = 0, seconds_per_sample_ = 0;
    uint32_t wanted_samples_ = 1;
};

}  // namespace

std::unique_ptr<ViewDrawer> make_view_drawer(RendererKind kind, const gpu::DevicePtr& device, const RenderSettings& settings, Size2 size, uint64_t max_samples) {
    switch (kind) {
        case RendererKind::Reference: return std::make_unique<ReferenceDrawer>(size, max_samples);
        case RendererKind::Wavefront: return std::make_unique<WavefrontDrawer>(device, wavefront_options(settings), size, max_samples);
        case RendererKind::Realtime: break;
    }
    throw Error(ErrorCode::Usage, "it is not built into this version", "--renderer realtime", "use reference or wavefront");
}

}  // namespace parhelion
