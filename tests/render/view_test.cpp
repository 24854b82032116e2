// The viewer as a process on a virtual display (Xvfb): what it saves is what `render` draws, whatever happened to its window before;
// it ends with the validation layers silent; without a display it says so.
#include <csignal>
#include <cstdlib>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "support/gpu_fixture.h"
#include "support/process.h"

namespace parhelion::testing::view_test {
namespace {

using Words = std::vector<std::string>;

// An X server without a screen, on a number of its own choice.
class VirtualDisplay {
public:
    VirtualDisplay() {
        int ends[2];
        if (pipe(ends) != 0) return;
        process_ = fork();
        if (process_ == 0) {
            const std::string number = std::to_string(ends[1]);
            const int nothing = open("/dev/null", O_RDWR);
            dup2(nothing, 1);
            dup2(nothing, 2);
            close(ends[0]);
            execlp("Xvfb", "Xvfb", "-displayfd", number.c_str(), "-screen", "0", "640x480x24", "-nolisten", "tcp", static_cast<char*>(nullptr));
            _exit(127);
        }
        close(ends[1]);
        // It writes its number once it takes clients; an end without one: it is not installed.
        char letter = 0;
        while (read(ends[0], &letter, 1) == 1 && letter != '\n') name_ += letter;
        close(ends[0]);
        if (!name_.empty()) name_.insert(0, ":");
    }
    ~VirtualDisplay() {
        if (process_ <= 0) return;
        kill(process_, SIGTERM);
        waitpid(process_, nullptr, 0);
    }
    VirtualDisplay(const VirtualDisplay&) = delete;
    VirtualDisplay& operator=(const VirtualDisplay&) = delete;
    const std::string& name() const { return name_; }  // empty: there is none

private:
    pid_t process_ = -1;
    std::string name_;
};

// One for all tests; it ends with the process.
const std::string& display() {
    static const VirtualDisplay shared;
    return shared.name();
}

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
        return run_parhelion(words, {.environment = {{"DISPLAY", display()}}, .folder = folder.path()});
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
    if (display().empty()) GTEST_SKIP() << "Xvfb is not installed";
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
    if (display().empty()) GTEST_SKIP() << "Xvfb is not installed";
    const ProcessResult result = view({"builtin:cornell", "--size", "48x36", "--spp", "66", "--exposure", "3", "--out", "saved.exr"},
                                      "frames=2,size=32x24,renderer=wavefront,spp=1,orbit=20,frames=3,renderer=realtime,frames=2,layer=albedo,frames=2,"
                                      "renderer=reference,camera=start,set=sampler.kind=pcg,layer=picture,reload,spp=3,save,spp=66,save");
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(saved(), rendered({"builtin:cornell", "--size", "32x24", "--spp", "66", "--exposure", "3", "--set", "sampler.kind=pcg"}));
}

TEST_F(Viewer, a_wrong_step_or_scene_is_one_line) {
    if (display().empty()) GTEST_SKIP() << "Xvfb is not installed";
    const ProcessResult step = view({"builtin:cornell"}, "spp=1,jump");
    EXPECT_EQ(step.exit_code, 2) << step.err;
    EXPECT_NE(step.err.find("there is no step 'jump'"), std::string::npos) << step.err;
    const ProcessResult scene = view({"missing.glb"}, "spp=1");
    EXPECT_EQ(scene.exit_code, 1) << scene.err;
    EXPECT_NE(scene.err.find("error: missing.glb"), std::string::npos) << scene.err;
}

}  // namespace
}  // namespace parhelion::testing::view_test
