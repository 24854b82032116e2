// Tone curves and exposure.
#include "image/tonemap.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace parhelion::image::tonemap_test {
namespace {

constexpr std::array kCurves = {ToneCurve::Linear, ToneCurve::Aces, ToneCurve::Agx};

ImageF one_pixel(float r, float g, float b) {
    ImageF image = make_image(1, 1, {"R", "G", "B"});
    image.data = {r, g, b};
    return image;
}

}  // namespace

TEST(Tonemap, exposure_follows_ev100) {
    EXPECT_DOUBLE_EQ(exposure_scale_from_ev100(0.0), 1.0 / 1.2);
    EXPECT_DOUBLE_EQ(exposure_scale_from_ev100(10.0), 1.0 / 1228.8);
    EXPECT_DOUBLE_EQ(exposure_scale_from_ev100(-1.0) / exposure_scale_from_ev100(0.0), 2.0);
}

TEST(Tonemap, the_srgb_transfer_matches_the_standard_and_its_inverse) {
    EXPECT_NEAR(srgb_from_linear(0.5f), 0.735356984f, 1e-6f);
    EXPECT_NEAR(srgb_from_linear(0.001f), 0.01292f, 1e-7f);
    EXPECT_NEAR(linear_from_srgb(0.5f), 0.214041141f, 1e-6f);
    for (int i = 0; i <= 255; ++i) {
        const float v = static_cast<float>(i) / 255.0f;
        EXPECT_NEAR(srgb_from_linear(linear_from_srgb(v)), v, 2e-6f);
    }
}

TEST(Tonemap, the_linear_curve_gives_the_srgb_bytes) {
    const Picture8 picture = tonemap_to_srgb(one_pixel(0.5f, 1.0f, 7.0f), ToneCurve::Linear, 1.0);
    EXPECT_EQ(picture.rgb, (std::vector<uint8_t>{188, 255, 255}));
    EXPECT_EQ(tonemap_to_srgb(one_pixel(300.0f, 0.0f, -1.0f), ToneCurve::Linear, 0.5 / 300.0).rgb, (std::vector<uint8_t>{188, 0, 0}));
}

TEST(Tonemap, an_eight_bit_picture_survives_the_linear_curve) {
    Texture8 texture{.width = 256, .height = 1};
    for (int i = 0; i < 256; ++i) texture.rgba.insert(texture.rgba.end(), {static_cast<uint8_t>(i), static_cast<uint8_t>(255 - i), 7, 128});
    const Picture8 picture = tonemap_to_srgb(linear_image(texture), ToneCurve::Linear, 1.0);
    for (size_t i = 0; i < 256; ++i) {
        EXPECT_EQ(picture.rgb[3 * i], i);
        EXPECT_EQ(picture.rgb[3 * i + 1], 255 - i);
        EXPECT_EQ(picture.rgb[3 * i + 2], 7);
    }
}

TEST(Tonemap, every_curve_is_black_at_zero_white_at_the_top_and_never_falls) {
    const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    for (const ToneCurve curve : kCurves) {
        for (const float v : {0.0f, -5.0f, nan, -inf}) EXPECT_LE(apply_tone_curve({v, v, v}, curve)[1], 1e-6f) << v;
        for (const float v : {1e6f, 3e38f, inf}) EXPECT_GE(apply_tone_curve({v, v, v}, curve)[1], 0.99f) << v;
        float before = -1.0f;
        for (float stops = -14.0f; stops < 10.0f; stops += 0.01f) {
            const float v = std::exp2(stops);
            const Rgb grey = apply_tone_curve({v, v, v}, curve);
            EXPECT_GE(grey[1], before - 1e-6f) << v;
            EXPECT_NEAR(grey[0], grey[1], 1e-3f) << "grey must stay grey at " << v;
            EXPECT_NEAR(grey[2], grey[1], 1e-3f) << "grey must stay grey at " << v;
            before = grey[1];
        }
    }
}

TEST(Tonemap, middle_grey_lands_where_each_curve_is_known_to_put_it) {
    const Rgb grey = {0.18f, 0.18f, 0.18f};
    EXPECT_FLOAT_EQ(apply_tone_curve(grey, ToneCurve::Linear)[1], 0.18f);
    EXPECT_NEAR(apply_tone_curve(grey, ToneCurve::Aces)[1], 0.10f, 0.01f);                  // ACES shows 18 % at 10 %
    EXPECT_NEAR(apply_tone_curve(grey, ToneCurve::Agx)[1], std::pow(0.5f, 2.2f), 0.005f);  // AgX's curve turns there, at half the signal
}

TEST(Tonemap, agx_fades_bright_saturated_light_to_white_and_aces_does_too) {
    for (const ToneCurve curve : {ToneCurve::Aces, ToneCurve::Agx}) {
        const Rgb dim = apply_tone_curve({0.2f, 0.0f, 0.0f}, curve), bright = apply_tone_curve({50.0f, 0.0f, 0.0f}, curve);
        EXPECT_GT(dim[0], 3.0f * dim[1]);
        EXPECT_GT(bright[1], 0.1f);
    }
}

TEST(Tonemap, layers_are_chosen_by_name) {
    ImageF image = make_image(1, 1, {"R", "G", "B", "albedo.R", "albedo.G", "albedo.B", "depth.Y"});
    image.data = {0, 0, 0, 1, 0, 1, 0.5f};
    EXPECT_EQ(tonemap_to_srgb(image, ToneCurve::Linear, 1.0, "albedo").rgb, (std::vector<uint8_t>{255, 0, 255}));
    EXPECT_EQ(tonemap_to_srgb(image, ToneCurve::Linear, 1.0, "depth").rgb, (std::vector<uint8_t>{188, 188, 188}));
}

}  // namespace parhelion::image::tonemap_test
