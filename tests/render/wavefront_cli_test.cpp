// The wavefront as a process: files are the same whatever the number of threads, the parts and the interruptions, and they are those
// of the reference where devices round alike.
#include <csignal>

#include <gtest/gtest.h>

#include "support/gpu_fixture.h"
#include "support/process.h"

namespace parhelion::testing::wavefront_cli_test {
namespace {

using Words = std::vector<std::string>;
const Words kRender{"render", "builtin:cornell", "--exposure", "3", "--max-bounces", "3"};
const Words kWavefront{"--renderer", "wavefront"};

Words operator+(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

class WavefrontFiles : public ::testing::Test {
protected:
    void SetUp() override {
        if (shared_device()) return;
        if (is_required("device")) FAIL() << "there is no Vulkan device";
        GTEST_SKIP() << "there is no Vulkan device";
    }
    std::string file(const std::string& name) const { return folder.file(name); }
    std::string bytes(const std::string& name) const { return read_bytes(file(name)); }
    bool is_cpu() const { return shared_device()->caps().type == gpu::DeviceType::Cpu; }
    void draw(const Words& words, const std::string& name) {
        const ProcessResult result = run_parhelion(kRender + words + Words{"--out", file(name)});
        ASSERT_EQ(result.exit_code, 0) << result.err;
        EXPECT_GT(bytes(name).size(), 1000u);
    }
    TemporaryFolder folder;
};

// LP_NUM_THREADS as in CliRender.the_number_of_threads_changes_no_bit; on a CPU device the file is the reference's too.
TEST_F(WavefrontFiles, the_number_of_threads_changes_no_bit) {
    const Words job = kRender + Words{"--size", "40x24", "--spp", "2", "--aov", "variance,path.*", "--out", "a.exr"};
    const auto bytes_of = [&](const Words& words, const char* threads) {
        const ProcessResult result = run_parhelion(job + words, {.environment = {{"LP_NUM_THREADS", threads}}, .folder = folder.path()});
        EXPECT_EQ(result.exit_code, 0) << result.err;
        return bytes("a.exr");
    };
    for (const gpu::TraceWay way : {gpu::TraceWay::Query, gpu::TraceWay::Pipeline, gpu::TraceWay::Compute}) {
        if (!shared_device()->caps().supports(way)) continue;
        const Words trace{"--trace", std::string(gpu::trace_way_name(way))};
        const std::string of_one_thread = bytes_of(trace + kWavefront, "0");
        EXPECT_GT(of_one_thread.size(), 1000u);
        EXPECT_TRUE(bytes_of(trace + kWavefront + Words{"--set", "wavefront.connect=each_bounce"}, "7") == of_one_thread) << gpu::trace_way_name(way);
        if (is_cpu()) {
            EXPECT_TRUE(bytes_of(trace, "2") == of_one_thread) << gpu::trace_way_name(way);
        }
    }
}

TEST_F(WavefrontFiles, merged_parts_are_the_whole_bit_for_bit) {
    const Words base{"--size", "20x12", "--aov", "albedo,normal,emission,roughness,depth,ids,motion,variance,path.*"};
    draw(base + kWavefront + Words{"--spp", "192"}, "whole.exr");
    draw(base + kWavefront + Words{"--spp-range", "64-192", "--set", "wavefront.slots=37"}, "second.exr");
    draw(base + (is_cpu() ? Words{} : kWavefront) + Words{"--spp-range", "0-64"}, "first.exr");
    const ProcessResult merged = run_parhelion({"merge", file("second.exr"), file("first.exr"), "--out", file("merged.exr")});
    ASSERT_EQ(merged.exit_code, 0) << merged.err;
    EXPECT_TRUE(bytes("merged.exr") == bytes("whole.exr"));
}

// Ctrl-C comes once the first block is saved.
TEST_F(WavefrontFiles, an_interrupted_job_resumes_and_draws_the_whole) {
    const Words saved{"--size", "16x16", "--checkpoint", file("c.state"), "--checkpoint-every", "1ms", "--resume", "--json", "-"};
    ProcessOptions options{.signal = SIGINT};
    options.signal_when = [&](const ProcessResult&) { return std::filesystem::exists(file("c.state")); };
    const ProcessResult first = run_parhelion(kRender + saved + kWavefront + Words{"--spp", "1000000", "--out", file("first.exr")}, options);
    ASSERT_EQ(first.exit_code, 130) << first.err;
    const int blocks = first.json()["spp"].get<int>() / 64;
    ASSERT_GE(blocks, 1);
    const Words whole{"--spp", std::to_string(64 * (blocks + 1))};
    const ProcessResult second = run_parhelion(kRender + saved + kWavefront + whole + Words{"--out", file("second.exr")});
    ASSERT_EQ(second.exit_code, 0) << second.err;
    EXPECT_EQ(second.json()["resumed_at"], 64 * blocks);
    draw(whole + Words{"--size", "16x16"} + (is_cpu() ? Words{} : kWavefront), "whole.exr");
    EXPECT_TRUE(bytes("second.exr") == bytes("whole.exr"));
}

TEST_F(WavefrontFiles, its_report_counts_the_rays_of_the_reference) {
    const Words job = kRender + Words{"--size", "24x16", "--spp", "2", "--json", "-", "--out", file("a.exr")};
    const ProcessResult reference = run_parhelion(job), wavefront = run_parhelion(job + kWavefront);
    ASSERT_EQ(wavefront.exit_code, 0) << wavefront.err;
    ASSERT_TRUE(wavefront.json().contains("rays")) << wavefront.out;
    if (is_cpu()) {
        EXPECT_EQ(wavefront.json()["rays"], reference.json()["rays"]);
    }
    EXPECT_GT(wavefront.json()["rays"].dump().size(), 10u);
}

TEST_F(WavefrontFiles, more_slots_than_there_may_be_are_wrong_usage) {
    const ProcessResult result = run_parhelion(kRender + kWavefront + Words{"--set", "wavefront.slots=4194305", "--out", file("a.exr")});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.err.find("wavefront.slots"), std::string::npos) << result.err;
    EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace parhelion::testing::wavefront_cli_test
