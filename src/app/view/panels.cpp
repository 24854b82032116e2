#include "app/view/panels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <imgui.h>
#include <backends/imgui_impl_glfw.h>

#include "app/view/settings_panel.h"
#include "base/error.h"
#include "base/log.h"
#include "passes/ui/panels.h"

namespace parhelion::view {

namespace {

constexpr std::array<const char*, 3> kRenderers = {"reference", "wavefront", "realtime"};
constexpr std::array<const char*, 3> kCurves = {"linear", "aces", "agx"};
constexpr float kWidth = 330.0f;

constexpr std::array<std::array<const char*, 2>, 15> kKeys = {{
    {"left mouse", "turn about what is in the middle"},
    {"right mouse", "look around"},
    {"middle mouse", "move across the picture"},
    {"wheel", "nearer, farther (with Ctrl: field of view)"},
    {"W A S D Q E", "fly (Shift: fast, Ctrl: slow)"},
    {"Home", "back to the camera of the start"},
    {"C", "next camera of the scene"},
    {"R", "next renderer"},
    {"L", "next layer"},
    {"T", "next tone curve"},
    {"+ -", "brighter, darker"},
    {"P", "write the picture"},
    {"Space", "play and stop animations"},
    {"F5", "load the scene again"},
    {"F1, Tab, Esc", "this list, panels on and off, close"},
}};

// What an ImGui list holds, in one mesh.
passes::PanelMesh mesh_of(const ImDrawData& data) {
    passes::PanelMesh mesh;
    const ImVec2 origin = data.DisplayPos, scale = data.FramebufferScale;
    const auto pixel = [](float x) { return static_cast<uint32_t>(std::max(0.0f, x)); };
    for (int n = 0; n < data.CmdListsCount; ++n) {
        const ImDrawList& list = *data.CmdLists[n];
        const auto base = static_cast<uint32_t>(mesh.vertices.size());
        for (const ImDrawVert& v : list.VtxBuffer)
            mesh.vertices.push_back({(v.pos.x - origin.x) * scale.x, (v.pos.y - origin.y) * scale.y, v.uv.x, v.uv.y, v.col});
        for (const ImDrawCmd& command : list.CmdBuffer) {
            passes::PanelDraw draw{.first_index = static_cast<uint32_t>(mesh.indices.size()), .index_count = command.ElemCount};
            draw.clip = {.x = pixel((command.ClipRect.x - origin.x) * scale.x), .y = pixel((command.ClipRect.y - origin.y) * scale.y)};
            draw.clip.width = pixel((command.ClipRect.z - origin.x) * scale.x) - std::min(draw.clip.x, pixel((command.ClipRect.z - origin.x) * scale.x));
            draw.clip.height = pixel((command.ClipRect.w - origin.y) * scale.y) - std::min(draw.clip.y, pixel((command.ClipRect.w - origin.y) * scale.y));
            for (unsigned i = 0; i < command.ElemCount; ++i) mesh.indices.push_back(base + command.VtxOffset + list.IdxBuffer[static_cast<int>(command.IdxOffset + i)]);
            mesh.draws.push_back(draw);
        }
    }
    return mesh;
}

}  // namespace

Panels::Panels(const Window& window, const gpu::DevicePtr& device) : device_(device) {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind
    ImGui::GetIO().BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
    ImGui::StyleColorsDark();
    ImGui::GetStyle().Colors[ImGuiCol_WindowBg].w = 0.8f;
    ImGui_ImplGlfw_InitForVulkan(window.handle(), true);
    ImGui::GetIO().Fonts->Build();
}

Panels::~Panels() {
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
}

// What was wrong with a change is the session's note.
void Panels::change(Interactive& session, const std::function<void()>& what) {
    try {
        what();
    } catch (const Error& error) {
        if (error.code == ErrorCode::Failed) throw;
        session.set_note(error.line);
        log_line(LogLevel::Warn, error.line);
    }
}

Panels::Input Panels::begin(Interactive& session, gpu::Swapchain& swapchain) {
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    const double now = session.frame_seconds();
    frame_seconds_ += (frame_seconds_ == 0 ? 1.0 : 0.1) * (now - frame_seconds_);
    if (shown) {
        ImGui::SetNextWindowPos({8, 8}, ImGuiCond_FirstUseEver);
        ImGui::SetNextWindowSize({kWidth, 0});  // as high as what it holds
        ImGui::SetNextWindowSizeConstraints({200, 0}, {1000, std::max(100.0f, ImGui::GetIO().DisplaySize.y - 16)});
        if (ImGui::Begin("Parhelion")) {
            show_state(session, swapchain);
            show_picture(session);
            if (ImGui::CollapsingHeader("Settings")) {
                RenderSettings settings = session.settings();
                if (edit_settings(settings)) change(session, [&] { session.set_settings(settings); });
            }
            if (ImGui::CollapsingHeader("Passes")) show_times(session);
        }
        ImGui::End();
        if (help) show_help();
    }
    const ImGuiIO& io = ImGui::GetIO();
    Input input{.keys = !io.WantCaptureKeyboard, .seconds = io.DeltaTime};
    if (!io.WantCaptureMouse)
        input = {io.MouseDelta.x, io.MouseDelta.y, io.MouseWheel, io.MouseDown[0], io.MouseDown[1], io.MouseDown[2], input.keys, io.DeltaTime};
    ImGui::Render();
    return input;
}

void Panels::show_state(Interactive& session, gpu::Swapchain& swapchain) {
    const RenderOptions& options = session.options();
    ImGui::TextWrapped("%s, by %s", escape_name(session.device()->caps().name).c_str(), std::string(gpu::trace_way_name(session.way())).c_str());
    ImGui::Text("%ux%u, %.1f ms, %.1f frames/s", options.size.width, options.size.height, 1000 * frame_seconds_, 1 / std::max(frame_seconds_, 1e-6));
    const SceneProgress& progress = session.scene_progress();
    if (session.is_loading()) ImGui::TextUnformatted("reading the scene");
    else if (!progress.complete) ImGui::ProgressBar(static_cast<float>(progress.done / progress.total), {-1, 0}, "to the device");
    else ImGui::Text("%llu samples%s", static_cast<unsigned long long>(session.samples()), session.is_finished() ? ", finished" : "");
    if (!session.note().empty()) ImGui::TextWrapped("%s", session.note().c_str());
    if (ImGui::Button("F1 keys")) help = !help;
    ImGui::SameLine();
    bool fifo = swapchain.mode() == gpu::PresentMode::Fifo;
    if (ImGui::Checkbox("wait for the display", &fifo)) swapchain.set_mode(fifo ? gpu::PresentMode::Fifo : gpu::PresentMode::Mailbox);
}

void Panels::show_picture(Interactive& session) {
    int renderer = static_cast<int>(session.options().renderer);
    if (ImGui::Combo("renderer", &renderer, kRenderers.data(), static_cast<int>(kRenderers.size())))
        change(session, [&] { session.set_renderer(static_cast<RendererKind>(renderer)); });
    if (session.has_whole_frames()) ImGui::Checkbox("accumulate", &session.accumulate);
    if (session.options().renderer == RendererKind::Realtime && session.options().denoise == DenoiseKind::Builtin) {
        auto upscale = static_cast<float>(session.options().upscale);
        if (ImGui::SliderFloat("upscale", &upscale, 1.0f, static_cast<float>(kMostUpscale), "%.2f")) change(session, [&] { session.set_upscale(std::round(double{upscale} * 100) / 100); });
    }
    int bounces = static_cast<int>(session.options().max_bounces);
    if (ImGui::SliderInt("bounces", &bounces, 0, 64, bounces == 0 ? "unlimited" : "%d")) session.set_max_bounces(static_cast<uint32_t>(std::clamp(bounces, 0, 65535)));
    auto exposure = static_cast<float>(session.show.exposure_ev);
    if (ImGui::SliderFloat("EV100", &exposure, -8.0f, 20.0f, "%.2f")) session.show.exposure_ev = std::round(double{exposure} * 100) / 100;
    ImGui::SameLine();
    if (ImGui::SmallButton("meter")) session.meter();
    int curve = static_cast<int>(session.show.curve);
    if (ImGui::Combo("tone curve", &curve, kCurves.data(), static_cast<int>(kCurves.size()))) session.show.curve = static_cast<image::ToneCurve>(curve);
    if (ImGui::BeginCombo("layer", session.layer().empty() ? "picture" : session.layer().c_str())) {
        for (const std::string& layer : Interactive::layers())
            if (ImGui::Selectable(layer.empty() ? "picture" : layer.c_str(), layer == session.layer())) session.set_layer(layer);
        ImGui::EndCombo();
    }
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
    if (session.can_play()) ImGui::Checkbox(fmt::format("play ({:.2f} s)", session.seconds).c_str(), &session.play);
}

void Panels::show_times(const Interactive& session) {
    constexpr double kNew = 0.1;  // weight of the newest frame
    for (PassTime& time : times_) time.ms *= 1 - kNew;
    for (const PassTime& pass : session.passes()) {
        auto found = std::find_if(times_.begin(), times_.end(), [&](const PassTime& time) { return time.name == pass.name; });
        if (found == times_.end()) found = times_.insert(times_.end(), PassTime{pass.name, pass.ms * (1 - kNew)});
        found->ms += pass.ms * kNew;
        found->count = pass.count;
    }
    std::erase_if(times_, [](const PassTime& time) { return time.ms < 1e-4; });
    if (!ImGui::BeginTable("times", 3)) return;
    for (const PassTime& time : times_) {
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(time.name.c_str());
        ImGui::TableNextColumn();
        ImGui::Text("%llu", static_cast<unsigned long long>(time.count));
        ImGui::TableNextColumn();
        ImGui::Text("%.3f ms", time.ms);
    }
    ImGui::EndTable();
}

void Panels::show_help() {
    ImGui::SetNextWindowPos({kWidth + 24, 8}, ImGuiCond_FirstUseEver);
    if (ImGui::Begin("Keys", &help, ImGuiWindowFlags_AlwaysAutoResize)) {
        for (const auto& [key, meaning] : kKeys) {
            ImGui::TextUnformatted(key);
            ImGui::SameLine(120);
            ImGui::TextUnformatted(meaning);
        }
    }
    ImGui::End();
}

void Panels::draw(Frame& frame, const gpu::Image& canvas) {
    if (!font_) {
        unsigned char* texels = nullptr;
        int width = 0, height = 0;
        ImGui::GetIO().Fonts->GetTexDataAsAlpha8(&texels, &width, &height);
        font_ = gpu::Image(device_, "ui/font", {.format = gpu::Format::R8Unorm, .extent = {static_cast<uint32_t>(width), static_cast<uint32_t>(height), 1}});
        frame.upload_image(font_, std::as_bytes(std::span(texels, static_cast<size_t>(width) * static_cast<size_t>(height))));
    }
    passes::panels(frame, canvas, font_, mesh_of(*ImGui::GetDrawData()));
}

}  // namespace parhelion::view
