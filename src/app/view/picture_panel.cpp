#include "app/view/picture_panel.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <imgui.h>

#include "app/view/panels.h"
#include "app/view/settings_panel.h"
#include "base/error.h"
#include "scene/animation.h"
#include "session/setting_presets.h"

namespace parhelion::view {

namespace {

constexpr std::array<const char*, 3> kRenderers = {"reference", "wavefront", "realtime"};
constexpr std::array<const char*, 3> kDenoisers = {"none", "builtin", "oidn"};
constexpr std::array<const char*, 3> kCurves = {"linear", "aces", "agx"};

template <class T, size_t N>
bool choose(const char* label, const std::array<const char*, N>& names, T& value) {
    int index = static_cast<int>(value);
    if (!ImGui::Combo(label, &index, names.data(), static_cast<int>(N))) return false;
    value = static_cast<T>(index);
    return true;
}

void choose_layer(Interactive& session) {
    if (ImGui::BeginCombo("layer", session.layer().empty() ? "picture" : session.layer().c_str())) {
        for (const std::string& layer : session.layers())
            if (ImGui::Selectable(layer.empty() ? "picture" : layer.c_str(), layer == session.layer())) Panels::change(session, [&] { session.set_layer(layer); });
        ImGui::EndCombo();
    }
    if (ImGui::BeginCombo("image of a pass", session.shown_image.empty() ? "none" : session.shown_image.c_str())) {
        if (ImGui::Selectable("none", session.shown_image.empty())) session.shown_image.clear();
        for (const std::string& image : session.images())
            if (ImGui::Selectable(image.c_str(), image == session.shown_image)) session.shown_image = image;
        ImGui::EndCombo();
    }
    if (!session.shown_image.empty()) ImGui::SliderFloat("gain", &session.image_gain, 1e-4f, 1e4f, "%.4g", ImGuiSliderFlags_Logarithmic);
}

// Of the longest animation; scripted edits have no end.
double clock_length(const Scene& scene) {
    double length = 0;
    for (const auto& [handle, animation] : scene.animations()) length = std::max(length, double{duration_of(animation)});
    return length > 0 ? length : 10;
}

}  // namespace

void choose_device(const Interactive& session, std::string& wanted) {
    static const std::vector<gpu::DeviceCaps> devices = gpu::enumerate_devices();
    if (devices.size() < 2 || !ImGui::BeginCombo("device", "choose")) return;
    for (const gpu::DeviceCaps& caps : devices)
        if (ImGui::Selectable(fmt::format("{} {}", caps.index, escape_name(caps.name)).c_str(), caps.index == session.device()->caps().index)) wanted = fmt::format("{}", caps.index);
    ImGui::EndCombo();
}

void show_picture(Interactive& session) {
    RendererKind renderer = session.options().renderer;
    if (choose("renderer", kRenderers, renderer)) Panels::change(session, [&] { session.set_renderer(renderer); });
    DenoiseKind denoise = session.options().denoise;
    if (choose("reconstruction", kDenoisers, denoise)) Panels::change(session, [&] { session.set_denoise(denoise); });
    if (session.options().denoise == DenoiseKind::Builtin) {
        auto upscale = static_cast<float>(session.options().upscale);
        if (ImGui::SliderFloat("upscale", &upscale, 1.0f, static_cast<float>(kMostUpscale), "%.2f")) Panels::change(session, [&] { session.set_upscale(std::round(double{upscale} * 100) / 100); });
    }
    if (session.has_whole_frames()) ImGui::Checkbox("accumulate", &session.accumulate);
    int bounces = static_cast<int>(session.options().max_bounces);
    if (ImGui::SliderInt("bounces", &bounces, 0, 64, bounces == 0 ? "unlimited" : "%d")) session.set_max_bounces(static_cast<uint32_t>(std::clamp(bounces, 0, 65535)));
    auto exposure = static_cast<float>(session.show.exposure_ev);
    if (ImGui::SliderFloat("EV100", &exposure, -8.0f, 20.0f, "%.2f")) session.show.exposure_ev = std::round(double{exposure} * 100) / 100;
    ImGui::SameLine();
    if (ImGui::SmallButton("meter")) session.meter();
    choose("tone curve", kCurves, session.show.curve);
    choose_layer(session);
}

void show_camera(Interactive& session) {
    if (!session.scene()) return;
    if (ImGui::BeginCombo("camera", "choose")) {
        if (ImGui::Selectable("of the start")) session.choose_camera("");
        int index = 0;
        for (const auto& [handle, camera] : session.scene()->cameras()) {
            const std::string name = fmt::format("{} {}", index, escape_name(camera.name));
            if (ImGui::Selectable(name.c_str())) session.choose_camera(fmt::format("{}", index));
            ++index;
        }
        ImGui::EndCombo();
    }
    const CameraView& view = session.camera().view();
    float radius = view.lens_radius, focus = view.focus_distance;
    const float reach = 10 * session.camera().distance();
    const bool lens = ImGui::SliderFloat("lens radius, m", &radius, 0.0f, 0.05f * session.camera().distance(), "%.4g", ImGuiSliderFlags_Logarithmic);
    const bool sharp = radius > 0 && ImGui::SliderFloat("sharp at, m", &focus, 0.01f * reach, reach, "%.4g", ImGuiSliderFlags_Logarithmic);
    if (lens && view.lens_radius == 0) focus = session.camera().distance();
    if (lens || sharp) {
        SteeredCamera camera = session.camera();
        camera.set_lens(radius, focus);
        session.set_camera(camera);
    }
    if (!session.can_play()) return;
    ImGui::Checkbox("play", &session.play);
    ImGui::SameLine();
    auto time = static_cast<float>(session.seconds);
    const auto length = static_cast<float>(std::max(clock_length(*session.scene()), session.seconds));
    if (ImGui::SliderFloat("s", &time, 0.0f, length, "%.2f")) session.set_time(double{time});
}

void show_split(Interactive& session) {
    bool split = session.split.has_value();
    if (ImGui::Checkbox("the reference on the right", &split)) session.split = split ? std::optional(0.5f) : std::nullopt;
    if (!session.split) return;
    ImGui::SliderFloat("line", &*session.split, 0.0f, 1.0f, "%.3f");
    ImGui::Text("reference: %llu samples", static_cast<unsigned long long>(session.reference_samples()));
    if (const std::optional<Difference> found = session.difference()) {
        ImGui::Text("mean %+.2f %%, relMSE %.4g, FLIP %.4f", 100 * (found->mean_ratio - 1), found->relmse, found->flip);
        ImGui::Text("(%llu samples against %llu)", static_cast<unsigned long long>(found->samples), static_cast<unsigned long long>(found->reference_samples));
    }
}

bool show_settings(Interactive& session) {
    if (ImGui::BeginCombo("preset", "choose")) {
        for (const SettingPreset& preset : setting_presets()) {
            if (ImGui::Selectable(preset.name.data())) Panels::change(session, [&] { session.set_settings(settings_of(preset)); });
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", preset.what.data());
        }
        ImGui::EndCombo();
    }
    const bool file = ImGui::Button("write them as a preset");
    RenderSettings settings = session.settings();
    if (edit_settings(settings)) Panels::change(session, [&] { session.set_settings(settings); });
    return file;
}

}  // namespace parhelion::view
