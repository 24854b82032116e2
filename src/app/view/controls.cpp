#include "app/view/controls.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "base/error.h"
#include "session/render_words.h"
#include "session/results.h"
#include "session/setting_presets.h"

namespace parhelion::view {

namespace {

constexpr float kTurn = 0.005f;      // radians a pixel
constexpr float kApproach = 0.85f;   // of the distance, a notch
constexpr float kSpeed = 0.6f;       // of the distance to the middle of the picture, a second
constexpr double kExposure = 0.25;   // stops a key press
constexpr float kLine = 0.02f;       // of the picture's width, a key press

}  // namespace

Controls::Controls(const OptionValues& given, Window& window, Interactive& session, Panels& panels, ShaderWatch& shaders)
    : given_(given), window_(window), session_(session), panels_(panels), shaders_(shaders) {
    window_.on_key = [this](int key) { panels_.change(session_, [&] { press(key); }); };
    window_.on_drop = [this](const std::vector<std::string>& files) {
        for (const std::string& file : files) open(file);
    };
}

Controls::~Controls() {
    window_.on_key = {};
    window_.on_drop = {};
}

void Controls::press(int key) {
    if (!keys_) return;
    const auto next = [](const auto& list, const auto& now) { return list[static_cast<size_t>(std::find(list.begin(), list.end(), now) - list.begin() + 1) % list.size()]; };
    switch (key) {
        case GLFW_KEY_ESCAPE: return window_.close();
        case GLFW_KEY_TAB: panels_.shown = !panels_.shown; return;
        case GLFW_KEY_F1: panels_.help = !panels_.help; return;
        case GLFW_KEY_F2: return copy();
        case GLFW_KEY_F5: return session_.reload();
        case GLFW_KEY_F6: return build_shaders();
        case GLFW_KEY_F12: return shoot();
        case GLFW_KEY_HOME: return session_.choose_camera("");
        case GLFW_KEY_C: return next_camera();
        case GLFW_KEY_F: return look_at(window_.pointer());
        case GLFW_KEY_X: return session_.pick(window_.pointer());
        case GLFW_KEY_R: return session_.set_renderer(static_cast<RendererKind>((static_cast<uint32_t>(session_.options().renderer) + 1) % 3));
        case GLFW_KEY_L: return session_.set_layer(next(session_.layers(), session_.layer()));
        case GLFW_KEY_T: session_.show.curve = static_cast<image::ToneCurve>((static_cast<uint32_t>(session_.show.curve) + 1) % 3); return;
        case GLFW_KEY_V: session_.split = session_.split ? std::nullopt : std::optional(0.5f); return;
        case GLFW_KEY_LEFT_BRACKET: return move_line(-kLine);
        case GLFW_KEY_RIGHT_BRACKET: return move_line(kLine);
        case GLFW_KEY_EQUAL:
        case GLFW_KEY_KP_ADD: session_.show.exposure_ev -= kExposure; return;
        case GLFW_KEY_MINUS:
        case GLFW_KEY_KP_SUBTRACT: session_.show.exposure_ev += kExposure; return;
        case GLFW_KEY_P: return save();
        case GLFW_KEY_SPACE: session_.play = session_.can_play() && !session_.play; return;
        default: return;
    }
}

void Controls::next_camera() {
    if (!session_.scene() || session_.scene()->cameras().empty()) return;
    camera_ = (camera_ + 1) % session_.scene()->cameras().size();
    session_.choose_camera(fmt::format("{}", camera_));
}

void Controls::move_line(float by) {
    if (session_.split) session_.split = std::clamp(*session_.split + by, 0.0f, 1.0f);
}

// The scene's name, numbered so that nothing is written over: `pattern` has the name and the number.
std::filesystem::path Controls::free_name(const char* pattern) const {
    std::string name = std::filesystem::path(session_.options().scene).stem().string();
    if (const size_t colon = name.find(':'); colon != std::string::npos) name.erase(0, colon + 1);
    std::error_code none;
    for (unsigned number = 1;; ++number)
        if (const std::filesystem::path file = fmt::format(fmt::runtime(pattern), name, number); !std::filesystem::exists(file, none)) return file;
}

void Controls::save() {
    std::vector<std::filesystem::path> files = session_.options().output.files;
    if (files.empty()) files.push_back(free_name("{}-{}.png"));
    session_.save_picture(files);
}

void Controls::copy() {
    const bool realtime = session_.options().renderer == RendererKind::Realtime;
    if (realtime) session_.accumulate = true;  // the line has the mean of frames
    const std::string line = shell_line(render_words(given_, session_));
    if (realtime) session_.begin_anew();
    window_.copy(line);
    print_result(line + "\n");
    session_.set_note("copied: " + line);
}

void Controls::open(const std::string& file) {
    std::string extension = std::filesystem::path(file).extension().string();
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    panels_.change(session_, [&] {
        if (extension == ".json") return session_.set_settings(read_preset_settings(file, session_.settings()));
        if (extension == ".hdr" || extension == ".exr") return session_.open_environment(file);
        session_.open_scene(file);
    });
}

void Controls::write_preset() {
    panels_.change(session_, [&] {
        const std::filesystem::path file = free_name("{}-preset-{}.json");
        write_preset_settings(file, session_.settings());
        session_.set_note("settings written to " + escape_name(file.string()));
    });
}

void Controls::look_at(glm::uvec2 pixel) {
    session_.pick(pixel);
    looks_ = true;
}

void Controls::shoot(const std::filesystem::path& file) { shot_ = file.empty() ? free_name("{}-window-{}.png") : file; }

void Controls::build_shaders() {
    panels_.change(session_, [&] {
        shaders_.build();
        session_.set_note("building the shaders");
    });
}

void Controls::poll_shaders() {
    panels_.change(session_, [&] {
        if (std::shared_ptr<const gpu::ShaderPack> pack = shaders_.poll()) {
            session_.use_shaders(std::move(pack));
            session_.set_note("the shaders are new");
        }
    });
}

void Controls::steer(const Panels::Input& input) {
    keys_ = input.keys;
    poll_shaders();
    if (std::exchange(panels_.wants_copy, false)) copy();
    if (std::exchange(panels_.wants_preset_file, false)) write_preset();
    if (!session_.scene()) return;
    SteeredCamera camera = session_.camera();
    const bool shift = window_.is_down(GLFW_KEY_LEFT_SHIFT), control = window_.is_down(GLFW_KEY_LEFT_CONTROL);
    bool moved = false;
    if (input.double_clicked) look_at(window_.pointer());
    else if (input.clicked && control) session_.pick(window_.pointer());
    if (looks_ && !session_.is_picking()) {
        looks_ = false;
        if (session_.picked() && session_.picked()->meets_surface) {
            camera.set_target(session_.picked()->position_ws);
            if (const CameraView& view = camera.view(); view.lens_radius > 0) camera.set_lens(view.lens_radius, camera.distance());
            moved = true;
        }
        session_.forget_pick();
    }
    if (input.move_x != 0 || input.move_y != 0) {
        const auto height = static_cast<float>(std::max(1u, session_.options().size.height));
        moved = input.left || input.right || input.middle;
        if (input.middle || (input.left && shift)) camera.pan(-input.move_x / height, input.move_y / height);
        else if (input.left) camera.orbit(input.move_x * kTurn, input.move_y * -kTurn);
        else if (input.right) camera.look(input.move_x * kTurn, input.move_y * -kTurn);
    }
    if (input.wheel != 0) {
        moved = true;
        const float factor = std::pow(kApproach, input.wheel);
        control ? camera.zoom(factor) : camera.approach(factor);
    }
    if (input.keys) {
        const auto axis = [&](int back, int ahead) { return static_cast<float>(window_.is_down(ahead)) - static_cast<float>(window_.is_down(back)); };
        const glm::vec3 way(axis(GLFW_KEY_A, GLFW_KEY_D), axis(GLFW_KEY_Q, GLFW_KEY_E), axis(GLFW_KEY_S, GLFW_KEY_W));
        if (way != glm::vec3(0.0f)) {
            camera.fly(way * (camera.distance() * kSpeed * std::min(input.seconds, 0.1f) * (shift ? 5.0f : control ? 0.2f : 1.0f)));
            moved = true;
        }
    }
    if (moved) session_.set_camera(camera);
}

}  // namespace parhelion::view
