// The path sampler: ranges, strata, independence of pixels, dimensions, seeds and rays. A14. How fast estimates converge with it
// is in sampler_convergence_test.cpp; that the device draws the same bits is in device/sampler_test.cpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>

#include <gtest/gtest.h>

#include "sampling/path_sampler.h"
#include "support/correlation.h"
#include "support/statistics.h"

namespace parhelion::sampler_test {
namespace {

using sampling::make_sampler;
using shared::PathSampler;
using testing::correlation;

constexpr std::array kKinds{shared::kSamplerOwen, shared::kSamplerCranley, shared::kSamplerPcg, shared::kSamplerWhite};

glm::vec2 draw(uint32_t kind, glm::uvec2 pixel, uint32_t sample_index, uint32_t seed, uint32_t dimension) {
    PathSampler s = make_sampler(pixel, sample_index, seed, kind);
    s.dimension = dimension;
    return shared::next_2d(s);
}

TEST(Sampler, numbers_are_multiples_of_a_24_bit_unit_below_one) {
    EXPECT_EQ(shared::uint_to_unit_float(0), 0.0f);
    EXPECT_EQ(shared::uint_to_unit_float(0xFFFFFFFFu), 1.0f - 0x1p-24f);
    for (const uint32_t kind : kKinds)
        for (uint32_t i = 0; i < 20000; ++i) {
            const glm::vec2 u = draw(kind, {i * 7u, i * i}, i * 40503u, i % 5, i % 300);
            for (const float v : {u.x, u.y}) {
                ASSERT_TRUE(v >= 0.0f && v < 1.0f) << v;
                ASSERT_EQ(v * 0x1p24f, std::floor(v * 0x1p24f));
            }
        }
}

TEST(Sampler, a_bounce_has_its_dimensions_whatever_was_consumed_before) {
    for (const uint32_t kind : kKinds) {
        PathSampler greedy = make_sampler({3, 4}, 5, 6, kind), modest = greedy;
        for (uint32_t bounce = 0; bounce < 12; ++bounce) {
            shared::start_bounce(greedy, bounce);
            shared::start_bounce(modest, bounce);
            const glm::vec2 a = shared::next_2d(greedy), b = shared::next_2d(modest);
            EXPECT_EQ(a, b) << "bounce " << bounce;
            for (int i = 0; i < 4; ++i) shared::next_1d(greedy);
        }
    }
    PathSampler s = make_sampler({0, 0}, 0, 0, shared::kSamplerOwen);
    shared::start_bounce(s, 1);
    EXPECT_EQ(s.dimension, shared::kCameraDimensions);
    shared::start_bounce(s, 2);
    EXPECT_EQ(s.dimension, shared::kCameraDimensions + shared::kDimensionsPerBounce);
}

TEST(Sampler, a_number_depends_on_nothing_but_its_keys) {
    for (const uint32_t kind : kKinds) {
        PathSampler s = make_sampler({10, 20}, 30, 40, kind);
        shared::next_2d(s);
        const float third = shared::next_1d(s);
        EXPECT_EQ(third, draw(kind, {10, 20}, 30, 40, 2).x);
    }
}

// Every aligned block of 4^k samples of every pixel puts one into each elementary interval; 64 samples: seven shapes.
TEST(Sampler, each_owen_pair_is_a_0_2_sequence_in_every_pixel_and_dimension) {
    for (uint32_t trial = 0; trial < 200; ++trial) {
        const glm::uvec2 pixel(trial * 37 % 1920, trial * 101 % 1080);
        const uint32_t dimension = trial * 3 % 200, begin = trial < 100 ? 0 : 64 * (trial * 977u);
        for (uint32_t m = 0; m <= 6; ++m)
            for (uint32_t a = 0; a <= m; ++a) {
                std::set<uint32_t> cells;
                for (uint32_t i = 0; i < (1u << m); ++i) {
                    const glm::vec2 u = draw(shared::kSamplerOwen, pixel, begin + i, trial, dimension);
                    cells.insert((static_cast<uint32_t>(u.x * static_cast<float>(1u << a)) << 8) | static_cast<uint32_t>(u.y * static_cast<float>(1u << (m - a))));
                }
                ASSERT_EQ(cells.size(), 1u << m) << "pixel " << pixel.x << ' ' << pixel.y << ", dimension " << dimension << ", strata 2^" << a << " x 2^" << m - a;
            }
    }
}

// A shifted (0,1)-sequence: 64 samples lie one in each interval of a grid that is shifted alike, so their places in it agree, but for
// the jitter of 2^-10.
TEST(Sampler, cranley_is_stratified_in_each_dimension_up_to_its_shift) {
    for (uint32_t dimension = 0; dimension < shared::kSobolDimensions; ++dimension) {
        std::vector<float> all, place;
        for (uint32_t i = 0; i < 64; ++i) {
            all.push_back(draw(shared::kSamplerCranley, {dimension * 5, 9}, 64 + i, 3, dimension).x * 64.0f);
            place.push_back(all.back() - std::floor(all.back()));
        }
        std::sort(place.begin(), place.end());
        // On the circle all places fall together but for the jitter; the grid begins behind the gap.
        float gap = 1.0f - place.back() + place.front(), shift = place.front();
        for (size_t i = 1; i < place.size(); ++i)
            if (place[i] - place[i - 1] > gap) gap = place[i] - place[i - 1], shift = place[i];
        std::set<uint32_t> cells;
        for (const float u : all) cells.insert(static_cast<uint32_t>(u - shift + 64.0f) % 64);
        EXPECT_EQ(cells.size(), 64u);
        EXPECT_GT(gap, 1.0f - 64.0f / 1024.0f - 1e-4f) << "dimension " << dimension;
    }
}

// A table of 2^17 rows makes the choice between a bin and its alias of what is left of a number below 2^-17: a pixel's samples must
// not all choose alike.
TEST(Sampler, cranley_has_digits_of_its_own_for_each_sample) {
    for (uint32_t dimension = 0; dimension < shared::kSobolDimensions; ++dimension) {
        uint32_t above = 0;
        for (uint32_t i = 0; i < 256; ++i) {
            const float rest = draw(shared::kSamplerCranley, {dimension * 5, 9}, i, 3, dimension).x * 131072.0f;
            above += rest - std::floor(rest) >= 0.5f ? 1 : 0;
        }
        EXPECT_GT(above, 90u) << "dimension " << dimension;  // 128 +-8; false alarm 2e-6 a dimension
        EXPECT_LT(above, 166u) << "dimension " << dimension;
    }
}

// One sample a pixel over one tile in 16 x 16 cells. False alarms: 1 % over all.
TEST(Sampler, numbers_are_uniform_over_pixels) {
    constexpr uint32_t kPixels = shared::kBlueNoiseSize * shared::kBlueNoiseSize;
    for (const uint32_t kind : kKinds)
        for (const uint32_t dimension : {0u, 1u, 9u, 40u, 200u}) {
            std::vector<double> seen(256, 0);
            for (uint32_t i = 0; i < kPixels; ++i) {
                const glm::vec2 u = draw(kind, {i % shared::kBlueNoiseSize, i / shared::kBlueNoiseSize}, 17, 0, dimension);
                ++seen[static_cast<size_t>(u.x * 16) * 16 + static_cast<size_t>(u.y * 16)];
            }
            const testing::ChiSquare test = testing::chi_square_test(seen, std::vector<double>(256, kPixels / 256.0));
            EXPECT_GE(test.p, testing::sidak(0.01, 20)) << "kind " << kind << ", dimension " << dimension << ": " << test.text;
        }
}

// All numbers of a block of pixels x samples in one coordinate.
std::vector<float> gather(uint32_t kind, glm::uvec2 corner, uint32_t seed, uint32_t dimension, bool second = false) {
    std::vector<float> out;
    for (uint32_t y = 0; y < 64; ++y)
        for (uint32_t x = 0; x < 64; ++x)
            for (uint32_t i = 0; i < 64; ++i) {
                const glm::vec2 u = draw(kind, corner + glm::uvec2(x, y), i, seed, dimension);
                out.push_back(second ? u.y : u.x);
            }
    return out;
}

// 2^18 pairs: the estimate's standard deviation is at most 0.002, so 0.01 is five of them (false alarms 6e-7 each).
TEST(Sampler, dimensions_are_uncorrelated_within_pixels) {
    for (const uint32_t kind : kKinds)
        for (const uint32_t dimension : {0u, 12u}) {
            const std::vector<float> x = gather(kind, {0, 0}, 0, dimension);
            EXPECT_LE(std::abs(correlation<float>(x, gather(kind, {0, 0}, 0, dimension, true))), 0.01) << "kind " << kind << " within pair " << dimension;
            EXPECT_LE(std::abs(correlation<float>(x, gather(kind, {0, 0}, 0, dimension + 2))), 0.01) << "kind " << kind << " after pair " << dimension;
            EXPECT_LE(std::abs(correlation<float>(x, gather(kind, {0, 0}, 0, dimension + 16))), 0.01) << "kind " << kind << " a bounce later";
        }
}

TEST(Sampler, neighbouring_pixels_are_uncorrelated) {
    for (const uint32_t kind : {shared::kSamplerOwen, shared::kSamplerPcg, shared::kSamplerWhite})
        for (const uint32_t dimension : {0u, 12u}) {
            const std::vector<float> here = gather(kind, {0, 0}, 0, dimension);
            for (const glm::uvec2 step : {glm::uvec2(1, 0), glm::uvec2(0, 1), glm::uvec2(1, 1)})
                EXPECT_LE(std::abs(correlation<float>(here, gather(kind, step, 0, dimension))), 0.01) << "kind " << kind << ", step " << step.x << ' ' << step.y;
        }
}

// The blue shift makes neighbours differ on purpose; it must never make them alike.
TEST(Sampler, neighbouring_pixels_of_cranley_repel_each_other) {
    const std::vector<float> here = gather(shared::kSamplerCranley, {0, 0}, 0, 0);
    for (const glm::uvec2 step : {glm::uvec2(1, 0), glm::uvec2(0, 1)})
        EXPECT_LT(correlation<float>(here, gather(shared::kSamplerCranley, step, 0, 0)), -0.1);
}

// One sample a pixel: means of 8x8 pixels of a blue image vary much less than white noise's, whose variance is 1 / (12 x 64).
TEST(Sampler, one_sample_of_cranley_is_blue_over_the_image) {
    for (const uint32_t dimension : {0u, 1u, 20u}) {
        double sum = 0;
        for (uint32_t block = 0; block < 256; ++block) {
            double mean = 0;
            for (uint32_t i = 0; i < 64; ++i)
                mean += draw(shared::kSamplerCranley, {block % 16 * 8 + i % 8, block / 16 * 8 + i / 8}, 0, 0, dimension).x / 64.0;
            sum += (mean - 0.5) * (mean - 0.5) / 256.0;
        }
        EXPECT_LT(sum, 0.25 / (12.0 * 64.0)) << "dimension " << dimension;
    }
}

TEST(Sampler, seeds_are_independent) {
    for (const uint32_t kind : {shared::kSamplerOwen, shared::kSamplerPcg, shared::kSamplerWhite})
        EXPECT_LE(std::abs(correlation<float>(gather(kind, {0, 0}, 0, 0), gather(kind, {0, 0}, 1, 0))), 0.01) << "kind " << kind;
}

// No two dimensions of a pixel see the same sequence, and none is that of another seed or a neighbour.
TEST(Sampler, no_two_dimensions_pixels_or_seeds_share_a_sequence) {
    for (const uint32_t kind : kKinds) {
        std::set<std::array<float, 4>> seen;
        size_t count = 0;
        for (uint32_t seed = 0; seed < 2; ++seed)
            for (uint32_t pixel = 0; pixel < 16; ++pixel)
                for (uint32_t dimension = 0; dimension < 256; ++dimension, ++count) {
                    std::array<float, 4> sequence;
                    for (uint32_t i = 0; i < 4; ++i) sequence[i] = draw(kind, {pixel % 4, pixel / 4}, i, seed, dimension).x;
                    seen.insert(sequence);
                }
        EXPECT_EQ(seen.size(), count) << "kind " << kind;
    }
}

// Resets of cranley: in each dimension an aligned run of eight seeds takes golden-ratio steps (in some order), so that no gap is
// wider than the 0.2361 that eight such steps leave; between dimensions the orders are unrelated.
TEST(Sampler, seeds_of_cranley_take_golden_ratio_steps_in_an_order_of_each_dimension) {
    const auto sobol_shift = [](uint32_t seed, uint32_t dimension) {
        PathSampler s = make_sampler({11, 12}, 0, seed, shared::kSamplerCranley);
        // Without the hashed low bits, which differ by seed.
        return shared::draw_cranley(s, dimension) >> (32 - shared::kBlueNoiseRankBits);
    };
    std::vector<double> first, second;
    for (uint32_t run = 0; run < 64; ++run) {
        std::vector<double> shift;
        for (uint32_t i = 0; i < 8; ++i) {
            shift.push_back(sobol_shift(8 * run + i, 5) * 0x1p-14);
            first.push_back(shift.back());
            second.push_back(sobol_shift(8 * run + i, 6) * 0x1p-14);
        }
        std::sort(shift.begin(), shift.end());
        double gap = 1.0 - shift.back() + shift.front();
        for (size_t i = 1; i < shift.size(); ++i) gap = std::max(gap, shift[i] - shift[i - 1]);
        EXPECT_LT(gap, 0.2361 + 0.001) << "seeds from " << 8 * run;
    }
    // 512 pairs, each dimension stratified in runs: the standard deviation is at most 0.044, false alarms 6e-5.
    EXPECT_LT(std::abs(correlation<double>(first, second)), 0.177);
}

TEST(Sampler, every_key_of_an_alpha_test_counts) {
    const uint32_t ray = shared::hash_ray({3, 4}, 5, 6, 7, 0);
    const std::set<uint32_t> rays{ray, shared::hash_ray({4, 3}, 5, 6, 7, 0), shared::hash_ray({4, 4}, 5, 6, 7, 0), shared::hash_ray({3, 5}, 5, 6, 7, 0),
                                  shared::hash_ray({3, 4}, 6, 6, 7, 0), shared::hash_ray({3, 4}, 5, 7, 7, 0), shared::hash_ray({3, 4}, 5, 6, 8, 0),
                                  shared::hash_ray({3, 4}, 5, 6, 7, 1)};
    EXPECT_EQ(rays.size(), 8u);
    const std::set<float> surfaces{shared::hash_alpha(ray, 1, 2, 3), shared::hash_alpha(ray, 2, 2, 3), shared::hash_alpha(ray, 1, 1, 3),
                                   shared::hash_alpha(ray, 1, 2, 4), shared::hash_alpha(ray, 3, 2, 1)};
    EXPECT_EQ(surfaces.size(), 5u);
    EXPECT_EQ(shared::hash_alpha(ray, 1, 2, 3), shared::hash_alpha(ray, 1, 2, 3));
}

// Two panes of alpha 0.3 let (1 - 0.3)^2 through: stacked instances or triangles for one ray; one pane for the camera ray and the
// shadow ray of a pixel's sample, for the rays of two bounces, of two samples, of neighbouring pixels. 2^18 trials each see a bias
// of 0.5 % (five standard deviations: 6e-7 each), and a correlation of the numbers themselves of 0.01 (as many).
TEST(Sampler, alpha_tests_of_two_surfaces_or_two_rays_are_independent) {
    struct Asked {
        glm::uvec2 pixel;
        uint32_t sample = 0, bounce = 0, kind = 0, instance = 0, primitive = 9;
        float number() const { return shared::hash_alpha(shared::hash_ray(pixel, sample, 0, bounce, kind), instance, 0, primitive); }
    };
    const std::pair<const char*, std::function<void(Asked&)>> pairs[] = {{"instances", [](Asked& a) { a.instance = 1; }},
                                                                         {"triangles", [](Asked& a) { a.primitive = 8; }},
                                                                         {"camera and shadow ray", [](Asked& a) { a.kind = 1; }},
                                                                         {"bounces", [](Asked& a) { a.bounce = 1; }},
                                                                         {"bounces far apart", [](Asked& a) { a.bounce = 4; }},
                                                                         {"shadow ray and the next bounce's path", [](Asked& a) { a.bounce = 1, a.kind = 1; }},
                                                                         {"samples", [](Asked& a) { a.sample += 1; }},
                                                                         {"pixels", [](Asked& a) { a.pixel.x += 1; }}};
    constexpr int kTrials = 1 << 18;
    for (const auto& [what, change] : pairs) {
        int both = 0;
        std::vector<float> first, second;
        for (uint32_t i = 0; i < kTrials; ++i) {
            const Asked one{.pixel = {i % 512, i / 512 % 16}, .sample = i / 8192};
            Asked other = one;
            change(other);
            first.push_back(one.number()), second.push_back(other.number());
            both += first.back() >= 0.3f && second.back() >= 0.3f;
        }
        EXPECT_NEAR(both / double(kTrials), 0.49, 0.005) << what;
        EXPECT_LT(std::abs(correlation(first, second)), 0.01) << what;
    }
}

}  // namespace
}  // namespace parhelion::sampler_test
