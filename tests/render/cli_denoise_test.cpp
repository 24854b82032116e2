// render --denoise oidn as a user runs it, with a stand-in for the library (tests/stubs/oidn.cpp): half the red light, prefiltered guides
// as green and blue.
#include <algorithm>

#include <gtest/gtest.h>

#include "image/decode.h"
#include "support/gpu_fixture.h"
#include "support/process.h"

namespace parhelion::testing::cli_denoise_test {
namespace {

using Words = std::vector<std::string>;

Words operator+(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

class CliDenoise : public GpuTest {
protected:
    TemporaryFolder folder;
    const Words small{"render", "builtin:cornell", "--size", "24x16", "--exposure", "3", "--exr-type", "float"};

    ProcessResult run(const Words& more, const char* fails = "") const {
        return run_parhelion(small + more, {.environment = {{"PARHELION_OIDN", PARHELION_OIDN_STUB}, {"STUB_FAILS", fails}}});
    }
    image::ImageF read(const char* name) const { return image::read_linear(folder.file(name)); }
    std::vector<float> plane(const image::ImageF& image, std::string_view channel) const {
        const auto values = image.plane(image.find_channel(channel).value());
        return {values.begin(), values.end()};
    }
};

}  // namespace

TEST_F(CliDenoise, every_renderer_writes_the_denoised_picture_and_the_noisy_one_as_a_layer) {
    for (const Words& renderer : {Words{"--renderer", "reference", "--spp", "2"}, Words{"--renderer", "wavefront", "--spp", "2"}, Words{"--renderer", "realtime", "--frames", "2"}}) {
        const ProcessResult plain = run(renderer + Words{"--aov", "albedo,normal", "--out", folder.file("plain.exr")});
        ASSERT_EQ(plain.exit_code, 0) << plain.err;
        const ProcessResult result = run(renderer + Words{"--denoise", "oidn", "--aov", "noisy,depth", "--json", "-", "--out", folder.file("a.exr"), "--out", folder.file("a.png")});
        ASSERT_EQ(result.exit_code, 0) << result.err;
        EXPECT_EQ(result.json()["denoise"]["by"], "Open Image Denoise 2.34.5");
        const image::ImageF before = read("plain.exr"), after = read("a.exr");
        for (const char* channel : {"R", "G", "B"}) EXPECT_EQ(plane(after, std::string("noisy.") + channel), plane(before, channel)) << renderer[1];
        EXPECT_FALSE(after.find_channel("albedo.R") || after.find_channel("normal.X")) << "guides that nobody asked for";
        EXPECT_TRUE(std::ranges::any_of(after.exact, [](const image::ExactLayer& layer) { return layer.channel == "depth"; }) || after.find_channel("depth"));
        const std::vector<float> red = plane(before, "R"), albedo = plane(before, "albedo.R"), normal = plane(before, "normal.Y");
        for (size_t i = 0; i < red.size(); ++i) {
            ASSERT_EQ(plane(after, "R")[i], red[i] / 2) << renderer[1] << " pixel " << i;
            ASSERT_EQ(plane(after, "G")[i], albedo[i] + 1.0f / 64);
            ASSERT_EQ(plane(after, "B")[i], normal[i] + 1.0f / 64);
        }
    }
    EXPECT_EQ(folder.names(), (Words{"a.exr", "a.png", "plain.exr"}));
}

TEST_F(CliDenoise, every_frame_of_a_sequence_is_denoised) {
    ASSERT_EQ(run({"--spp", "1", "--frames", "2", "--denoise", "oidn", "--aov", "noisy", "--out", folder.file("a.##.exr")}).exit_code, 0);
    for (const char* name : {"a.00.exr", "a.01.exr"}) {
        const image::ImageF frame = read(name);
        const std::vector<float> red = plane(frame, "R"), noisy = plane(frame, "noisy.R");
        for (size_t i = 0; i < red.size(); ++i) ASSERT_EQ(red[i], noisy[i] / 2) << name;
    }
}

TEST_F(CliDenoise, what_cannot_be_denoised_is_one_line_and_no_file) {
    const auto expect = [&](const ProcessResult& result, int code, const char* message) {
        EXPECT_EQ(result.exit_code, code) << result.err;
        EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
        EXPECT_EQ(folder.names(), Words{});
    };
    const Words out{"--spp", "1", "--denoise", "oidn", "--out", folder.file("a.exr"), "--out", folder.file("a.png")};
    expect(run(out, "memory"), 1, "error: --denoise oidn: there is not enough memory to denoise 24x16 pixels");
    expect(run_parhelion(small + out, {.environment = {{"PARHELION_OIDN", folder.file("none.so")}}}), 1, "none.so: the library cannot be loaded");
    expect(run_parhelion(small + out, {.environment = {{"PARHELION_OIDN", PARHELION_OIDN_STUB_1}}}), 1, "older than version 2");
    expect(run({"--spp", "1", "--aov", "noisy", "--out", folder.file("a.exr")}), 2, "noisy is what --denoise oidn was given");
    expect(run({"--spp-range", "0-64", "--denoise", "oidn", "--out", folder.file("a.exr")}), 2, "a part holds sums of samples");
    expect(run({"--spp", "1", "--denoise", "oidn", "--aov", "noisy", "--out", folder.file("a.png")}), 2, "layers need an EXR");
}

}  // namespace parhelion::testing::cli_denoise_test
