#pragma once
// The options of `parhelion render` as typed values.
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/parse.h"
#include "image/tonemap.h"
#include "scene/load.h"
#include "session/options.h"

namespace parhelion {

enum class RendererKind { Reference, Wavefront, Realtime };
enum class DenoiseKind { None, Builtin, Oidn };
enum class TraceChoice { Auto, Pipeline, Query, Compute };

// Where a picture goes, and in which form.
struct OutputOptions {
    std::vector<std::filesystem::path> files;  // .exr and .png, all different
    bool exr_float = false;                    // else half
    image::ToneCurve tonemap = image::ToneCurve::Agx;
};

// Frames on the scene's clock: all of a sequence, the last one, or the mean of many.
struct FramePlay {
    IndexRange frames{0, 64};  // half open
    double fps = 0;            // 0: the clock stands at --time
    bool average = false;      // one picture: the mean of all frames after the warm-up
    uint64_t warmup = 0;       // frames
    std::optional<uint64_t> preroll = {};  // realtime: so many frames are drawn before the first that is written; none: all from frame 0 on
};

struct RenderOptions {
    std::string scene;  // file or builtin:NAME; empty with print_settings
    LoadOptions load;
    RendererKind renderer = RendererKind::Reference;
    DenoiseKind denoise = DenoiseKind::None;
    double upscale = 1;  // the picture's width and height over those of the realtime renderer's frames
    Size2 size{1280, 720};
    uint32_t seed = 0;
    IndexRange samples{0, 64};  // half open
    bool is_part = false;       // --spp-range: sums for `merge` instead of a picture
    std::optional<FramePlay> play;  // none: one picture of one moment. Of a path tracer every frame has all of `samples`
    std::optional<double> time_budget_seconds;
    uint32_t max_bounces = 16;  // 0: unlimited
    bool point_filter = false;
    std::optional<double> exposure_ev;  // none: metered from the scene

    std::string camera;  // name or index; empty: the scene's first
    std::optional<std::array<double, 3>> look_from, look_at;
    std::optional<double> fov_degrees;  // vertical
    std::optional<double> ortho_height;  // metres that the camera of look_from shows from top to bottom; none: it is perspective
    std::filesystem::path camera_path;  // file of a CameraPath; empty: none
    double shutter_seconds = 0;         // from load.time on
    double aperture_radius = 0;         // metres; 0: a pinhole
    std::optional<double> focus_distance;  // metres; none: of what lies in the picture's middle

    std::string environment;  // file; empty: the scene's
    double env_intensity = 1, env_rotation_degrees = 0;
    bool default_light = true;

    OutputOptions output;
    std::vector<std::string> aovs;     // layer names in table order
    bool keep_noisy = false;           // --aov noisy: the layer of what --denoise oidn was given
    bool reconstruction_layers = false;     // --aov reconstruction: what reconstruction gets of the frame
    std::filesystem::path dataset;          // folder of a Dataset; empty: none
    uint64_t reference_samples = 1024;      // a pixel of the dataset's references
    std::filesystem::path checkpoint;  // empty: none
    double checkpoint_seconds = 60;
    bool resume = false;  // from the checkpoint; of a sequence, keep the frames that are there
    std::string json;  // target of write_json
    bool list_frame = false;

    TraceChoice trace = TraceChoice::Auto;
    std::string device;
    bool validate = false;
    std::vector<std::string> assignments;  // group.field=value, in order
    bool print_settings = false;
};

// Values that passed check_options. Throws a usage Error where they do not fit each other.
RenderOptions read_render_options(const OptionValues& values);
// Of `parhelion view`: the samples end where a picture is finished.
RenderOptions read_view_options(const OptionValues& values);
OutputOptions read_output_options(const OptionValues& values);
LoadOptions read_load_options(const OptionValues& values);  // of every command that takes a scene
// "a.####.exr" stands for a file a frame: a run of '#' for its number with at least as many digits.
bool is_sequence(const std::filesystem::path& file);
std::filesystem::path frame_file(const std::filesystem::path& pattern, uint64_t frame);
bool is_png(const std::filesystem::path& file);  // by its extension; the other format is EXR

}  // namespace parhelion
