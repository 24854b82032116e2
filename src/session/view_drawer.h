#pragma once
// A renderer as a program with a window uses it: some work a frame, into the film of a view, for as long as nothing changes.
#include <memory>
#include <optional>

#include "renderers/view.h"
#include "session/render_options.h"
#include "session/render_settings.h"

namespace parhelion {

// Samples in the rows of a film.
struct FilmRows {
    uint64_t samples = 0;        // of every row,
    uint32_t rows_ahead = 0;     // but for so many at the top,
    uint64_t samples_ahead = 0;  // which have so many
    friend bool operator==(const FilmRows&, const FilmRows&) = default;
};

class ViewDrawer {
public:
    virtual ~ViewDrawer() = default;
    // Records work of about kDrawSeconds for a drawable scene.
    virtual void record(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view) = 0;
    // That frame has run; its passes took so many seconds.
    virtual void ran(double seconds) = 0;
    // What the film holds once the passes recorded so far have run.
    virtual FilmRows rows() const = 0;
    // Seconds that a sample of the whole picture takes; 0: not known yet.
    virtual double seconds_per_sample() const = 0;
    // The film has been cleared: begins anew.
    virtual void restart() = 0;
    // About 1 over the nits of white: renderers that keep light in few bits keep it times this.
    virtual void set_exposure(float) {}
    // False: its first frame is whole and fast enough, so that a camera's move needs no coarser picture in front of it.
    virtual bool has_preview() const { return true; }
    // shared::PackedReservoir of each pixel, as the next frame finds them; null: it has none.
    virtual gpu::Buffer reservoirs() const { return {}; }
};

constexpr double kDrawSeconds = 0.04;  // of the device's time, for a frame that a person waits for

struct DrawerOptions {
    RendererKind kind = RendererKind::Reference;
    Size2 size;
    uint64_t max_samples = 0;  // a picture ends after so many
    DenoiseKind denoise = DenoiseKind::None;
    double upscale = 1;  // with DenoiseKind::Builtin
};

// Adding a renderer: a class in view_drawer.cpp and a line in this function. Throws Error if the device or the settings do not let it draw.
std::unique_ptr<ViewDrawer> make_view_drawer(const gpu::DevicePtr& device, const DrawerOptions& options, const RenderSettings& settings);

}  // namespace parhelion
