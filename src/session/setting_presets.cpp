#include "session/setting_presets.h"

#include <nlohmann/json.hpp>

#include "base/file.h"
#include "session/options.h"

namespace parhelion {

namespace {

constexpr uint64_t kMostPresetBytes = 1u << 20;

}  // namespace

std::span<const SettingPreset> setting_presets() {
    static const std::vector<SettingPreset> presets = {
        {"standard", "all settings as they are without --set", {}},
        {"fast", "fewer candidates and bounces, shorter filters", {"realtime.candidates=4", "realtime.path_bounces=2", "reconstruction.steps=3"}},
        {"reservoirs", "samples shared between pixels and frames", {"realtime.reuse=full"}},
        {"unbiased", "realtime frames whose mean is the reference's", {"realtime.cache=off", "realtime.reuse=unbiased"}},
    };
    return presets;
}

RenderSettings settings_of(const SettingPreset& preset) {
    RenderSettings settings;
    for (const std::string_view assignment : preset.assignments) apply_assignment(settings, assignment);
    return settings;
}

RenderSettings read_preset_settings(const std::filesystem::path& file, const RenderSettings& settings) {
    RenderSettings out = settings;
    for (const OptionValues::Given& given : parse_preset(read_text_file(file, kMostPresetBytes), file.string()))
        if (given.name == "--set") apply_assignment(out, given.value);
    return out;
}

void write_preset_settings(const std::filesystem::path& file, const RenderSettings& settings) {
    nlohmann::ordered_json json = {{"schema", 1}, {"set", nlohmann::ordered_json::object()}};
    const std::vector<SettingRow> standard = list_settings(RenderSettings{}), now = list_settings(settings);
    for (size_t i = 0; i < now.size(); ++i)
        if (now[i].value != standard[i].value) json["set"][now[i].key] = now[i].value;
    write_text_file(file, json.dump(2) + "\n");
}

}  // namespace parhelion
