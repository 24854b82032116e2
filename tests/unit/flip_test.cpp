// FLIP against the official evaluator (tools/oracles/make_flip_oracle.py) and where that has no right answer.
#include "image/flip.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <sstream>

#include <gtest/gtest.h>

#include "image/decode.h"

namespace parhelion::image::flip_test {
namespace {

const std::filesystem::path kData = std::filesystem::path(PARHELION_SOURCE_DIR) / "tests/unit/data/flip";

struct Expected {
    std::string name, range;
    double mean = 0, p5 = 0, p50 = 0, p95 = 0, max = 0, start = 0, stop = 0;
    uint32_t exposures = 0;
};

std::vector<Expected> read_expected() {
    std::ifstream in(kData / "expected.tsv");
    std::string line;
    std::getline(in, line);
    std::vector<Expected> rows;
    while (std::getline(in, line)) {
        std::istringstream fields(line);
        Expected e;
        fields >> e.name >> e.range >> e.mean >> e.p5 >> e.p50 >> e.p95 >> e.max >> e.start >> e.stop >> e.exposures;
        rows.push_back(e);
    }
    return rows;
}

struct Pair {
    ImageF reference, test;
    Flip hdr() const { return flip_hdr(rgb_planes(reference), rgb_planes(test), reference.width, reference.height); }
    Flip ldr() const { return flip_ldr(rgb_planes(reference), rgb_planes(test), reference.width, reference.height); }
};

Pair read_pair(const Expected& e) {
    const std::string extension = e.range == "HDR" ? ".exr" : ".png";
    return {read_linear(kData / (e.name + ".reference" + extension)), read_linear(kData / (e.name + ".test" + extension))};
}

// Linear interpolation between order statistics.
double percentile(std::vector<float> values, double share) {
    std::sort(values.begin(), values.end());
    const double position = share * static_cast<double>(values.size() - 1);
    const auto i = static_cast<size_t>(position);
    const double t = position - static_cast<double>(i);
    return (1 - t) * values[i] + t * values[std::min(i + 1, values.size() - 1)];
}

Pair random_pair(uint32_t width, uint32_t height, float noise) {
    Pair pair{make_image(width, height, {"R", "G", "B"}), make_image(width, height, {"R", "G", "B"})};
    std::mt19937 rng(5);
    std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
    for (size_t i = 0; i < pair.test.data.size(); ++i) {
        pair.reference.data[i] = uniform(rng);
        pair.test.data[i] = pair.reference.data[i] * (1.0f + noise * (uniform(rng) - 0.5f));
    }
    return pair;
}

void blacken(ImageF& image, uint32_t columns) {
    for (size_t c = 0; c < image.channels.size(); ++c)
        for (uint32_t y = 0; y < image.height; ++y)
            for (uint32_t x = 0; x < columns; ++x) image.plane(c)[size_t{y} * image.width + x] = 0.0f;
}

}  // namespace

TEST(Flip, agrees_with_the_official_evaluator_on_stored_pairs) {
    const std::vector<Expected> rows = read_expected();
    ASSERT_GE(rows.size(), 5u);
    for (const Expected& e : rows) {
        const Pair pair = read_pair(e);
        const Flip flip = e.range == "HDR" ? pair.hdr() : pair.ldr();
        EXPECT_NEAR(flip.mean, e.mean, 1e-4) << e.name;
        EXPECT_NEAR(percentile(flip.map, 0.05), e.p5, 1e-3) << e.name;
        EXPECT_NEAR(percentile(flip.map, 0.5), e.p50, 1e-3) << e.name;
        EXPECT_NEAR(percentile(flip.map, 0.95), e.p95, 1e-3) << e.name;
        EXPECT_NEAR(percentile(flip.map, 1.0), e.max, 1e-3) << e.name;
        EXPECT_NEAR(flip.start_exposure, e.start, 1e-4) << e.name;
        EXPECT_NEAR(flip.stop_exposure, e.stop, 1e-4) << e.name;
        EXPECT_EQ(flip.exposures, e.exposures) << e.name;
    }
}

TEST(Flip, equal_images_are_zero_everywhere) {
    const Pair pair = random_pair(40, 30, 0.0f);
    for (const Flip& flip : {pair.hdr(), pair.ldr()}) {
        EXPECT_EQ(flip.mean, 0.0);
        EXPECT_EQ(*std::max_element(flip.map.begin(), flip.map.end()), 0.0f);
    }
}

TEST(Flip, black_against_white_is_one) {
    Pair pair{make_image(40, 30, {"R", "G", "B"}), make_image(40, 30, {"R", "G", "B"})};
    std::fill(pair.test.data.begin(), pair.test.data.end(), 1.0f);
    EXPECT_GT(pair.ldr().mean, 0.95);
}

TEST(Flip, grows_with_the_error) {
    double before = 0.0;
    for (const float noise : {0.05f, 0.1f, 0.3f, 1.0f}) {
        const double mean = random_pair(40, 30, noise).hdr().mean;
        EXPECT_GT(mean, 1.2 * before) << noise;
        before = mean;
    }
}

TEST(Flip, hdr_does_not_depend_on_the_scale_of_both_images) {
    Pair pair = random_pair(40, 30, 0.5f);
    const double mean = pair.hdr().mean;
    for (float& v : pair.reference.data) v *= 4096.0f;
    for (float& v : pair.test.data) v *= 4096.0f;
    EXPECT_NEAR(pair.hdr().mean, mean, 1e-5);
}

TEST(Flip, a_picture_whose_median_is_black_is_judged_by_its_lit_pixels) {
    Pair pair = random_pair(100, 40, 0.8f);
    const Flip lit = pair.hdr();
    blacken(pair.reference, 60);
    blacken(pair.test, 60);
    const Flip half = pair.hdr();
    // The lit pixels have the same distribution: so do the exposures, and the error is that of the lit share.
    EXPECT_NEAR(half.start_exposure, lit.start_exposure, 0.1);
    EXPECT_NEAR(half.stop_exposure, lit.stop_exposure, 0.1);
    EXPECT_NEAR(half.mean / lit.mean, 0.4, 0.04);  // the blur carries some over the border
    EXPECT_LE(half.exposures, 3u);
}

TEST(Flip, light_where_the_reference_is_black_altogether_is_an_error) {
    Pair pair{make_image(40, 30, {"R", "G", "B"}), make_image(40, 30, {"R", "G", "B"})};
    EXPECT_EQ(pair.hdr().mean, 0.0) << "black equals black";
    for (size_t p = 0; p < pair.test.pixel_count(); p += 7) pair.test.plane(1)[p] = 0.01f;
    EXPECT_GT(pair.hdr().mean, 0.2);
}

TEST(Flip, a_dark_median_beside_a_bright_sun_stays_finite_and_bounded) {
    Pair pair = random_pair(40, 30, 0.5f);
    for (float& v : pair.reference.data) v *= 1e-30f;
    pair.reference.data[0] = 1e30f;
    const Flip flip = pair.hdr();
    EXPECT_EQ(flip.exposures, 40u);
    EXPECT_TRUE(std::isfinite(flip.mean));
}

TEST(Flip, values_that_are_no_light_count_as_black) {
    Pair pair = random_pair(40, 30, 0.3f);
    Pair cleaned = pair;
    const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -3.0f};
    for (size_t i = 0; i < 3; ++i) {
        pair.test.data[50 * i] = bad[i];
        cleaned.test.data[50 * i] = 0.0f;
    }
    EXPECT_EQ(pair.hdr().map, cleaned.hdr().map);
}

TEST(Flip, works_on_images_smaller_than_its_filters) {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {3u, 2u}, {17u, 1u}, {1u, 33u}}) {
        const Flip flip = random_pair(width, height, 0.5f).hdr();
        EXPECT_TRUE(std::isfinite(flip.mean));
        EXPECT_GT(flip.mean, 0.0);
    }
}

TEST(Flip, the_picture_of_the_map_grows_lighter_with_the_error) {
    Flip flip;
    for (int i = 0; i <= 100; ++i) flip.map.push_back(static_cast<float>(i) / 100.0f);
    const Picture8 picture = flip_picture(flip, 101, 1);
    double before = -1.0;
    for (size_t p = 0; p < 101; ++p) {
        double value = 0.0;
        const float weights[] = {0.2126f, 0.7152f, 0.0722f};
        for (size_t c = 0; c < 3; ++c) value += weights[c] * linear_from_srgb(static_cast<float>(picture.rgb[3 * p + c]) / 255.0f);
        EXPECT_GE(value, before);
        before = value;
    }
    EXPECT_GT(before, 0.9);
}

}  // namespace parhelion::image::flip_test
