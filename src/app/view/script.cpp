#include "app/view/script.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/parse.h"

namespace parhelion::view {

namespace {

constexpr std::string_view kOption = "--script";
constexpr std::array<std::string_view, 10> kSteps = {"spp", "frames", "size", "renderer", "layer", "camera", "orbit", "set", "reload", "save"};

RendererKind renderer_of(const std::string& name) {
    if (name == "reference") return RendererKind::Reference;
    if (name == "wavefront") return RendererKind::Wavefront;
    if (name == "realtime") return RendererKind::Realtime;
    throw Error(ErrorCode::Usage, fmt::format("there is no renderer '{}'", escape_name(name)), std::string(kOption), "use reference, wavefront or realtime");
}

}  // namespace

Script::Script(const std::string& text) {
    for (size_t begin = 0; begin <= text.size();) {
        const size_t end = std::min(text.find(',', begin), text.size());
        const std::string word = text.substr(begin, end - begin);
        const size_t equals = std::min(word.find('='), word.size());
        Step step{word.substr(0, equals), word.substr(std::min(equals + 1, word.size()))};
        if (std::find(kSteps.begin(), kSteps.end(), step.name) == kSteps.end())
            throw Error(ErrorCode::Usage, fmt::format("there is no step '{}'", escape_name(step.name)), std::string(kOption), "parhelion help view lists them");
        if (step.name == "spp" || step.name == "frames") parse_int(step.value, kOption, 1, 1 << 30);
        if (step.name == "size") parse_size(step.value, kOption);
        if (step.name == "renderer") renderer_of(step.value);
        if (step.name == "orbit") parse_float(step.value, kOption, -360, 360);
        steps_.push_back(std::move(step));
        begin = end + 1;
    }
}

bool Script::run(Window& window, Interactive& session, Controls& controls) {
    for (; next_ < steps_.size(); ++next_, begun_ = false, frames_ = 0) {
        const Step& step = steps_[next_];
        if (!begun_) act(step, window, session, controls);
        begun_ = true;
        if (wait(step, session)) {
            ++frames_;
            return true;
        }
    }
    return false;
}

void Script::act(const Step& step, Window& window, Interactive& session, Controls& controls) {
    if (step.name == "size") window.resize(parse_size(step.value, kOption));
    if (step.name == "renderer") session.set_renderer(renderer_of(step.value));
    if (step.name == "layer") session.set_layer(step.value == "picture" ? "" : step.value);
    if (step.name == "camera") session.choose_camera(step.value == "start" ? "" : step.value);
    if (step.name == "reload") session.reload();
    if (step.name == "save") controls.save();
    if (step.name == "set") {
        RenderSettings settings = session.settings();
        apply_assignment(settings, step.value);
        session.set_settings(settings);
    }
    if (step.name == "orbit") {
        SteeredCamera camera = session.camera();
        camera.orbit(static_cast<float>(parse_float(step.value, kOption) * std::numbers::pi / 180), 0);
        session.set_camera(camera);
    }
}

bool Script::wait(const Step& step, const Interactive& session) {
    if (step.name == "spp") return session.samples() < static_cast<uint64_t>(parse_int(step.value, kOption));
    if (step.name == "frames") return frames_ < static_cast<uint64_t>(parse_int(step.value, kOption));
    if (step.name == "reload") return session.is_loading() || !session.scene_progress().complete;
    if (step.name == "save") return session.is_saving();
    if (step.name != "size") return false;
    const Size2 wanted = parse_size(step.value, kOption), now = session.options().size;
    return wanted.width != now.width || wanted.height != now.height;
}

}  // namespace parhelion::view
