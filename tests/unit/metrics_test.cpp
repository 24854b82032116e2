// Metrics and the whole comparison.
#include "image/metrics.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "base/error.h"
#include "image/compare.h"

namespace parhelion::image::metrics_test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

ImageF image_of(uint32_t width, uint32_t height, const std::function<float(size_t)>& value) {
    ImageF image = make_image(width, height, {"R", "G", "B"});
    for (size_t i = 0; i < image.data.size(); ++i) image.data[i] = value(i);
    return image;
}

ImageF noisy(uint32_t width, uint32_t height, uint32_t seed) {
    std::mt19937 rng(seed);
    std::lognormal_distribution<float> distribution(0.0f, 0.7f);
    return image_of(width, height, [&](size_t) { return distribution(rng); });
}

std::string error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.line;
    }
    return {};
}

// SSIM by its definition: explicit windows and means, in double.
double slow_ssim(const std::vector<float>& a, const std::vector<float>& b, int width, int height) {
    double weights[11][11], total = 0;
    for (int j = -5; j <= 5; ++j)
        for (int i = -5; i <= 5; ++i) total += weights[j + 5][i + 5] = std::exp(-(i * i + j * j) / 4.5);
    double sum = 0;
    int windows = 0;
    for (int y = 5; y < height - 5; ++y)
        for (int x = 5; x < width - 5; ++x, ++windows) {
            double ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
            const auto each = [&](const auto& body) {
                for (int j = -5; j <= 5; ++j)
                    for (int i = -5; i <= 5; ++i) {
                        const auto p = static_cast<size_t>((y + j) * width + x + i);
                        body(weights[j + 5][i + 5] / total, a[p], b[p]);
                    }
            };
            each([&](double w, double u, double v) { ma += w * u, mb += w * v; });
            each([&](double w, double u, double v) { va += w * (u - ma) * (u - ma), vb += w * (v - mb) * (v - mb), cov += w * (u - ma) * (v - mb); });
            sum += (2 * ma * mb + 1e-4) * (2 * cov + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
        }
    return sum / windows;
}

}  // namespace

TEST(Metrics, squared_errors_are_as_computed_by_hand) {
    const ImageF reference = image_of(2, 1, [](size_t i) { return static_cast<float>(i); });     // 0 .. 5
    const ImageF test = image_of(2, 1, [](size_t i) { return i == 5 ? 5.5f : static_cast<float>(i) + 0.1f; });
    const SquaredErrors errors = squared_errors(rgb_planes(test), rgb_planes(reference));
    double mse = 0, relmse = 0;
    for (int i = 0; i < 6; ++i) {
        const double d = i == 5 ? 0.5 : 0.1;
        mse += d * d / 6;
        relmse += d * d / (i * i + 0.01) / 6;
    }
    EXPECT_NEAR(errors.mse, mse, 1e-7);
    EXPECT_NEAR(errors.relmse, relmse, 1e-6);
    EXPECT_NEAR(errors.max_abs_error, 0.5, 1e-7);
}

TEST(Metrics, the_mean_ratio_is_per_channel_and_of_luminance) {
    const ImageF reference = noisy(300, 250, 1);  // more than one task of the parallel sums
    ImageF test = reference;
    for (size_t p = 0; p < test.pixel_count(); ++p) test.plane(0)[p] *= 1.5f, test.plane(2)[p] *= 0.5f;
    const MeanRatio ratio = mean_ratio(rgb_planes(test), rgb_planes(reference));
    EXPECT_NEAR(ratio.r, 1.5, 1e-6);
    EXPECT_NEAR(ratio.g, 1.0, 1e-12);
    EXPECT_NEAR(ratio.b, 0.5, 1e-6);
    EXPECT_NEAR(ratio.luminance, 0.2126 * 1.5 + 0.7152 + 0.0722 * 0.5, 5e-3);
    const ImageF black = make_image(300, 250, {"R", "G", "B"});
    EXPECT_TRUE(std::isinf(mean_ratio(rgb_planes(test), rgb_planes(black)).r));
    EXPECT_TRUE(std::isnan(mean_ratio(rgb_planes(black), rgb_planes(black)).luminance));
}

TEST(Metrics, bad_pixels_are_counted_once_and_left_out) {
    const ImageF reference = noisy(16, 16, 2);
    ImageF test = reference;
    test.plane(0)[3] = kNan, test.plane(1)[3] = kNan;
    test.plane(2)[4] = kInf;
    test.plane(1)[5] = -1.0f;
    const BadPixels bad = count_bad_pixels(rgb_planes(test));
    EXPECT_EQ(bad.nan, 1u);
    EXPECT_EQ(bad.infinite, 1u);
    EXPECT_EQ(bad.negative, 1u);
    const double expected = std::pow(reference.plane(1)[5] + 1.0, 2) / (3.0 * (256 - 2));
    EXPECT_NEAR(squared_errors(rgb_planes(test), rgb_planes(reference)).mse, expected, 1e-6 * expected);
    EXPECT_TRUE(std::isfinite(mean_ratio(rgb_planes(test), rgb_planes(reference)).r));
}

TEST(Metrics, psnr_follows_its_definition) {
    EXPECT_NEAR(psnr_from_mse(0.01), 20.0, 1e-12);
    EXPECT_NEAR(psnr_from_mse(65025.0 / 1000.0, 255.0), 30.0, 1e-12);
    EXPECT_TRUE(std::isinf(psnr_from_mse(0.0)));
}

TEST(Metrics, ssim_equals_the_slow_definition) {
    std::mt19937 rng(3);
    std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
    std::vector<float> a(31 * 23), b(a.size());
    for (size_t i = 0; i < a.size(); ++i) {
        a[i] = 0.5f + 0.4f * std::sin(0.3f * static_cast<float>(i));
        b[i] = std::clamp(a[i] + 0.3f * (uniform(rng) - 0.5f), 0.0f, 1.0f);
    }
    EXPECT_NEAR(ssim(a, b, 31, 23), slow_ssim(a, b, 31, 23), 1e-4);
    EXPECT_NEAR(ssim(a, a, 31, 23), 1.0, 1e-9);
    EXPECT_LT(ssim(a, b, 31, 23), 0.98);
    EXPECT_NEAR(ssim(std::span(a).first(12), std::span(a).first(12), 4, 3), 1.0, 1e-9) << "smaller than a window";
}

TEST(Comparison, equal_images_are_perfect) {
    const ImageF image = noisy(40, 30, 4);
    const Comparison comparison = compare_images(image, image);
    EXPECT_EQ(comparison.mean_ratio.luminance, 1.0);
    EXPECT_EQ(comparison.mse, 0.0);
    EXPECT_EQ(comparison.relmse, 0.0);
    EXPECT_TRUE(std::isinf(comparison.psnr));
    EXPECT_NEAR(comparison.ssim, 1.0, 1e-6);
    EXPECT_EQ(comparison.flip.mean, 0.0);
    EXPECT_EQ(comparison.bad.nan + comparison.bad.infinite + comparison.bad.negative, 0u);
}

TEST(Comparison, the_unit_of_the_radiance_does_not_matter) {
    ImageF reference = noisy(40, 30, 5), test = noisy(40, 30, 6);
    const Comparison before = compare_images(test, reference);
    for (ImageF* image : {&reference, &test})
        for (float& v : image->data) v *= 1024.0f;
    const Comparison after = compare_images(test, reference);
    EXPECT_NEAR(after.exposure_scale * 1024.0, before.exposure_scale, 1e-5 * before.exposure_scale);
    EXPECT_NEAR(after.mse, before.mse, 1e-4 * before.mse);
    EXPECT_NEAR(after.relmse, before.relmse, 1e-4 * before.relmse);
    EXPECT_NEAR(after.psnr, before.psnr, 1e-3);
    EXPECT_NEAR(after.flip.mean, before.flip.mean, 1e-5);
    const Comparison given = compare_images(test, reference, {.exposure_scale = 0.5});
    EXPECT_EQ(given.exposure_scale, 0.5);
    EXPECT_GT(given.mse, after.mse);
}

TEST(Comparison, every_number_gets_worse_with_more_noise) {
    const ImageF reference = noisy(64, 48, 7);
    std::vector<Comparison> results;
    for (const float amount : {0.05f, 0.2f, 0.8f}) {
        std::mt19937 rng(8);
        std::normal_distribution<float> normal;
        ImageF test = reference;
        for (float& v : test.data) v *= std::exp(amount * normal(rng));
        results.push_back(compare_images(test, reference));
    }
    for (size_t i = 1; i < results.size(); ++i) {
        EXPECT_GT(results[i].mse, results[i - 1].mse);
        EXPECT_GT(results[i].relmse, results[i - 1].relmse);
        EXPECT_LT(results[i].psnr, results[i - 1].psnr);
        EXPECT_LT(results[i].ssim, results[i - 1].ssim);
        EXPECT_GT(results[i].flip.mean, results[i - 1].flip.mean);
    }
}

TEST(Comparison, flip_takes_its_exposures_from_the_reference) {
    const ImageF reference = noisy(40, 30, 13);
    ImageF test = reference;
    for (float& v : test.data) v *= 8.0f;
    const Flip from_reference = flip_hdr(rgb_planes(reference), rgb_planes(test), 40, 30);
    EXPECT_NEAR(compare_images(test, reference, {.exposure_scale = 1.0}).flip.start_exposure, from_reference.start_exposure, 1e-9);
}

TEST(Comparison, display_pictures_are_compared_as_they_are) {
    Texture8 a{.width = 20, .height = 15}, b = a;
    std::mt19937 rng(9);
    for (int i = 0; i < 20 * 15 * 4; ++i) a.rgba.push_back(static_cast<uint8_t>(rng() % 240)), b.rgba.push_back(static_cast<uint8_t>(a.rgba.back() + 10));
    const Comparison comparison = compare_images(linear_image(b), linear_image(a), {.exposure_scale = 100.0});
    EXPECT_TRUE(comparison.display_referred);
    EXPECT_EQ(comparison.exposure_scale, 1.0);
    EXPECT_NEAR(comparison.psnr, 20.0 * std::log10(255.0 / 10.0), 1e-3);
    EXPECT_EQ(comparison.flip.exposures, 0u);
}

TEST(Comparison, pairs_that_do_not_fit_are_refused_clearly) {
    const ImageF image = noisy(16, 16, 10);
    EXPECT_NE(error_of([&] { compare_images(noisy(16, 8, 1), image, {.test_name = "a.exr", .reference_name = "b.exr"}); }).find("a.exr: is 16x8 pixels; b.exr is 16x16"),
              std::string::npos);
    ImageF picture = image;
    picture.display_referred = true;
    EXPECT_NE(error_of([&] { compare_images(picture, image); }).find("one is a display picture"), std::string::npos);
    EXPECT_NE(error_of([&] { compare_images(image, image, {.layer = "albedo", .test_name = "a.exr"}); }).find("a.exr: has no channels albedo.R"), std::string::npos);
}

TEST(Comparison, a_picture_with_bad_pixels_still_gets_all_its_numbers) {
    const ImageF reference = noisy(40, 30, 11);
    ImageF test = noisy(40, 30, 12);
    test.data[7] = kNan, test.data[8] = kInf, test.data[9] = -1.0f;
    const Comparison comparison = compare_images(test, reference);
    for (const double v : {comparison.mean_ratio.r, comparison.mean_ratio.luminance, comparison.mse, comparison.relmse, comparison.psnr, comparison.ssim,
                           comparison.flip.mean, comparison.max_abs_error})
        EXPECT_TRUE(std::isfinite(v));
    EXPECT_EQ(comparison.bad.nan, 1u);
    EXPECT_EQ(comparison.bad.infinite, 1u);
    EXPECT_EQ(comparison.bad.negative, 1u);
    EXPECT_EQ(comparison.reference_bad.nan, 0u);
}

TEST(Comparison, the_automatic_exposure_brings_the_lit_pixels_to_middle_grey) {
    ImageF image = image_of(10, 10, [](size_t) { return 9.0f; });
    EXPECT_NEAR(auto_exposure_scale(rgb_planes(image)), 0.02, 1e-7);
    for (size_t c = 0; c < 3; ++c)
        for (size_t p = 0; p < 60; ++p) image.plane(c)[p] = 0.0f;
    EXPECT_NEAR(auto_exposure_scale(rgb_planes(image)), 0.02, 1e-7);
    EXPECT_EQ(auto_exposure_scale(rgb_planes(make_image(4, 4, {"R", "G", "B"}))), 1.0);
}

}  // namespace parhelion::image::metrics_test
