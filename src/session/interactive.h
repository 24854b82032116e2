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
#include "scene/camera_path.h"
#include "session/async_denoiser.h"
#include "session/job.h"
#include "session/pixel_probe.h"
#include "session/reference_beside.h"
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

// What of a session goes on when its device does not: another Interactive begins with it.
struct InteractiveState {
    RenderOptions options;
    RenderSettings settings;
    std::optional<SteeredCamera> camera;  // none: that of the options
    std::shared_ptr<const gpu::ShaderPack> shaders;  // none: the built-in ones
    ShowOptions show;
    bool metered = true;  // the exposure is known
    std::string layer;
    bool accumulate = true, play = false;
    double seconds = 0;
};
// As the options say, before anything was changed. Throws a usage Error for a wrong assignment.
InteractiveState initial_state(const RenderOptions& options);

class Interactive {
public:
    // Loading begins at once, beside the caller. `options.samples.end` is where a picture is finished and rests. Throws Error for
    // settings that the device cannot draw with.
    Interactive(const InteractiveState& state, gpu::DevicePtr device);
    ~Interactive();
    Interactive(const Interactive&) = delete;
    Interactive& operator=(const Interactive&) = delete;

    // ---- a frame
    // rgba8, of the size of the window. Throws Error where the first scene cannot be loaded or the device fails.
    gpu::Image record();
    void finish();
    Frame& frame() { return *frame_; }
    const std::vector<PassTime>& passes() const { return passes_; }  // of the last frame that drew the picture
    InteractiveState state() const;
    double frame_seconds() const { return frame_seconds_; }          // of the last frame, by the clock, the wait for the display included

    // ---- what there is
    const RenderOptions& options() const { return options_; }
    const RenderSettings& settings() const { return settings_; }
    gpu::TraceWay way() const { return trace_.way; }
    const gpu::DevicePtr& device() const { return device_; }
    const Scene* scene() const { return loaded_ ? &loaded_->scene : nullptr; }  // null: still loading
    bool is_loading() const { return loading_.valid() || next_load_; }
    const SceneProgress& scene_progress() const { return progress_; }
    uint64_t samples() const;   // in every pixel
    bool has_whole_frames() const { return drawer_ && !drawer_->has_preview(); }
    bool is_finished() const;   // nothing changes until something is changed
    const std::string& note() const { return note_; }  // the newest line for the person: what failed, what was written
    void set_note(std::string line) { note_ = std::move(line); }

    // ---- what a person changes. A usage Error leaves everything as it was.
    const SteeredCamera& camera() const { return camera_; }
    void set_camera(const SteeredCamera& camera);
    void choose_camera(const std::string& name);  // of the scene; empty: the one of the start. It goes where the scene takes it until it is moved
    void set_renderer(RendererKind kind);
    void set_denoise(DenoiseKind kind);
    void set_settings(const RenderSettings& settings);
    void set_max_bounces(uint32_t count);         // 0: unlimited
    void set_upscale(double factor);              // of the realtime renderer with --denoise builtin: 1 to kMostUpscale
    void set_layer(const std::string& name);      // an AOV (film_groups()) instead of the beauty; empty: the beauty
    const std::string& layer() const { return layer_; }
    std::vector<std::string> layers() const;      // all that its renderer can show, the beauty ("") first
    bool can_play() const;                        // something in the scene moves
    void set_time(double time);                   // of the scene's clock, from 0 on
    void resize(Size2 size);
    void reload();                                // the scene's file, in the background; the old one is drawn until it is there
    void open_scene(const std::string& name);     // another one, in the same way; its own camera
    void open_environment(const std::string& file);  // for this scene
    void begin_anew();                            // as if nothing had been drawn before: the realtime renderer's history and cache, too
    // Shaders of the frames from now on. Throws Error and keeps the old ones if these cannot be used.
    void use_shaders(std::shared_ptr<const gpu::ShaderPack> pack);
    void meter() { meter_ = true; }               // sets the exposure from the scene
    void save_picture(const std::vector<std::filesystem::path>& files);  // as `parhelion render`, once every pixel has the same samples
    bool shows_denoised() const { return bool(denoised_); }  // --denoise oidn: the newest picture is without noise
    bool is_saving() const { return !to_save_.empty(); }

    // ---- beside the picture
    // The reference to the right of a line, from 0 (left edge) to 1; none: the picture alone. Both begin to be compared.
    std::optional<float> split;
    std::optional<Difference> difference() const { return beside_ ? beside_->difference() : std::nullopt; }
    uint64_t reference_samples() const { return beside_ ? beside_->rows().samples : 0; }
    // Looks into a pixel of the window with the next frame, and again whenever asked. What is known of the last one asked for:
    void pick(glm::uvec2 pixel) { to_pick_ = pixel; }
    const std::optional<PixelReport>& picked() const { return picked_; }
    void forget_pick();
    bool is_picking() const { return to_pick_ || probes_frame_ || probe_; }
    // Images that the passes of the last frame wrote, by name; one of them in the picture's place (empty: none), times a gain.
    const std::vector<std::string>& images() const { return images_; }
    std::string shown_image;
    float image_gain = 1;
    uint32_t shrink() const { return shrink_; }  // what moves is drawn so many times coarser

    ShowOptions show;  // the exposure is metered once the scene is there, unless the options give one
    bool accumulate = true;  // false: a renderer whose frames are whole pictures shows each alone
    bool play = false;       // the scene's animations or its scripted edit run
    double seconds = 0;      // where they stand

private:
    struct Loaded {
        RenderOptions options;  // that it was loaded with
        std::unique_ptr<LoadedScene> scene;
        CameraView camera;
        std::optional<CameraPath> path;
        std::string camera_name;
    };
    static Loaded load(const RenderOptions& options, const RenderSettings& settings);
    void load_with(RenderOptions options);
    void take_loaded();
    void play_scene();
    void place_camera();
    CameraView camera_of_options() const;
    void set_up_scene();
    void set_up_view();
    void replace_view();
    RenderOptions drawn_options() const;
    std::unique_ptr<ViewDrawer> make_drawer(RendererKind kind, const RenderSettings& settings, DenoiseKind denoise) const;
    void clear();       // film and reference: what they show is no more
    void clear_film();
    // A frame.
    void adapt_size();
    void draw();
    void draw_preview();
    void draw_beside();
    void close_beside();
    bool moves() const;
    bool picture_waits() const;
    void show_picture();
    bool shows_intermediate(const gpu::Image& canvas);
    void look_into_pixel();
    bool is_due(const FilmRows& rows) const;
    gpu::Image resolve_film(const View& view, const FilmRows& rows, const char* name);
    void tone(const gpu::Image& hdr, const char* name, gpu::Image& picture);
    uint32_t preview_factor() const;
    void measure(const std::vector<PassTime>& passes);
    // Pictures for the disk, and without noise.
    FilmCopy copy_film();
    void write_picture();
    void denoise();
    bool is_denoised() const;
    bool is_compared() const;
    void take_denoised();
    void show_denoised();

    RenderOptions options_;
    RenderSettings settings_;
    gpu::DevicePtr device_;
    TraceDecision trace_;
    std::future<Loaded> loading_;
    std::optional<RenderOptions> next_load_;  // asked for meanwhile
    std::unique_ptr<LoadedScene> loaded_;
    SteeredCamera camera_, first_camera_;
    bool has_camera_ = false;
    std::optional<CameraPath> camera_path_;
    RenderOptions start_;  // whose camera is that of the start
    std::unique_ptr<Frame> frame_;
    std::shared_ptr<const gpu::ShaderPack> shaders_;  // none: the built-in ones
    std::unique_ptr<SceneGpu> scene_gpu_;
    SceneProgress progress_;
    uint64_t version_ = 0;  // of the scene in the film
    bool time_set_ = false;
    std::unique_ptr<View> view_, preview_;
    std::unique_ptr<ViewDrawer> drawer_;
    std::unique_ptr<ReferenceBeside> beside_;
    std::vector<std::future<Difference>> left_;  // comparisons of references that are gone, which nothing waits for
    bool drew_picture_ = true;                   // in this frame
    double ahead_ = 0;                           // seconds that the device worked more at the picture than at the reference since both began
    uint32_t preview_samples_ = 0, preview_factor_ = 1;  // drawn since the film was cleared, and how coarse
    // Renderers whose frames are whole pictures, on devices that are slow at them.
    uint32_t shrink_ = 1;
    double pixel_seconds_ = 0;  // of such a frame, a pixel; 0: not known
    std::chrono::steady_clock::time_point moved_at_;
    // What the newest picture shows.
    FilmRows shown_rows_;
    ShowOptions shown_with_;
    std::chrono::steady_clock::time_point shown_at_;
    bool fresh_ = true;  // no picture of this film has been shown
    gpu::Image hdr_;     // it in nits, until another film is resolved
    // --denoise oidn: of the beauty, beside what is drawn.
    std::unique_ptr<AsyncDenoiser> denoiser_;
    uint64_t denoised_samples_ = 0;  // of the newest film that was given to it
    gpu::Image denoised_;            // its newest picture of this film, in nits
    std::string layer_;
    bool probes_layers_ = false, probes_frame_ = false;  // the film has what RealtimeProbe reads; the coming frame is what it reads
    std::optional<glm::uvec2> to_pick_;
    std::optional<PixelReport> picked_;
    std::optional<RealtimeProbe> probe_;  // of the frame that is recorded
    std::vector<std::string> images_;
    gpu::Image picture_, beside_picture_, looked_at_;  // the newest, in their own sizes
    bool meter_ = false;
    std::vector<std::filesystem::path> to_save_;
    std::vector<PassTime> passes_;
    double frame_seconds_ = 0;
    std::chrono::steady_clock::time_point last_finish_ = std::chrono::steady_clock::now();
    std::string note_;
};

}  // namespace parhelion
