// Sets of settings with a name, and their files.
#include "session/setting_presets.h"

#include <gtest/gtest.h>

#include "base/file.h"
#include "support/process.h"

namespace parhelion::testing::setting_presets_test {
namespace {

bool same(const RenderSettings& a, const RenderSettings& b) {
    const std::vector<SettingRow> x = list_settings(a), y = list_settings(b);
    return std::ranges::equal(x, y, {}, &SettingRow::value, &SettingRow::value);
}

TEST(SettingPresets, each_says_what_differs_from_the_standard) {
    EXPECT_TRUE(same(settings_of(setting_presets().front()), RenderSettings{}));
    for (const SettingPreset& preset : setting_presets().subspan(1)) EXPECT_FALSE(same(settings_of(preset), RenderSettings{})) << preset.name;
}

TEST(SettingPresets, files_give_back_what_was_written_and_keep_what_they_do_not_say) {
    TemporaryFolder folder;
    for (const SettingPreset& preset : setting_presets()) {
        const std::filesystem::path file = folder.path() / "preset.json";
        write_preset_settings(file, settings_of(preset));
        EXPECT_TRUE(same(read_preset_settings(file, {}), settings_of(preset))) << preset.name;
    }
    RenderSettings settings;
    settings.realtime_candidates = 3;
    const std::filesystem::path some = folder.path() / "some.json";
    write_text_file(some, R"({"schema": 1, "spp": 7, "set": {"sampler.kind": "pcg"}})");
    const RenderSettings read = read_preset_settings(some, settings);
    EXPECT_EQ(read.realtime_candidates, 3u);
    EXPECT_EQ(read.sampler, SamplerKind::Pcg);
    write_text_file(some, R"({"schema": 1, "set": {"sampler.kind": "dice"}})");
    EXPECT_THROW(read_preset_settings(some, settings), Error);
    EXPECT_THROW(read_preset_settings(folder.path() / "missing.json", settings), Error);
}

}  // namespace
}  // namespace parhelion::testing::setting_presets_test
