#include "app/view/pixel_panel.h"

#include <imgui.h>

namespace parhelion::view {

namespace {

constexpr ImU32 kPathColour = IM_COL32(255, 200, 40, 255), kPixelColour = IM_COL32(60, 220, 255, 255);

void draw_path(const Interactive& session, const PixelReport& report) {
    const ImVec2 size = ImGui::GetIO().DisplaySize;
    const auto place = [&](const glm::vec2& p) { return ImVec2(0.5f * (p.x + 1) * size.x, 0.5f * (1 - p.y) * size.y); };
    ImDrawList& over = *ImGui::GetBackgroundDrawList();
    std::optional<ImVec2> before;
    // The first vertex is the camera itself.
    for (size_t i = 1; i < report.path_ws.size(); ++i) {
        const auto seen = session.camera().project(report.path_ws[i], size.x / size.y);
        const std::optional<ImVec2> now = seen ? std::optional(place(*seen)) : std::nullopt;
        if (now && before) over.AddLine(*before, *now, kPathColour, 1.5f);
        if (now && i + 1 < report.path_ws.size()) over.AddCircleFilled(*now, 3.0f, kPathColour);
        before = now;
    }
    if (!report.meets_surface) return;
    if (const auto seen = session.camera().project(report.position_ws, size.x / size.y)) over.AddCircle(place(*seen), 6.0f, kPixelColour, 0, 2.0f);
}

}  // namespace

void show_pixel(Interactive& session, float left) {
    if (!session.picked()) return;
    const PixelReport& report = *session.picked();
    draw_path(session, report);
    bool open = true;
    ImGui::SetNextWindowPos({left, 8}, ImGuiCond_FirstUseEver);
    ImGui::SetNextWindowSizeConstraints({200, 0}, {1000, ImGui::GetIO().DisplaySize.y - 16});
    if (ImGui::Begin(fmt::format("Pixel {}, {}###pixel", report.pixel.x, report.pixel.y).c_str(), &open, ImGuiWindowFlags_AlwaysAutoResize)) {
        for (const PixelReport::Section& section : report.sections) {
            if (!ImGui::CollapsingHeader(section.title.c_str(), ImGuiTreeNodeFlags_DefaultOpen) || !ImGui::BeginTable(section.title.c_str(), 2)) continue;
            for (const auto& [what, value] : section.rows) {
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(what.c_str());
                ImGui::TableNextColumn();
                ImGui::TextUnformatted(value.c_str());
            }
            ImGui::EndTable();
        }
    }
    ImGui::End();
    if (!open) session.forget_pick();
}

}  // namespace parhelion::view
