#include "session/render_words.h"

#include <algorithm>
#include <array>
#include <numbers>

namespace parhelion {

namespace {

// Said by the session instead, or of no meaning to `render`.
constexpr std::array kSaidAnew = std::to_array<std::string_view>(
    {"--renderer", "--size", "--spp", "--max-bounces", "--denoise", "--upscale", "--exposure", "--tonemap", "--aov", "--set", "--trace", "--time", "--env", "--camera", "--look-from", "--look-at", "--fov",
     "--ortho-height", "--camera-path", "--aperture-radius", "--focus-distance", "--animate", "--animation", "--variant", "--device", "--present"});

class Words {
public:
    std::vector<std::string> list;
    void add(std::string_view option, std::string value) { list.insert(list.end(), {std::string(option), std::move(value)}); }
    void add_given(const OptionValues& given, const OptionSpec& option) {
        if (option.kind == ValueKind::Flag) {
            if (given.flag(option.name)) list.emplace_back(option.name);
            return;
        }
        for (const std::string& text : given.texts(option.name)) add(option.name, text);
    }
};

// Nine digits give a float back, seventeen a double.
std::string digits_of(const glm::vec3& v) { return fmt::format("{:.9g},{:.9g},{:.9g}", v.x, v.y, v.z); }
// The fewest that are read as the same number again.
std::string digits_of(double v) { return fmt::format("{}", v); }

std::string digits_of(const std::array<double, 3>& v) { return fmt::format("{},{},{}", v[0], v[1], v[2]); }

// One that was moved by its place; others as the options have it, which the session follows where the scene takes it.
void add_camera(Words& words, const Interactive& session) {
    const CameraView& view = session.camera().view();
    const RenderOptions& options = session.options();
    if (session.camera().has_moved()) {
        words.add("--look-from", digits_of(view.position));
        words.add("--look-at", digits_of(session.camera().aim()));
        if (view.orthographic) words.add("--ortho-height", digits_of(2.0 * double{view.half_extents.y}));
        else words.add("--fov", digits_of(double{view.yfov} * 180.0 / std::numbers::pi));
    } else {
        if (!options.camera.empty()) words.add("--camera", options.camera);
        if (options.look_from) words.add("--look-from", digits_of(*options.look_from));
        if (options.look_at) words.add("--look-at", digits_of(*options.look_at));
        if (options.ortho_height) words.add("--ortho-height", digits_of(*options.ortho_height));
        if (options.fov_degrees) words.add("--fov", digits_of(*options.fov_degrees));
        if (!options.camera_path.empty()) words.add("--camera-path", options.camera_path.string());
    }
    if (view.lens_radius == 0) return;
    words.add("--aperture-radius", digits_of(double{view.lens_radius}));
    words.add("--focus-distance", digits_of(double{view.focus_distance}));
}

void add_length(Words& words, const Interactive& session) {
    const uint64_t samples = std::max<uint64_t>(1, session.samples());
    if (session.options().renderer != RendererKind::Realtime) return words.add("--spp", std::to_string(samples));
    words.add("--frames", std::to_string(samples));
    words.list.insert(words.list.end(), {"--average", "--warmup", "0"});
}

void add_settings(Words& words, const RenderSettings& settings) {
    const std::vector<SettingRow> standard = list_settings(RenderSettings{}), now = list_settings(settings);
    for (size_t i = 0; i < now.size(); ++i)
        if (now[i].value != standard[i].value) words.add("--set", now[i].key + "=" + now[i].value);
}

}  // namespace

std::vector<std::string> render_words(const OptionValues& given, const Interactive& session) {
    constexpr std::array<const char*, 3> kRenderers = {"reference", "wavefront", "realtime"}, kDenoisers = {"none", "builtin", "oidn"}, kCurves = {"linear", "aces", "agx"};
    const RenderOptions& options = session.options();
    Words words;
    words.list = {"render", options.scene};
    words.add("--renderer", kRenderers[static_cast<size_t>(options.renderer)]);
    words.add("--size", fmt::format("{}x{}", options.size.width, options.size.height));
    add_length(words, session);
    add_camera(words, session);
    if (session.seconds != 0) words.add("--time", digits_of(session.seconds));
    if (!options.load.animate.empty()) words.add("--animate", options.load.animate);
    if (!options.load.animation.empty()) words.add("--animation", options.load.animation);
    if (!options.load.variant.empty()) words.add("--variant", options.load.variant);
    if (!options.environment.empty()) words.add("--env", options.environment);
    words.add("--exposure", digits_of(session.show.exposure_ev));
    words.add("--tonemap", kCurves[static_cast<size_t>(session.show.curve)]);
    if (options.max_bounces != RenderOptions{}.max_bounces) words.add("--max-bounces", std::to_string(options.max_bounces));
    if (options.denoise != DenoiseKind::None) words.add("--denoise", kDenoisers[static_cast<size_t>(options.denoise)]);
    if (options.upscale != 1 && session.layer().empty()) words.add("--upscale", digits_of(options.upscale));
    if (!session.layer().empty()) words.add("--aov", session.layer());
    words.add("--trace", std::string(gpu::trace_way_name(session.way())));
    if (!options.device.empty()) words.add("--device", options.device);
    const uint32_t renderer = 1u << static_cast<uint32_t>(options.renderer);
    for (const OptionSpec* option : options_of(given.command())) {
        const bool passes_on = (option->bits & kNotInPreset) == 0 && (option->renderers & renderer) != 0 && std::ranges::find(kSaidAnew, option->name) == kSaidAnew.end();
        if (passes_on && given.given(option->name)) words.add_given(given, *option);
    }
    add_settings(words, session.settings());
    for (const std::filesystem::path& file : options.output.files) words.add("--out", file.string());
    if (options.output.files.empty()) words.add("--out", "picture.exr");
    return words.list;
}

std::string shell_line(const std::vector<std::string>& words) {
    std::string line = "parhelion";
    for (const std::string& word : words) {
        const bool plain = !word.empty() && word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_=.,:/+%@") == std::string::npos;
        line += ' ';
        if (plain) line += word;
        else {
            line += '\'';
            for (const char letter : word) line += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
            line += '\'';
        }
    }
    return line;
}

}  // namespace parhelion
