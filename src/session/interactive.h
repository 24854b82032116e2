#pragma once
// A scene that a person looks at: it comes to the device in slices, is drawn for as long as nothing changes, and camera, renderer,
// settings and what is shown may change at any time. Knows no window: `parhelion-view` and tests drive it, frame by frame:
//
//     gpu::Image canvas = session.record();          // records the frame's work and leaves the picture in the canvas
//     ...                                            // the caller's passes, for example panels, and session.frame().show()
//     session.finish();                              // submits, waits, measures
#include <chrono>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderers/renderer.h"
#include "session/async_denoiser.h"
#include "session/job.h"
#include "session/steered_camera.h"
#include "session/view_drawer.h"
#include "session/view_setup.h"

namespace parhelion {

// How the film becomes the picture on the screen; the film does not depend on it.
struct ShowOptions {
    double exposure_ev = 0;  // EV100
    image::ToneCurve curve = image::ToneCurve::Agx;
    friend bool operator==(const ShowOptions&, const ShowOptions&) = default;
};

class Interactive {
public:
    // Loading begins at once, beside the caller. `options.samples.end` is where a picture is finished and rests. Throws Error for
    // settings that the device cannot draw with.
    Interactive(const RenderOptions& options, gpu::DevicePtr device);
    ~Interactive();
    Interactive(const Interactive&) = delete;
    Interactive& operator=(const Interactive&) = delete;

    // ---- a frame
    // rgba8, of the size of the window. Throws Error where the first scene cannot be loaded or the device fails.
    gpu::Image record();
    void finish();
    Frame& frame() { return *frame_; }
    const std::vector<PassTime>& passes() const { return passes_; }  // of the last frame
    double frame_seconds() const { return frame_seconds_; }          // of the last frame, by the clock, the wait for the display included

    // ---- what there is
    const RenderOptions& options() const { return options_; }
    const RenderSettings& settings() const { return settings_; }
    gpu::TraceWay way() const { return trace_.way; }
    const gpu::DevicePtr& device() const { return device_; }
    const Scene* scene() const { return loaded_ ? &loaded_->scene : nullptr; }  // null: still loading
    bool is_loading() const { return loading_.valid(); }
    const SceneProgress& scene_progress() const { return progress_; }
    uint64_t samples() const;   // in every pixel
    bool has_whole_frames() const { return drawer_ && !drawer_->has_preview(); }
    bool is_finished() const;   // nothing changes until something is changed
    const std::string& note() const { return note_; }  // the newest line for the person: what failed, what was written
    void set_note(std::string line) { note_ = std::move(line); }

    // ---- what a person changes. A usage Error leaves everything as it was.
    const SteeredCamera& camera() const { return camera_; }
    void set_camera(const SteeredCamera& camera);
    void choose_camera(const std::string& name);  // of the scene; empty: the one of the start
    void set_renderer(RendererKind kind);
    void set_settings(const RenderSettings& settings);
    void set_max_bounces(uint32_t count);         // 0: unlimited
    void set_upscale(double factor);              // of the realtime renderer with --denoise builtin: 1 to kMostUpscale
    void set_layer(const std::string& name);      // an AOV (film_groups()) instead of the beauty; empty: the beauty
    const std::string& layer() const { return layer_; }
    static std::vector<std::string> layers();     // all that can be shown, the beauty ("") first
    bool can_play() const;                        // something in the scene moves
    void resize(Size2 size);
    void reload();                                // the scene's file, in the background; the old one is drawn until it is there
    void meter() { meter_ = true; }               // sets the exposure from the scene
    void save_picture(const std::vector<std::filesystem::path>& files);  // as `parhelion render`, once every pixel has the same samples
    bool shows_denoised() const { return bool(denoised_); }  // --denoise oidn: the newest picture is without noise
    bool is_saving() const { return !to_save_.empty(); }

    ShowOptions show;  // the exposure is metered once the scene is there, unless the options give one
    bool accumulate = true;  // false: a renderer whose frames are whole pictures shows each alone
    bool play = false;       // the scene's animations or its scripted edit run
    double seconds = 0;      // where they stand

private:
    struct Loaded {
        std::unique_ptr<LoadedScene> scene;
        CameraView camera;
        std::string camera_name;
    };
    static Loaded load(const RenderOptions& options, const RenderSettings& settings);
    void take_loaded();
    void play_scene();
    void set_up_scene();
    void set_up_view();
    std::unique_ptr<ViewDrawer> make_drawer(RendererKind kind, const RenderSettings& settings) const;
    void clear();
    void draw();
    void draw_preview();
    bool is_due(const FilmRows& rows) const;
    void show_film(const View& view, const FilmRows& rows);
    uint32_t preview_factor() const;
    FilmCopy copy_film();
    void write_picture();
    void denoise();
    bool is_denoised() const;
    void take_denoised();
    void show_denoised();

    RenderOptions options_;
    RenderSettings settings_;
    gpu::DevicePtr device_;
    TraceDecision trace_;
    std::future<Loaded> loading_;
    std::unique_ptr<LoadedScene> loaded_;
    SteeredCamera camera_, first_camera_;
    std::unique_ptr<Frame> frame_;
    std::unique_ptr<SceneGpu> scene_gpu_;
    SceneProgress progress_;
    uint64_t version_ = 0;  // of the scene in the film
    std::unique_ptr<View> view_, preview_;
    std::unique_ptr<ViewDrawer> drawer_;
    uint32_t preview_samples_ = 0, preview_factor_ = 1;  // drawn since the film was cleared, and how coarse
    // What the newest picture shows.
    FilmRows shown_rows_;
    ShowOptions shown_with_;
    std::chrono::steady_clock::time_point shown_at_;
    bool fresh_ = true;  // no picture of this film has been shown
    // --denoise oidn: of the beauty, beside what is drawn.
    std::unique_ptr<AsyncDenoiser> denoiser_;
    uint64_t denoised_samples_ = 0;  // of the newest film that was given to it
    gpu::Image denoised_;            // its newest picture of this film, in nits
    std::string layer_;
    gpu::Image picture_;  // the newest, in its own size
    bool meter_ = false;
    std::vector<std::filesystem::path> to_save_;
    std::vector<PassTime> passes_;
    double frame_seconds_ = 0;
    std::chrono::steady_clock::time_point last_finish_ = std::chrono::steady_clock::now();
    std::string note_;
};

}  // namespace parhelion
