#pragma once
// The reference of what a window shows, beside it: it accumulates while nothing moves, and both are compared from time to time.
#include <chrono>
#include <future>
#include <memory>
#include <optional>

#include "session/view_drawer.h"

namespace parhelion {

// The shown picture against the reference, as both stood (image/compare.h).
struct Difference {
    uint64_t samples = 0, reference_samples = 0;
    double mean_ratio = 0;  // of luminance
    double relmse = 0, flip = 0;
};

class ReferenceBeside {
public:
    // `view`: the shown one's, whose layers, size and pixel filter the reference has.
    ReferenceBeside(const gpu::DevicePtr& device, const ViewDesc& view, uint64_t max_samples);
    ~ReferenceBeside() = default;  // waits for a comparison that runs, unless that was taken away
    std::future<Difference> take_comparison() { return std::move(comparing_); }

    void set_camera(const shared::Camera& camera);
    void clear();
    // Records a slice of samples; `ran`: that took so many seconds.
    void record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way);
    void ran(double seconds) { drawer_->ran(seconds); }
    const View& view() const { return *view_; }
    FilmRows rows() const { return drawer_->rows(); }
    bool is_finished() const { return rows().samples >= max_samples_; }
    bool is_comparing() const { return reading_ || comparing_.valid(); }

    // A comparison runs beside the caller, none sooner than a second after the one before, and none of samples that were compared before.
    bool wants_comparison(uint64_t samples) const;
    // Reads both pictures back (nits, rgba32f, of one size): with the frame's next run() they are there.
    void read(Frame& frame, const gpu::Image& shown, const gpu::Image& reference, uint64_t samples);
    // After each frame: begins with what was read, takes in what is done.
    void compare();
    const std::optional<Difference>& difference() const { return difference_; }  // the newest of what is seen now; none: it has not come to one

private:
    struct Reading {
        gpu::Buffer shown, reference;
        Difference counts;
    };
    std::unique_ptr<View> view_;
    std::unique_ptr<ViewDrawer> drawer_;
    uint64_t max_samples_ = 0, generation_ = 0, compared_generation_ = 0;
    std::optional<Reading> reading_;
    std::future<Difference> comparing_;
    std::optional<Difference> difference_;
    std::chrono::steady_clock::time_point compared_at_;
};

}  // namespace parhelion
