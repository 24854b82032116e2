#include "app/view/controls.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "base/error.h"
#include "base/log.h"

namespace parhelion::view {

namespace {

constexpr float kTurn = 0.005f;      // radians a pixel
constexpr float kApproach = 0.85f;   // of the distance, a notch
constexpr float kSpeed = 0.6f;       // of the distance to the middle of the picture, a second
constexpr double kExposure = 0.25;   // stops a key press

}  // namespace

Controls::Controls(Window& window, Interactive& session, Panels& panels) : window_(window), session_(session), panels_(panels) {
    window_.on_key = [this](int key) { press(key); };
}

void Controls::press(int key) {
    if (!keys_) return;
    const auto next = [](const auto& list, const auto& now) { return list[static_cast<size_t>(std::find(list.begin(), list.end(), now) - list.begin() + 1) % list.size()]; };
    switch (key) {
        case GLFW_KEY_ESCAPE: return window_.close();
        case GLFW_KEY_TAB: panels_.shown = !panels_.shown; return;
        case GLFW_KEY_F1: panels_.help = !panels_.help; return;
        case GLFW_KEY_HOME: return session_.choose_camera("");
        case GLFW_KEY_C: return next_camera();
        case GLFW_KEY_R: return panels_.change(session_, [&] { session_.set_renderer(static_cast<RendererKind>((static_cast<uint32_t>(session_.options().renderer) + 1) % 3)); });
        case GLFW_KEY_L: return session_.set_layer(next(Interactive::layers(), session_.layer()));
        case GLFW_KEY_T: session_.show.curve = static_cast<image::ToneCurve>((static_cast<uint32_t>(session_.show.curve) + 1) % 3); return;
        case GLFW_KEY_EQUAL:
        case GLFW_KEY_KP_ADD: session_.show.exposure_ev -= kExposure; return;
        case GLFW_KEY_MINUS:
        case GLFW_KEY_KP_SUBTRACT: session_.show.exposure_ev += kExposure; return;
        case GLFW_KEY_P: return save();
        case GLFW_KEY_SPACE: session_.play = session_.can_play() && !session_.play; return;
        case GLFW_KEY_F5: return session_.reload();
        default: return;
    }
}

void Controls::next_camera() {
    if (!session_.scene() || session_.scene()->cameras().empty()) return;
    camera_ = (camera_ + 1) % session_.scene()->cameras().size();
    session_.choose_camera(fmt::format("{}", camera_));
}

void Controls::save() {
    std::vector<std::filesystem::path> files = session_.options().output.files;
    if (files.empty()) {
        std::string name = std::filesystem::path(session_.options().scene).stem().string();
        if (const size_t colon = name.find(':'); colon != std::string::npos) name.erase(0, colon + 1);
        std::filesystem::path file;
        do file = fmt::format("{}-{}.png", name, ++saved_);
        while (std::filesystem::exists(file));
        files.push_back(file);
    }
    session_.save_picture(files);
}

void Controls::steer(const Panels::Input& input) {
    keys_ = input.keys;
    if (!session_.scene()) return;
    SteeredCamera camera = session_.camera();
    const bool shift = window_.is_down(GLFW_KEY_LEFT_SHIFT), control = window_.is_down(GLFW_KEY_LEFT_CONTROL);
    bool moved = false;
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
