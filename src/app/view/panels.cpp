#include "app/view/panels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <imgui.h>
#include <backends/imgui_impl_glfw.h>

#include "app/view/picture_panel.h"
#include "app/view/pixel_panel.h"
#include "app/view/settings_panel.h"
#include "base/error.h"
#include "base/log.h"
#include "passes/ui/panels.h"

namespace parhelion::view {

namespace {

constexpr float kWidth = 340.0f;

constexpr std::array<std::array<const char*, 2>, 24> kKeys = {{
    {"left mouse", "turn about what is in the middle"},
    {"double click, F", "look at what is there, and focus on it"},
    {"Ctrl + click, X", "look into the pixel"},
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
    {"F12", "write the window as it is, panels and all"},
    {"F2", "copy the command line that draws this picture"},
    {"V", "the reference beside the picture"},
    {"[ ]", "move the line between them"},
    {"Space", "play and stop animations"},
    {"F5", "load the scene again"},
    {"F6", "build the shaders again"},
    {"drop a file", "open that scene, environment or preset"},
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

Panels::Panels(const Window& window, const gpu::DevicePtr& device) : device_(device), scale_(window.panel_scale()) {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;  // leaves no file behind
    ImGui::GetIO().BackendFlags |= ImGuiBackendFlags_RendererHasVtxOffset;
    ImGui::StyleColorsDark();
    ImGui::GetStyle().Colors[ImGuiCol_WindowBg].w = 0.8f;
    ImGui::GetStyle().ScaleAllSizes(scale_);
    ImGui::GetIO().FontGlobalScale = scale_;
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
        if (dynamic_cast<const DeviceLost*>(&error)) throw;
        session.set_note(error.line);
        log_line(LogLevel::Warn, error.line);
    }
}

Panels::Input Panels::begin(Interactive& session, gpu::Swapchain& swapchain) {
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    const double now = session.frame_seconds();
    times_.note(now);
    frame_seconds_ += (frame_seconds_ == 0 ? 1.0 : 0.1) * (now - frame_seconds_);
    if (shown) {
        ImGui::SetNextWindowPos({8, 8}, ImGuiCond_FirstUseEver);
        ImGui::SetNextWindowSize({kWidth * scale_, 0});  // as high as what it holds
        ImGui::SetNextWindowSizeConstraints({200, 0}, {1000, std::max(100.0f, ImGui::GetIO().DisplaySize.y - 16)});
        if (ImGui::Begin("Parhelion")) {
            show_state(session, swapchain);
            if (ImGui::CollapsingHeader("Picture", ImGuiTreeNodeFlags_DefaultOpen)) show_picture(session);
            if (ImGui::CollapsingHeader("Camera and time")) show_camera(session);
            if (ImGui::CollapsingHeader("Beside the reference")) show_split(session);
            if (ImGui::CollapsingHeader("Settings")) wants_preset_file |= show_settings(session);
            if (ImGui::CollapsingHeader("Passes")) times_.show(session);
        }
        ImGui::End();
        if (help) show_help();
        show_pixel(session, kWidth * scale_ + 24);
    }
    const ImGuiIO& io = ImGui::GetIO();
    Input input{.keys = !io.WantCaptureKeyboard, .seconds = io.DeltaTime};
    if (!io.WantCaptureMouse)
        input = {io.MouseDelta.x, io.MouseDelta.y, io.MouseWheel, io.MouseDown[0], io.MouseDown[1], io.MouseDown[2], input.keys, io.DeltaTime,
                 ImGui::IsMouseClicked(0), ImGui::IsMouseDoubleClicked(0)};
    ImGui::Render();
    return input;
}

void Panels::show_state(Interactive& session, gpu::Swapchain& swapchain) {
    const RenderOptions& options = session.options();
    ImGui::TextWrapped("%s, by %s", escape_name(session.device()->caps().name).c_str(), std::string(gpu::trace_way_name(session.way())).c_str());
    choose_device(session, wanted_device);
    ImGui::Text("%ux%u%s, %.1f ms, %.1f frames/s", options.size.width, options.size.height, session.shrink() == 1 ? "" : fmt::format(" / {}", session.shrink()).c_str(), 1000 * frame_seconds_,
                1 / std::max(frame_seconds_, 1e-6));
    const SceneProgress& progress = session.scene_progress();
    if (session.is_loading()) ImGui::TextUnformatted("reading the scene");
    else if (!progress.complete) ImGui::ProgressBar(static_cast<float>(progress.done / progress.total), {-1, 0}, "to the device");
    else ImGui::Text("%llu samples%s", static_cast<unsigned long long>(session.samples()), session.is_finished() ? ", finished" : "");
    if (!session.note().empty()) ImGui::TextWrapped("%s", session.note().c_str());
    if (ImGui::Button("F1 keys")) help = !help;
    ImGui::SameLine();
    wants_copy |= ImGui::Button("F2 copy as command line");
    bool fifo = swapchain.mode() == gpu::PresentMode::Fifo;
    if (ImGui::Checkbox("wait for the display", &fifo)) swapchain.set_mode(fifo ? gpu::PresentMode::Fifo : gpu::PresentMode::Mailbox);
}

void Panels::show_help() {
    ImGui::SetNextWindowPos({kWidth * scale_ + 24, 8}, ImGuiCond_FirstUseEver);
    if (ImGui::Begin("Keys", &help, ImGuiWindowFlags_AlwaysAutoResize)) {
        for (const auto& [key, meaning] : kKeys) {
            ImGui::TextUnformatted(key);
            ImGui::SameLine(130 * scale_);
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
