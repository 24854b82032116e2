// Open Image Denoise as a library that is there or not: with a stand-in (tests/stubs/oidn.cpp), which shows what it was given.
#include "image/denoise.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "base/error.h"
#include "session/async_denoiser.h"
#include "session/pictures.h"
#include "support/environment_variable.h"
#include "support/process.h"

namespace parhelion::testing::denoise_test {
namespace {

image::ImageF picture() {
    image::ImageF out = image::make_image(3, 2, {"R", "G", "B", "albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "roughness"});
    for (size_t i = 0; i < out.data.size(); ++i) out.data[i] = static_cast<float>(i) / 16.0f;
    out.exact.push_back({.channel = "depth", .words = {1, 2, 3, 4, 5, 6}});
    return out;
}

float value(const image::ImageF& image, std::string_view channel, size_t pixel) { return image.plane(image.find_channel(channel).value())[pixel]; }

// The line of the Error that making a Denoiser, or denoising with it, throws.
std::string failure() {
    image::ImageF image = picture();
    const std::vector<float> before = image.data;
    try {
        image::Denoiser().denoise(image);
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Failed);
        EXPECT_EQ(image.data, before) << "half done";
        EXPECT_EQ(error.line.find('\n'), std::string::npos) << error.line;
        return error.line;
    }
    return "(no error)";
}

void expect_in(const std::string& line, std::initializer_list<const char*> parts) {
    for (const char* part : parts) EXPECT_NE(line.find(part), std::string::npos) << "'" << part << "' in: " << line;
}

}  // namespace

TEST(Denoiser, colours_are_filtered_with_guides_that_were_filtered_before) {
    const EnvironmentVariable library("PARHELION_OIDN", PARHELION_OIDN_STUB);
    const image::Denoiser denoiser;
    EXPECT_EQ(denoiser.version(), "2.34.5");
    EXPECT_EQ(denoiser.library(), PARHELION_OIDN_STUB);
    const image::ImageF before = picture();
    image::ImageF after = before;
    denoiser.denoise(after);
    for (size_t i = 0; i < before.pixel_count(); ++i) {
        EXPECT_EQ(value(after, "R", i), value(before, "R", i) / 2);
        EXPECT_EQ(value(after, "G", i), value(before, "albedo.R", i) + 1.0f / 64);
        EXPECT_EQ(value(after, "B", i), value(before, "normal.Y", i) + 1.0f / 64);
    }
    for (size_t c = 3; c < before.channels.size(); ++c)
        EXPECT_TRUE(std::ranges::equal(after.plane(c), before.plane(c))) << before.channels[c];
    EXPECT_EQ(after.exact, before.exact);
}

TEST(Denoiser, a_picture_keeps_the_layers_that_were_asked_for_and_its_noisy_colours_if_they_were) {
    const EnvironmentVariable library("PARHELION_OIDN", PARHELION_OIDN_STUB);
    const image::Denoiser denoiser;
    const image::ImageF before = picture();
    image::ImageF plain = before, rich = before;
    denoise_picture(denoiser, std::vector<std::string>{"roughness"}, false, plain);
    EXPECT_EQ(plain.channels, (std::vector<std::string>{"R", "G", "B", "roughness"}));
    EXPECT_EQ(plain.data.size(), 4 * plain.pixel_count());
    EXPECT_EQ(value(plain, "R", 4), value(before, "R", 4) / 2);
    EXPECT_EQ(value(plain, "roughness", 4), value(before, "roughness", 4));
    EXPECT_EQ(plain.attributes.at(kDenoiserAttribute), "Open Image Denoise 2.34.5");
    denoise_picture(denoiser, std::vector<std::string>{"normal", "roughness"}, true, rich);
    EXPECT_EQ(rich.channels, (std::vector<std::string>{"R", "G", "B", "normal.X", "normal.Y", "normal.Z", "roughness", "noisy.R", "noisy.G", "noisy.B"}));
    for (size_t i = 0; i < before.pixel_count(); ++i) {
        EXPECT_EQ(value(rich, "R", i), value(before, "R", i) / 2);
        EXPECT_EQ(value(rich, "normal.Z", i), value(before, "normal.Z", i));
        for (const char* channel : {"R", "G", "B"}) EXPECT_EQ(value(rich, std::string("noisy.") + channel, i), value(before, channel, i));
    }
}

TEST(Denoiser, a_library_that_is_not_there_or_is_another_one_is_one_line_that_says_what_to_do) {
    TemporaryFolder folder;
    const std::string missing = folder.file("libOpenImageDenoise.so.2");
    {
        const EnvironmentVariable library("PARHELION_OIDN", missing.c_str());
        expect_in(failure(), {missing.c_str(), "cannot be loaded", "PARHELION_OIDN names the file"});
    }
    {
        const EnvironmentVariable library("PARHELION_OIDN", PARHELION_OIDN_STUB_1);
        expect_in(failure(), {PARHELION_OIDN_STUB_1, "older than version 2", "install Open Image Denoise 2"});
    }
    const EnvironmentVariable library("PARHELION_OIDN", "libm.so.6");
    expect_in(failure(), {"libm.so.6", "not Open Image Denoise", "PARHELION_OIDN=/path/to"});
}

TEST(Denoiser, what_fails_in_the_library_is_one_line_and_the_picture_stays_as_it_was) {
    const EnvironmentVariable library("PARHELION_OIDN", PARHELION_OIDN_STUB);
    {
        const EnvironmentVariable fails("STUB_FAILS", "memory");
        expect_in(failure(), {"--denoise oidn", "not enough memory to denoise 3x2 pixels", "smaller --size"});
    }
    {
        const EnvironmentVariable fails("STUB_FAILS", "filter");
        expect_in(failure(), {"--denoise oidn", "failed on 3x2 pixels", "something\\x0aunexpected"});
    }
    const EnvironmentVariable fails("STUB_FAILS", "device");
    expect_in(failure(), {PARHELION_OIDN_STUB, "cannot use this CPU", "this machine is not good enough"});
}

// A film whose picture has R = `red` in its one pixel.
FilmCopy film(float red) {
    FilmCopy out{.sums = image::make_film(1, 1, {"R", "G", "B", "albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z"}, 0, 2), .samples_of_rows = {2}};
    out.sums.add_block(0, 0, 2 * red);
    return out;
}

// What is handed out by the time that nothing runs any more.
std::optional<image::ImageF> wait_for(AsyncDenoiser& denoiser) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!denoiser.is_idle() && std::chrono::steady_clock::now() < end) {
        if (auto picture = denoiser.take()) return picture;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_TRUE(denoiser.is_idle()) << "it never ends";
    return std::nullopt;
}

TEST(AsyncDenoiser, a_picture_is_handed_out_once_and_never_after_its_generation) {
    const EnvironmentVariable library("PARHELION_OIDN", PARHELION_OIDN_STUB);
    AsyncDenoiser denoiser;
    EXPECT_TRUE(denoiser.is_idle());
    EXPECT_FALSE(denoiser.take());
    denoiser.start(film(4));
    const auto first = wait_for(denoiser);
    ASSERT_TRUE(first);
    EXPECT_EQ(value(*first, "R", 0), 2.0f);
    EXPECT_TRUE(denoiser.is_idle());
    EXPECT_FALSE(denoiser.take());
    denoiser.start(film(6));
    denoiser.discard();
    EXPECT_FALSE(wait_for(denoiser)) << "it shows what is no more";
    denoiser.start(film(8));
    const auto next = wait_for(denoiser);
    ASSERT_TRUE(next);
    EXPECT_EQ(value(*next, "R", 0), 4.0f);
}

TEST(AsyncDenoiser, a_failure_is_thrown_where_the_picture_would_be_taken_unless_it_is_discarded) {
    const EnvironmentVariable library("PARHELION_OIDN", PARHELION_OIDN_STUB), fails("STUB_FAILS", "memory");
    AsyncDenoiser denoiser;
    denoiser.start(film(4));
    EXPECT_THROW(wait_for(denoiser), Error);
    EXPECT_TRUE(denoiser.is_idle());
    denoiser.start(film(4));
    denoiser.discard();
    EXPECT_NO_THROW(EXPECT_FALSE(wait_for(denoiser)));
}

}  // namespace parhelion::testing::denoise_test
