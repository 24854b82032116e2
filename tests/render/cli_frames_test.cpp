// Sequences by the program as a process: names, numbers, interruption, and `compare` of two of them.
#include <csignal>
#include <filesystem>

#include <fmt/format.h>

#include <gtest/gtest.h>

#include "support/gpu_fixture.h"
#include "support/process.h"

namespace parhelion::testing::cli_frames_test {
namespace {

using Words = std::vector<std::string>;

class CliFrames : public GpuTest {
protected:
    TemporaryFolder folder;
    std::string file(const std::string& name) const { return folder.file(name); }
};

}  // namespace

TEST_F(CliFrames, two_sequences_are_compared_frame_by_frame) {
    const auto render = [&](const char* seed, const char* name) {
        return run_parhelion({"render", "builtin:cornell", "--size", "24x16", "--spp", "2", "--exposure", "3", "--animate", "lamp", "--frames", "2", "--fps", "1", "--seed", seed, "--out", file(name),
                              "--json", "-"});
    };
    const ProcessResult a = render("0", "a.#.exr");
    ASSERT_EQ(a.exit_code, 0) << a.err;
    EXPECT_EQ(a.json()["frames"], 2);
    EXPECT_EQ(a.json()["play"]["drawn"][1]["time"], 1.0);
    ASSERT_EQ(render("1", "b.#.exr").exit_code, 0);
    EXPECT_EQ(folder.names(), (Words{"a.0.exr", "a.1.exr", "b.0.exr", "b.1.exr"}));
    const ProcessResult compared = run_parhelion({"compare", file("a.#.exr"), file("b.#.exr")});
    EXPECT_EQ(compared.exit_code, 0) << compared.err;
    EXPECT_NE(compared.out.find("worst       frame 0"), std::string::npos) << "with the lamp off both are black\n" << compared.out;
}

TEST_F(CliFrames, an_interrupted_sequence_leaves_whole_frames_and_says_how_many) {
    const auto words = [&](const char* frames, const char* name) {  // a frame of several slices
        return Words{"render", "builtin:cornell", "--size", "24x16", "--spp", "512", "--max-bounces", "3", "--exposure", "3", "--animate", "spin", "--frames", frames, "--fps", "30", "--out", file(name), "--json", "-"};
    };
    ProcessOptions options{.signal = SIGINT};
    options.signal_when = [&](const ProcessResult&) { return std::filesystem::exists(file("a.0001.exr")); };
    const ProcessResult result = run_parhelion(words("10000", "a.####.exr"), options);
    EXPECT_EQ(result.exit_code, 130) << result.err;
    EXPECT_LT(result.seconds_after_signal, 5.0);
    const Words names = folder.names();
    ASSERT_GE(names.size(), 2u);
    for (size_t i = 0; i < names.size(); ++i) EXPECT_EQ(names[i], fmt::format("a.{:04}.exr", i));
    EXPECT_EQ(result.json()["frames"], names.size());
    EXPECT_NE(result.err.find("the same command with --resume keeps these frames and draws the others"), std::string::npos) << result.err;
    const size_t last = names.size() - 1;
    const std::string written = read_bytes(file(names.back()));
    std::filesystem::remove(file(names.back()));
    Words resume = words(std::to_string(names.size()).c_str(), "a.####.exr");
    resume.push_back("--resume");
    const ProcessResult resumed = run_parhelion(resume);
    ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
    EXPECT_EQ(resumed.json()["play"]["kept"].size(), last);
    EXPECT_NE(resumed.err.find(fmt::format("done: {} of {} frames kept, 1 drawn in ", last, names.size())), std::string::npos) << resumed.err;
    EXPECT_EQ(read_bytes(file(names.back())), written);
}

}  // namespace parhelion::testing::cli_frames_test
