// Images to files and back.
#include "image/encode.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"

namespace parhelion::image::image_encode_test {
namespace {

namespace fs = std::filesystem;

ImageF sample_image() {
    ImageF image = make_image(37, 21, {"R", "G", "B", "albedo.R", "path.direct_diffuse.G", "depth"});
    std::mt19937 rng(7);
    for (float& v : image.data) v = std::exp2(std::uniform_real_distribution(-14.0f, 15.0f)(rng));
    image.data[5] = 0.0f;
    image.data[6] = -2.5f;
    image.attributes = {{"parhelion.exposure", "3.25"}, {"parhelion.settings", "00ff"}};
    return image;
}

fs::path fresh_folder(const std::string& name) {
    const fs::path folder = fs::temp_directory_path() / ("parhelion_image_test_" + name + std::to_string(std::random_device{}()));
    fs::create_directories(folder);
    return folder;
}

std::vector<float> plane_of(const ImageF& image, std::string_view name) {
    const auto plane = image.plane(image.find_channel(name).value());
    return {plane.begin(), plane.end()};
}

}  // namespace

// Half would round a depth and no float holds every number of a triangle.
TEST(Exr, exact_layers_keep_every_bit_in_a_half_exr) {
    ImageF image{.width = 2, .height = 1};
    const uint32_t far = std::bit_cast<uint32_t>(std::numeric_limits<float>::infinity());
    image.exact = {{"depth", false, {std::bit_cast<uint32_t>(1234.5678f), far}}, {"motion.X", false, {std::bit_cast<uint32_t>(-1e-7f), 0}}};
    EXPECT_EQ(decode_exr(encode_exr(image, ExrPrecision::Half).bytes).data, (std::vector<float>{1234.5678f, std::numeric_limits<float>::infinity(), -1e-7f, 0.0f}));
    image.exact = {{"ids.instance", true, {0xFFFFFFFFu, 16777217u}}};
    EXPECT_EQ(decode_uint_exr(encode_exr(image, ExrPrecision::Half).bytes).data, image.exact[0].words);
    image.exact[0].words.pop_back();
    EXPECT_THROW(encode_exr(image, ExrPrecision::Half), Error);
}

TEST(Exr, a_float_image_survives_bit_for_bit) {
    const ImageF image = sample_image(), read = decode_exr(encode_exr(image, ExrPrecision::Float).bytes);
    EXPECT_EQ(read.width, image.width);
    EXPECT_EQ(read.height, image.height);
    EXPECT_EQ(read.channels.size(), image.channels.size());
    EXPECT_EQ(read.attributes, image.attributes);
    for (const std::string& name : image.channels) EXPECT_EQ(plane_of(read, name), plane_of(image, name)) << name;
}

TEST(Exr, a_half_image_is_right_to_eleven_bits) {
    const ImageF image = sample_image(), read = decode_exr(encode_exr(image, ExrPrecision::Half).bytes);
    for (const std::string& name : image.channels) {
        const std::vector<float> expected = plane_of(image, name), found = plane_of(read, name);
        for (size_t p = 0; p < expected.size(); ++p) EXPECT_LE(std::abs(found[p] - expected[p]), std::abs(expected[p]) / 2048.0f);
    }
}

TEST(Exr, half_clamps_what_it_cannot_hold_and_counts_it) {
    ImageF image = make_image(3, 1, {"R"});
    image.data = {1e9f, -1e9f, 65504.0f};
    const EncodedExr encoded = encode_exr(image, ExrPrecision::Half);
    EXPECT_EQ(encoded.clamped, 2u);
    EXPECT_EQ(decode_exr(encoded.bytes).data, (std::vector<float>{65504.0f, -65504.0f, 65504.0f}));
    EXPECT_EQ(encode_exr(image, ExrPrecision::Float).clamped, 0u);
}

TEST(Exr, nan_and_infinity_stay_visible) {
    ImageF image = make_image(2, 1, {"R"});
    image.data = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()};
    for (const ExrPrecision precision : {ExrPrecision::Half, ExrPrecision::Float}) {
        const ImageF read = decode_exr(encode_exr(image, precision).bytes);
        EXPECT_TRUE(std::isnan(read.data[0]));
        EXPECT_TRUE(std::isinf(read.data[1]));
    }
}

TEST(Exr, equal_images_give_equal_bytes) {
    EXPECT_EQ(encode_exr(sample_image(), ExrPrecision::Half).bytes, encode_exr(sample_image(), ExrPrecision::Half).bytes);
    const std::vector<std::byte> bytes = encode_exr(sample_image(), ExrPrecision::Half).bytes;
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    for (const char* word : {"capDate", "owner", "utcOffset"}) EXPECT_EQ(text.find(word), std::string_view::npos) << word;
}

TEST(Exr, uint_channels_survive_exactly) {
    UintImage image{.width = 3, .height = 2, .channels = {"a.0", "a.1"}};
    for (uint32_t i = 0; i < 12; ++i) image.data.push_back(0xFFFFFFF0u + 3 * i);
    const UintImage read = decode_uint_exr(encode_uint_exr(image));
    EXPECT_EQ(read.channels, image.channels);
    EXPECT_EQ(read.data, image.data);
    EXPECT_THROW(decode_uint_exr(encode_exr(sample_image(), ExrPrecision::Float).bytes), Error);
}

TEST(Png, eight_bit_rgb_survives) {
    Picture8 picture{.width = 19, .height = 7};
    std::mt19937 rng(3);
    for (size_t i = 0; i < 3 * 19 * 7; ++i) picture.rgb.push_back(static_cast<uint8_t>(rng()));
    const std::vector<std::byte> bytes = encode_png(picture);
    EXPECT_EQ(bytes, encode_png(picture));
    const Texture8 read = decode_png(bytes);
    ASSERT_EQ(read.rgba.size(), size_t{4} * 19 * 7);
    for (size_t p = 0; p < size_t{19} * 7; ++p) {
        EXPECT_EQ(0, std::memcmp(&read.rgba[4 * p], &picture.rgb[3 * p], 3));
        EXPECT_EQ(read.rgba[4 * p + 3], 255);
    }
    EXPECT_TRUE(read.attributes.empty());
    picture.attributes = {{"frame_hash", "00ff"}, {"note", "two words"}};
    EXPECT_EQ(decode_png(encode_png(picture)).attributes, picture.attributes);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    EXPECT_NE(text.find("sRGB"), std::string_view::npos);
    EXPECT_EQ(text.find("tIME"), std::string_view::npos);
}

TEST(ImageFiles, are_written_whole_and_replaced) {
    const fs::path folder = fresh_folder("write");
    ImageF image = sample_image();
    write_exr(folder / "a.exr", image, ExrPrecision::Float);
    image.data[0] = 42.0f;
    write_exr(folder / "a.exr", image, ExrPrecision::Float);
    write_png(folder / "a.png", {.width = 1, .height = 1, .rgb = {255, 0, 188}});
    EXPECT_EQ(plane_of(read_linear(folder / "a.exr"), "R")[0], 42.0f);
    const ImageF png = read_linear(folder / "a.png");
    EXPECT_EQ(png.channels, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_NEAR(png.data[2], 0.5f, 0.01f);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 2);
    fs::remove_all(folder);
}

TEST(ImageFiles, a_target_that_cannot_be_written_is_an_error_that_names_it) {
    try {
        write_exr("/nonexistent_folder/a.exr", sample_image(), ExrPrecision::Half);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(error.line.find("/nonexistent_folder/a.exr"), std::string::npos);
    }
}

}  // namespace parhelion::image::image_encode_test
