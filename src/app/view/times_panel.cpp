#include "app/view/times_panel.h"

#include <algorithm>

#include <imgui.h>

namespace parhelion::view {

namespace {

constexpr size_t kFrames = 240;
constexpr double kNew = 0.1;  // weight of the newest frame

}  // namespace

void TimesPanel::note(double frame_seconds) {
    frames_ms_.push_back(static_cast<float>(1000 * frame_seconds));
    if (frames_ms_.size() > kFrames) frames_ms_.erase(frames_ms_.begin());
}

void TimesPanel::show(const Interactive& session) {
    for (PassTime& time : times_) time.ms *= 1 - kNew;
    for (const PassTime& pass : session.passes()) {
        auto found = std::find_if(times_.begin(), times_.end(), [&](const PassTime& time) { return time.name == pass.name; });
        if (found == times_.end()) found = times_.insert(times_.end(), PassTime{pass.name, pass.ms * (1 - kNew)});
        found->ms += pass.ms * kNew;
        found->count = pass.count;
    }
    std::erase_if(times_, [](const PassTime& time) { return time.ms < 1e-4; });
    if (!frames_ms_.empty()) {
        const float most = *std::max_element(frames_ms_.begin(), frames_ms_.end());
        ImGui::PlotLines("##frames", frames_ms_.data(), static_cast<int>(frames_ms_.size()), 0, fmt::format("frames, up to {:.1f} ms", most).c_str(), 0.0f, most, {-1, 60});
    }
    double longest = 0;
    for (const PassTime& time : times_) longest = std::max(longest, time.ms);
    if (!ImGui::BeginTable("times", 2)) return;
    for (const PassTime& time : times_) {
        ImGui::TableNextColumn();
        ImGui::Text("%s%s", time.name.c_str(), time.count == 1 ? "" : fmt::format(" x {}", time.count).c_str());
        ImGui::TableNextColumn();
        ImGui::ProgressBar(static_cast<float>(time.ms / longest), {-1, 0}, fmt::format("{:.3f} ms", time.ms).c_str());
    }
    ImGui::EndTable();
}

}  // namespace parhelion::view
