#pragma once
// Sets of settings with a name, and their files: what --preset reads.
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "session/render_settings.h"

namespace parhelion {

struct SettingPreset {
    std::string_view name, what;
    std::vector<std::string_view> assignments;  // group.field=value; all others are the standard
};
std::span<const SettingPreset> setting_presets();  // the standard first
RenderSettings settings_of(const SettingPreset& preset);

// The settings ("set") of a preset's file over those given; its other keys are options, which are for the command line. Throws Error naming
// the file and what is wrong.
RenderSettings read_preset_settings(const std::filesystem::path& file, const RenderSettings& settings);
// All that is not standard, as a file that --preset and read_preset_settings read.
void write_preset_settings(const std::filesystem::path& file, const RenderSettings& settings);

}  // namespace parhelion
