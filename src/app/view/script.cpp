#include "app/view/script.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/error.h"
#include "base/parse.h"
#include "base/platform.h"
#include "session/results.h"
#include "session/setting_presets.h"

namespace parhelion::view {

namespace {

constexpr std::string_view kOption = "--script";
constexpr std::array kSteps = std::to_array<std::string_view>({"spp", "frames", "size", "renderer", "layer", "image", "camera", "orbit", "time", "play", "set", "preset", "denoise", "split", "drop",
                                                              "reload", "shaders", "device", "pick", "copy", "focus", "shot", "save", "report", "lose", "panels", "reference"});

// The place of a name in a list; a usage Error lists them.
size_t place_of(const std::string& name, std::initializer_list<const char*> names, const char* what) {
    std::string all;
    for (const char* const& known : names) {
        if (name == known) return static_cast<size_t>(&known - names.begin());
        all += (all.empty() ? "" : ", ") + std::string(known);
    }
    throw Error(ErrorCode::Usage, fmt::format("there is no {} '{}'", what, escape_name(name)), std::string(kOption), "use " + all);
}

RendererKind renderer_of(const std::string& name) { return static_cast<RendererKind>(place_of(name, {"reference", "wavefront", "realtime"}, "renderer")); }
DenoiseKind denoiser_of(const std::string& name) { return static_cast<DenoiseKind>(place_of(name, {"none", "builtin", "oidn"}, "reconstruction")); }

// X:Y, for commas part steps.
glm::uvec2 pixel_of(const std::string& text) {
    const size_t colon = text.find(':');
    if (colon == std::string::npos) throw Error(ErrorCode::Usage, fmt::format("'{}' is no pixel", escape_name(text)), std::string(kOption), "write X:Y");
    return {static_cast<uint32_t>(parse_int(text.substr(0, colon), kOption, 0, 1 << 20)), static_cast<uint32_t>(parse_int(text.substr(colon + 1), kOption, 0, 1 << 20))};
}

std::optional<float> line_of(const std::string& text) {
    if (text == "off") return std::nullopt;
    return static_cast<float>(parse_float(text, kOption, 0, 1));
}

void check_step(const std::string& name, const std::string& value) {
    if (name == "spp" || name == "frames" || name == "reference") parse_int(value, kOption, 1, 1 << 30);
    if (name == "size") parse_size(value, kOption);
    if (name == "renderer") renderer_of(value);
    if (name == "denoise") denoiser_of(value);
    if (name == "orbit") parse_float(value, kOption, -360, 360);
    if (name == "time") parse_float(value, kOption, 0, 1e6);
    if (name == "split") line_of(value);
    if (name == "pick" || name == "focus") pixel_of(value);
    if (name == "play" || name == "panels") place_of(value, {"off", "on"}, "choice");
    if ((name == "shot" || name == "drop" || name == "device") && value.empty()) throw Error(ErrorCode::Usage, fmt::format("{} needs a value", name), std::string(kOption));
}

RenderSettings preset_of(const std::string& name, const RenderSettings& now) {
    for (const SettingPreset& preset : setting_presets())
        if (preset.name == name) return settings_of(preset);
    return read_preset_settings(name, now);
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
        check_step(step.name, step.value);
        steps_.push_back(std::move(step));
        begin = end + 1;
    }
}

bool Script::run(const ScriptTargets& targets) {
    frame_seconds_.push_back(targets.session.frame_seconds());
    while (next_ < steps_.size()) {
        const Step& step = steps_[next_];
        if (!std::exchange(begun_, true)) {
            // Another session, on another device, goes on behind it.
            if (step.name == "lose") begun_ = false, ++next_;
            act(step, targets);
        }
        if (wait(step, targets)) {
            ++frames_;
            return true;
        }
        end(step, targets);
        ++next_;
        begun_ = false;
        frames_ = 0;
    }
    return false;
}

void Script::act(const Step& step, const ScriptTargets& on) {
    Interactive& session = on.session;
    const std::string& value = step.value;
    if (step.name == "size") on.window.resize(parse_size(value, kOption));
    if (step.name == "renderer") session.set_renderer(renderer_of(value));
    if (step.name == "denoise") session.set_denoise(denoiser_of(value));
    if (step.name == "layer") session.set_layer(value == "picture" ? "" : value);
    if (step.name == "image") session.shown_image = value == "none" ? "" : value;
    if (step.name == "camera") session.choose_camera(value == "start" ? "" : value);
    if (step.name == "time") session.set_time(parse_float(value, kOption));
    if (step.name == "play") session.play = value == "on";
    if (step.name == "panels") on.panels.shown = value == "on";
    if (step.name == "split") session.split = line_of(value);
    if (step.name == "pick") session.pick(pixel_of(value));
    if (step.name == "focus") on.controls.look_at(pixel_of(value));
    if (step.name == "drop") on.controls.open(value);
    if (step.name == "reload") session.reload();
    if (step.name == "shaders") on.controls.build_shaders();
    if (step.name == "device") on.panels.wanted_device = value;
    if (step.name == "lose") throw DeviceLost("the device was lost", session.device()->caps().name);
    if (step.name == "copy") on.controls.copy();
    if (step.name == "shot") on.controls.shoot(value);
    if (step.name == "save") on.controls.save();
    if (step.name == "report") report(*session.device());
    if (step.name == "preset") session.set_settings(preset_of(value, session.settings()));
    if (step.name == "set") {
        RenderSettings settings = session.settings();
        apply_assignment(settings, value);
        session.set_settings(settings);
    }
    if (step.name == "orbit") {
        SteeredCamera camera = session.camera();
        camera.orbit(static_cast<float>(parse_float(value, kOption) * std::numbers::pi / 180), 0);
        session.set_camera(camera);
    }
}

bool Script::wait(const Step& step, const ScriptTargets& on) {
    const Interactive& session = on.session;
    const std::string& name = step.name;
    if (name == "spp") return !session.is_finished() && session.samples() < static_cast<uint64_t>(parse_int(step.value, kOption));
    if (name == "reference" && (!session.split || !session.layer().empty()))
        throw Error(ErrorCode::Usage, "nothing is compared", std::string(kOption), "reference=N needs split=0..1, and no layer");
    if (name == "reference") return !session.is_finished() && (!session.difference() || session.difference()->reference_samples < static_cast<uint64_t>(parse_int(step.value, kOption)));
    if (name == "frames") return frames_ < static_cast<uint64_t>(parse_int(step.value, kOption));
    if (name == "reload" || name == "drop") return session.is_loading() || !session.scene_progress().complete;
    if (name == "shaders") return on.shaders.is_building() || frames_ < 2;
    if (name == "pick" || name == "focus") return session.is_picking() || frames_ < 2;
    if (name == "shot" || name == "device") return frames_ < 2;
    if (name == "save") return session.is_saving();
    if (name != "size") return false;
    const Size2 wanted = parse_size(step.value, kOption), now = session.options().size;
    return wanted.width != now.width || wanted.height != now.height;
}

// How frames came since the last report, and what memory is held.
void Script::report(const gpu::Device& device) {
    if (frame_seconds_.empty()) return;
    std::ranges::sort(frame_seconds_);
    const auto part = [&](double share) { return 1000 * frame_seconds_[static_cast<size_t>(share * static_cast<double>(frame_seconds_.size() - 1))]; };
    uint64_t on_device = 0;
    for (const gpu::MemoryUse& use : device.memory_use()) on_device += use.bytes;
    print_result(fmt::format("{} frames: {:.2f} ms, 95 % within {:.2f}, 99 % within {:.2f}, the longest {:.2f}; memory {} KiB, on the device {} KiB\n", frame_seconds_.size(), part(0.5), part(0.95),
                             part(0.99), part(1), platform::resident_bytes() / 1024, on_device / 1024));
    frame_seconds_.clear();
}

void Script::end(const Step& step, const ScriptTargets& on) {
    if (step.name == "pick" && on.session.picked()) print_result(on.session.picked()->text());
    if (const std::optional<Difference> found = on.session.difference(); step.name == "reference" && found)
        print_result(fmt::format("FLIP {:.5f}, mean {:.5f}, {} samples against {}\n", found->flip, found->mean_ratio, found->samples, found->reference_samples));
}

}  // namespace parhelion::view
