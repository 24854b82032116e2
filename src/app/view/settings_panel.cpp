#include "app/view/settings_panel.h"

#include <algorithm>
#include <string>
#include <type_traits>
#include <vector>

#include <imgui.h>

namespace parhelion::view {

namespace {

std::string group_of(std::string_view key) { return std::string(key.substr(0, key.find('.'))); }

// Shows the fields of one group.
struct Widgets {
    std::string group;
    bool changed = false;

    template <class T, class Allowed>
    void field(std::string_view key, T& value, const Allowed& allowed, std::string_view help) {
        if (group_of(key) != group) return;
        const std::string label(key.substr(group.size() + 1));
        ImGui::PushItemWidth(150);
        changed |= edit(label, value, allowed);
        ImGui::PopItemWidth();
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", std::string(help).c_str());
    }

private:
    template <class T>
    static bool edit(const std::string& label, T& value, const SettingChoices& choices) {
        const auto now = static_cast<size_t>(value);
        if (!ImGui::BeginCombo(label.c_str(), std::string(choices.names.at(now)).c_str())) return false;
        bool edited = false;
        for (size_t i = 0; i < choices.names.size(); ++i)
            if (ImGui::Selectable(std::string(choices.names[i]).c_str(), i == now) && i != now) value = static_cast<T>(i), edited = true;
        ImGui::EndCombo();
        return edited;
    }
    // Numbers are taken over when the person is done with them: some change what takes long to make.
    template <class T>
    static bool edit(const std::string& label, T& value, const SettingRange& range) {
        static std::string edited_label;
        static double edited = 0;
        double shown = edited_label == label ? edited : static_cast<double>(value);
        if (ImGui::InputDouble(label.c_str(), &shown, 0.0, 0.0, std::is_integral_v<T> ? "%.0f" : "%.5g")) edited_label = label, edited = shown;
        if (edited_label != label || !ImGui::IsItemDeactivatedAfterEdit()) return false;
        edited_label.clear();
        const double lowest = range.min, highest = range.max;
        value = static_cast<T>(std::clamp(edited, lowest, highest));
        return true;
    }
};

}  // namespace

bool edit_settings(RenderSettings& settings) {
    std::vector<std::string> groups;
    for (const SettingRow& row : list_settings(settings))
        if (const std::string group = group_of(row.key); std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
    bool changed = false;
    for (const std::string& group : groups) {
        if (!ImGui::TreeNode(group.c_str())) continue;
        Widgets widgets{.group = group};
        visit(widgets, settings);
        changed |= widgets.changed;
        ImGui::TreePop();
    }
    return changed;
}

}  // namespace parhelion::view
