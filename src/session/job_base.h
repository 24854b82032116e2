#pragma once
// What every render job does alike, whatever its pictures become: reads options into a scene, opens the device, brings the scene onto it,
// draws slices with a path tracer, and reports. Internal to the session layer.
#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "image/denoise.h"
#include "image/film.h"
#include "renderers/wavefront.h"
#include "scene/builtin.h"
#include "session/camera_setup.h"
#include "session/job.h"
#include "session/render_settings.h"
#include "session/slicer.h"
#include "session/trace_choice.h"

namespace parhelion {

class JobBase {
protected:
    using Clock = std::chrono::steady_clock;
    static double seconds_since(Clock::time_point begin) { return std::chrono::duration<double>(Clock::now() - begin).count(); }

    JobBase(const RenderOptions& options, gpu::DevicePtr device);

    // Everything up to the first sample. Throws Error for what cannot work, before any work where that can be known. Interrupted: report_
    // says so, and nothing more may be drawn.
    void prepare();
    void load();
    void open_device();
    void set_up();
    void check_way(bool pipeline) const;
    // Runs frames until the scene is on the device as it was at the last sync, but for the last of them. False: interrupted.
    bool bring_in_scene(bool shown, bool may_stop = true);

    // The shutter of the coming samples opens at this time, where the scene stands now. In a scene that can move every sample is then one of its own moment.
    void open_shutter(double opens);
    // Takes the scene there, before a slice that begins with this sample. False: interrupted, if it may stop there. Throws Error for what has no meaning where it moves.
    bool stand_at(uint64_t sample, bool may_stop = true);

    // For so many samples of the path tracer that the options name.
    Slicer make_slicer(IndexRange samples) const;
    void draw(View& view, const shared::Slice& slice, bool ends_range);
    // Runs what is recorded, and notes its times; the first frame that draws is listed.
    void run_frame();

    bool is_interrupted() const { return report_.interrupt != platform::Interrupt::None; }
    bool is_out_of_time() const { return options_.time_budget_seconds && seconds_since(began_) >= *options_.time_budget_seconds; }
    image::FilmSums sums_of(FilmReadback film, IndexRange samples) const;
    // The picture of so many samples in every row, denoised where that was asked for.
    image::ImageF picture_of(IndexRange samples, std::span<const uint64_t> samples_of_rows);
    void finish_report();

    const RenderOptions& options_;
    RenderSettings settings_;
    gpu::DevicePtr device_;
    Clock::time_point began_;
    LoadedScene loaded_;
    MovingCamera camera_;
    gpu::TraceWay way_ = gpu::TraceWay::Compute;
    TraceDecision trace_;
    std::unique_ptr<SceneGpu> scene_gpu_;
    std::unique_ptr<Frame> frame_;
    std::unique_ptr<View> view_;
    std::optional<Wavefront> wavefront_;  // where it is what draws
    std::optional<image::Denoiser> denoiser_;  // where pictures go through it
    RenderReport report_;

private:
    void add_times();

    struct OpenShutter {
        double opens;
        std::optional<uint64_t> sample = std::nullopt;  // at whose moment the scene stands; none: where it opened
    };
    std::optional<OpenShutter> shutter_;  // none: nothing but perhaps the camera can change while it is open
    bool slice_is_listed_ = false;
};

constexpr uint64_t kPathsPerSlot = 16;  // of the wavefront's first slice

}  // namespace parhelion
