// The viewer as a process on a virtual display (Xvfb): what it saves is what `render` draws, whatever happened to its window before;
// it ends with the validation layers silent; without a display it says so.
#include <cstdlib>
#include <sstream>

#include <gtest/gtest.h>

#include "base/file.h"
#include "image/decode.h"
#include "support/gpu_fixture.h"
#include "support/process.h"
#include "support/virtual_display.h"

namespace parhelion::testing::view_test {
namespace {

using Words = std::vector<std::string>;

class Viewer : public ::testing::Test {
protected:
    void SetUp() override {
        const bool built = std::filesystem::exists(std::string(PARHELION_BINARY_DIR) + "/parhelion-view");
        if (!built) GTEST_SKIP() << "parhelion-view is not built: libglfw3-dev or libimgui-dev is missing";
        if (!shared_device()) GTEST_SKIP() << "there is no Vulkan device";
    }
    void TearDown() override {
        EXPECT_FALSE(is_required("device") && IsSkipped());
    }
    ProcessResult view(Words words, const std::string& script) {
        words.insert(words.begin(), "view");
        words.insert(words.end(), {"--script", script});
        if (shared_device_validates()) words.emplace_back("--validate");
        return run_parhelion(words, {.environment = {{"DISPLAY", virtual_display()}}, .folder = folder.path()});
    }
    std::string rendered(Words words) {
        words.insert(words.begin(), "render");
        words.insert(words.end(), {"--out", "rendered.exr"});
        const ProcessResult result = run_parhelion(words, {.folder = folder.path()});
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return read_bytes(folder.path() / "rendered.exr");
    }
    std::string saved() const { return read_bytes(folder.path() / "saved.exr"); }

    TemporaryFolder folder;
};

TEST_F(Viewer, without_a_display_one_line_says_so_and_the_exit_code_is_3) {
    const ProcessResult result = run_parhelion({"view", "builtin:cornell"}, {.environment = {{"DISPLAY", ""}, {"WAYLAND_DISPLAY", ""}}});
    EXPECT_EQ(result.exit_code, 3) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_NE(result.err.find("no window can be opened"), std::string::npos) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
}

TEST_F(Viewer, saves_the_very_picture_that_render_draws) {
    if (virtual_display().empty()) GTEST_SKIP() << "Xvfb is not installed";
    const Words words{"builtin:cornell", "--size", "48x36", "--spp", "5"};
    Words shown = words;
    shown.insert(shown.end(), {"--out", "saved.exr", "--out", "saved.png"});
    const ProcessResult result = view(shown, "spp=5,save");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(saved(), rendered(words));
    EXPECT_GT(read_bytes(folder.path() / "saved.png").size(), 500u);
}

// Moves, other sizes, renderers, settings and layers leave nothing behind; nor does a save in the middle of a block of 64 samples.
TEST_F(Viewer, what_its_window_went_through_is_not_in_the_picture) {
    if (virtual_display().empty()) GTEST_SKIP() << "Xvfb is not installed";
    const ProcessResult result = view({"builtin:cornell", "--size", "48x36", "--spp", "66", "--exposure", "3", "--out", "saved.exr"},
                                      "frames=2,size=32x24,renderer=wavefront,spp=1,orbit=20,frames=3,renderer=realtime,frames=2,layer=albedo,frames=2,"
                                      "renderer=reference,camera=start,set=sampler.kind=pcg,layer=picture,reload,spp=3,save,spp=66,save");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(saved(), rendered({"builtin:cornell", "--size", "32x24", "--spp", "66", "--exposure", "3", "--set", "sampler.kind=pcg"}));
}

TEST_F(Viewer, a_wrong_step_or_scene_is_one_line) {
    if (virtual_display().empty()) GTEST_SKIP() << "Xvfb is not installed";
    const ProcessResult step = view({"builtin:cornell"}, "spp=1,jump");
    EXPECT_EQ(step.exit_code, 2) << step.err;
    EXPECT_NE(step.err.find("there is no step 'jump'"), std::string::npos) << step.err;
    const ProcessResult scene = view({"missing.glb"}, "spp=1");
    EXPECT_EQ(scene.exit_code, 1) << scene.err;
    EXPECT_NE(scene.err.find("error: missing.glb"), std::string::npos) << scene.err;
}

Words words_of(const std::string& line) {
    Words words;
    std::istringstream in(line);
    for (std::string word; in >> word;) words.push_back(word);
    if (!words.empty()) words.erase(words.begin());  // the program
    return words;
}

// What F2 copies draws the very picture that P writes: of a camera that was turned, by either path tracer, and by the realtime renderer from
// its beginning.
TEST_F(Viewer, the_line_that_it_copies_draws_the_same_picture) {
    if (virtual_display().empty()) GTEST_SKIP() << "Xvfb is not installed";
    const std::string steps[] = {"set=sampler.kind=pcg,orbit=25,spp=3,copy,save", "renderer=realtime,orbit=-15,spp=2,copy,spp=2,save"};
    for (const std::string& script : steps) {
        const ProcessResult result = view({"builtin:cornell", "--size", "32x24", "--spp", "64", "--trace", "compute", "--out", "saved.exr"}, script);
        ASSERT_EQ(result.exit_code, 0) << result.err;
        Words words = words_of(result.out);
        ASSERT_GT(words.size(), 8u) << result.out;
        words.insert(words.end(), {"--out", "rendered.exr"});
        const ProcessResult again = run_parhelion(words, {.folder = folder.path()});
        ASSERT_EQ(again.exit_code, 0) << again.err;
        EXPECT_EQ(saved(), read_bytes(folder.path() / "rendered.exr")) << result.out;
    }
}

// A person at work: nothing of it ends the window, and each thing that goes wrong is one line.
TEST_F(Viewer, it_survives_broken_files_broken_shaders_and_a_lost_device) {
    if (virtual_display().empty()) GTEST_SKIP() << "Xvfb is not installed";
    write_file(folder.path() / "broken.glb", std::as_bytes(std::span(std::string_view("no scene"))));
    write_file(folder.path() / "preset.json", std::as_bytes(std::span(std::string_view(R"({"schema": 1, "set": {"sampler.kind": "pcg"}})"))));
    const std::filesystem::path pack = std::filesystem::path(PARHELION_BINARY_DIR) / "shaders/shaders/shaders.pack";
    ASSERT_TRUE(std::filesystem::exists(pack)) << pack;
    std::filesystem::copy_file(pack, folder.path() / "shaders.pack");
    // The first build fails, the second leaves half a pack, the third the right one.
    const char* build = "n=$(cat n 2>/dev/null || echo 0); echo $((n + 1)) > n; case $n in 0) echo a.comp:3: error: no such thing; exit 1 ;; "
                        "1) head -c 1000 shaders.pack > half; cp shaders.pack whole; mv half shaders.pack ;; *) mv whole shaders.pack; touch shaders.pack ;; esac";
    Words words{"view", "builtin:cornell", "--size", "160x120", "--spp", "4", "--exposure", "-1", "--trace", "compute", "--out", "saved.exr", "--script",
                "frames=12,drop=broken.glb,drop=preset.json,shaders,shaders,shaders,renderer=realtime,frames=2,split=0.5,reference=1,pick=80:60,"
                "image=gbuffer/identity,frames=2,image=none,shot=window.png,focus=20:20,frames=2,lose,frames=12,shot=after.png,split=off,renderer=reference,camera=start,"
                "size=48x36,spp=4,save"};
    if (shared_device_validates()) words.emplace_back("--validate");
    const ProcessResult result = run_parhelion(words, {.environment = {{"DISPLAY", virtual_display()}, {"PARHELION_SHADER_DIR", "."}, {"PARHELION_SHADER_BUILD", build}}, .folder = folder.path()});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    for (const char* line : {"broken.glb", "a.comp:3: error: no such thing", "this is not a shader pack", "the device was lost"}) EXPECT_NE(result.err.find(line), std::string::npos) << line << "\n" << result.err;
    EXPECT_NE(result.out.find("pixel 80, 60"), std::string::npos) << result.out;
    EXPECT_NE(result.out.find("FLIP"), std::string::npos) << result.out;
    for (const char* shot : {"window.png", "after.png"}) {
        const std::string png = read_bytes(folder.path() / shot);
        EXPECT_EQ(image::decode_png(std::as_bytes(std::span(png))).width, 160u) << shot;
    }
    EXPECT_EQ(saved(), rendered({"builtin:cornell", "--size", "48x36", "--spp", "4", "--exposure", "-1", "--trace", "compute", "--set", "sampler.kind=pcg"}));
}

}  // namespace
}  // namespace parhelion::testing::view_test
