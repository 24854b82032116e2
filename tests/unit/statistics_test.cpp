// The proof library itself: values against tables, and for every test a true and a false case with its power.
#include "support/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace parhelion::testing::statistics_test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A renderer: the mean grows to the right, tile by tile; a run of it has independent noise of `noise` x mean in each tile, and all
// of a run is wrong by a common factor of deviation `drift`. `bias` scales the first `biased_columns` of tiles.
struct Renderer {
    uint32_t width = 64, height = 64;
    double noise = 0.04, drift = 0.0, bias = 1.0;
    uint32_t biased_columns = 0;

    Runs render(uint32_t runs, std::mt19937_64& rng) const {
        Runs out(width, height);
        std::vector<float> values(size_t{width} * height);
        std::normal_distribution<double> normal;
        for (uint32_t run = 0; run < runs; ++run) {
            const double factor = 1.0 + drift * normal(rng);
            for (uint32_t y = 0; y < height; y += 8)
                for (uint32_t x = 0; x < width; x += 8) {
                    const double mean = (0.2 + static_cast<double>(x) / width) * (x / 8 < biased_columns ? bias : 1.0);
                    const auto value = static_cast<float>(mean * factor * (1.0 + noise * normal(rng)));
                    for (uint32_t row = y; row < y + 8; ++row) std::fill_n(values.begin() + row * width + x, 8, value);
                }
            out.add_run(values);
        }
        return out;
    }
};

struct Outcomes {
    int passed = 0, mean_passed = 0, tiles_passed = 0;
};
Outcomes repeat(int trials, const Renderer& test, const Renderer& reference, double margin, uint64_t seed, uint32_t runs = 32) {
    std::mt19937_64 rng(seed);
    Outcomes out;
    for (int i = 0; i < trials; ++i) {
        const Equivalence e = equivalence_test(test.render(runs, rng), reference.render(2 * runs, rng), margin);
        out.passed += e.passed;
        out.mean_passed += e.mean_passed;
        out.tiles_passed += e.tiles_passed;
    }
    return out;
}

}  // namespace

TEST(Statistics, distributions_match_their_tables) {
    EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-12);
    EXPECT_NEAR(normal_cdf(-5.0), 2.866515718791939e-07, 1e-18);
    EXPECT_NEAR(t_quantile(0.975, 1), 12.706204736432095, 1e-8);
    EXPECT_NEAR(t_quantile(0.975, 10), 2.2281388519649385, 1e-10);
    EXPECT_NEAR(t_quantile(0.9995, 31), 3.6334563487, 1e-8);
    EXPECT_NEAR(t_quantile(0.025, 10), -2.2281388519649385, 1e-10);
    EXPECT_NEAR(t_quantile(0.975, kInfinity), 1.959963984540054, 1e-12);
    EXPECT_NEAR(t_quantile(0.975, 1e6), 1.9599663, 1e-5);
    EXPECT_NEAR(chi_square_survival(3.841458820694124, 1), 0.05, 1e-12);
    EXPECT_NEAR(chi_square_survival(18.307038053275146, 10), 0.05, 1e-12);
    EXPECT_NEAR(chi_square_survival(2.0, 10), 0.9963401531726563, 1e-12);
    EXPECT_NEAR(incomplete_beta(2, 3, 0.4), 0.5248, 1e-13);
    EXPECT_NEAR(upper_gamma(1, 2.5), std::exp(-2.5), 1e-14);
    EXPECT_NEAR(binomial_cdf(3, 10, 0.5), 176.0 / 1024.0, 1e-13);
    EXPECT_EQ(binomial_cdf(10, 10, 0.5), 1.0);
    EXPECT_NEAR(sidak(0.01, 1), 0.01, 1e-15);
    EXPECT_NEAR(sidak(1e-3, 1000000), 1.0005003e-9, 1e-15);
}

TEST(Statistics, the_tile_counts_are_those_of_the_design) {
    EXPECT_EQ(binomial_quantile(0.999, 64, 0.01), 4u);
    EXPECT_EQ(binomial_quantile(0.999, 220, 0.01), 8u);
    EXPECT_EQ(binomial_quantile(0.999, 576, 0.01), 14u);
}

TEST(Statistics, quantiles_invert_their_distributions) {
    for (const double p : {1e-9, 1e-4, 0.01, 0.3, 0.5, 0.9, 0.999}) {
        EXPECT_NEAR(normal_cdf(normal_quantile(p)) / p, 1.0, 1e-9);
        for (const double df : {1.0, 4.5, 31.0, 500.0}) EXPECT_NEAR(t_cdf(t_quantile(p, df), df) / p, 1.0, 1e-6) << p << ' ' << df;
    }
    EXPECT_THROW(normal_quantile(0.0), std::invalid_argument);
}

TEST(EquivalenceTest, gives_the_interval_of_a_hand_computed_case) {
    // 32 runs alternate between 0.9 and 1.1 around 1, the truth is 1.01.
    Runs test(8, 8), truth(8, 8);
    for (int i = 0; i < 32; ++i) test.add_run(std::vector<float>(64, i % 2 == 0 ? 0.9f : 1.1f));
    truth.add_run(std::vector<float>(64, 1.01f));
    const Equivalence e = equivalence_test_exact(test, truth, 0.1);
    const double half = 3.6334563487 * std::sqrt(0.01 * 32.0 / 31.0 / 32.0) / 1.01;
    EXPECT_NEAR(e.ratio, 1.0 / 1.01, 1e-6);
    EXPECT_NEAR(e.low, 1.0 / 1.01 - half, 1e-6);
    EXPECT_NEAR(e.high, 1.0 / 1.01 + half, 1e-6);
    EXPECT_EQ(e.reference_error, 0.0);
    EXPECT_TRUE(e.passed) << e.text;
    EXPECT_FALSE(equivalence_test_exact(test, truth, 0.07).mean_passed) << "0.99 - 0.065 is outside";
}

// Run means deviate by 0.55 %, so 32 runs know the mean to 0.1 %, and with the reference's 64 the interval is +-0.43 %.
TEST(EquivalenceTest, passes_equal_renderers) {
    const Outcomes o = repeat(100, {}, {}, 0.01, 1);
    EXPECT_EQ(o.mean_passed, 100);   // power: 0.57 % left for an error of 0.12 %
    EXPECT_GE(o.tiles_passed, 98);   // one false alarm in a thousand
}

TEST(EquivalenceTest, always_fails_a_bias_of_the_margin_and_of_one_per_cent_in_a_half_per_cent_margin) {
    EXPECT_EQ(repeat(100, {.bias = 1.01, .biased_columns = 8}, {}, 0.01, 2).mean_passed, 0);  // passes with probability 5e-4
    EXPECT_EQ(repeat(100, {.bias = 0.99, .biased_columns = 8}, {}, 0.005, 3).mean_passed, 0);
}

TEST(EquivalenceTest, passes_a_small_bias_inside_the_margin_by_its_mean) {
    EXPECT_GE(repeat(100, {.bias = 1.001, .biased_columns = 8}, {}, 0.01, 4).mean_passed, 97);
}

TEST(EquivalenceTest, fails_on_noise_instead_of_passing) {
    EXPECT_EQ(repeat(100, {.drift = 0.03}, {}, 0.01, 5).mean_passed, 0) << "0.5 % standard error cannot show 1 %";
    EXPECT_EQ(repeat(100, {}, {.drift = 0.03}, 0.01, 6).mean_passed, 0) << "the reference's own error is over a quarter of the margin";
}

TEST(EquivalenceTest, asks_for_a_reference_four_times_as_precise_as_the_margin) {
    // The reference's error is 0.27 of the margin: the interval alone, 3.45 of those, would still fit.
    Runs test(8, 8), reference(8, 8);
    for (int i = 0; i < 32; ++i) test.add_run(std::vector<float>(64, 1.0f));
    for (int i = 0; i < 64; ++i) reference.add_run(std::vector<float>(64, i % 2 == 0 ? 1.0216f : 0.9784f));
    const Equivalence e = equivalence_test(test, reference, 0.01);
    EXPECT_NEAR(e.reference_error, 0.0027, 0.00005);
    EXPECT_GT(e.low, 0.99);
    EXPECT_LT(e.high, 1.01);
    EXPECT_FALSE(e.mean_passed) << e.text;
    EXPECT_TRUE(equivalence_test(test, reference, 0.012).mean_passed);
}

TEST(EquivalenceTest, judges_every_lit_tile_by_the_count_of_the_design) {
    std::mt19937_64 rng(14);
    const Equivalence e = equivalence_test(Renderer{}.render(32, rng), Renderer{}.render(64, rng), 0.01);
    EXPECT_EQ(e.tiles, 64u);
    EXPECT_EQ(e.tiles_allowed, 4u);
}

TEST(EquivalenceTest, finds_a_local_bias_that_the_mean_hides) {
    // The darkest eighth of the picture is 5 % off, the mean by 0.2 %: 8 of 64 tiles, each known to 0.9 %.
    const Outcomes o = repeat(100, {.bias = 1.05, .biased_columns = 1}, {}, 0.01, 7);
    EXPECT_GE(o.mean_passed, 94);
    EXPECT_LE(o.tiles_passed, 1);  // power at least 0.99
}

TEST(EquivalenceTest, tiles_raise_no_more_false_alarms_than_stated) {
    // 400 trials at one in a thousand: more than 3 alarms have a probability of 1e-3. Small pictures, 4 tiles, 1 allowed to differ.
    const Outcomes o = repeat(400, {.width = 16, .height = 16}, {.width = 16, .height = 16}, 0.05, 8);
    EXPECT_GE(o.tiles_passed, 397);
}

TEST(EquivalenceTest, judges_no_dark_tile_and_forgives_rounding) {
    Runs test(16, 8), reference(16, 8);
    std::vector<float> values(128, 1.0f);
    for (size_t i = 0; i < 128; ++i)
        if (i % 16 >= 8) values[i] = 1e-4f;
    reference.add_run(values);
    reference.add_run(values);
    for (float& v : values) v = v > 0.5f ? 1.0000005f : 5e-4f;
    for (int i = 0; i < 32; ++i) test.add_run(values);
    const Equivalence e = equivalence_test(test, reference, 0.01);
    EXPECT_EQ(e.tiles, 1u);
    EXPECT_EQ(e.tiles_over, 0u);
}

TEST(EquivalenceTest, forgives_as_much_rounding_as_the_caller_says_that_there_is) {
    Runs test(8, 8), reference(8, 8);
    for (int i = 0; i < 32; ++i) {
        reference.add_run(std::vector<float>(64, 1.0f));
        test.add_run(std::vector<float>(64, 1.0f + 0x1p-15f));
    }
    EXPECT_EQ(equivalence_test(test, reference, 0.01).tiles_over, 1u);
    EXPECT_EQ(equivalence_test(test, reference, 0.01, 0x1p-15).tiles_over, 0u);
}

TEST(EquivalenceTest, refuses_too_few_runs_and_unusable_means) {
    std::mt19937_64 rng(9);
    const Renderer small{.width = 8, .height = 8};
    const Runs enough = small.render(32, rng);
    EXPECT_THROW(equivalence_test(small.render(31, rng), enough, 0.01), std::invalid_argument);
    EXPECT_THROW(equivalence_test(enough, small.render(1, rng), 0.01), std::invalid_argument);
    Runs black(8, 8), broken(8, 8);
    for (int i = 0; i < 32; ++i) black.add_run(std::vector<float>(64, 0.0f)), broken.add_run(std::vector<float>(64, NAN));
    EXPECT_THROW(equivalence_test(enough, black, 0.01), std::invalid_argument);
    EXPECT_THROW(equivalence_test(broken, enough, 0.01), std::invalid_argument);
}

namespace {

// Two noisy estimates of one image and the variances of both; `bias` is added to one pixel, in standard errors.
ZTest random_z_test(std::mt19937_64& rng, double bias, double alpha) {
    std::normal_distribution<double> normal;
    const size_t n = 4096;
    std::vector<float> a(n), b(n), va(n), vb(n);
    for (size_t i = 0; i < n; ++i) {
        const double sa = 0.1 + 0.001 * static_cast<double>(i % 100), sb = 0.2;
        va[i] = static_cast<float>(sa * sa);
        vb[i] = static_cast<float>(sb * sb);
        a[i] = static_cast<float>(5.0 + sa * normal(rng));
        b[i] = static_cast<float>(5.0 + sb * normal(rng));
    }
    a[1234] += static_cast<float>(bias * std::sqrt(va[1234] + vb[1234]));
    return z_test(a, va, b, vb, alpha);
}

}  // namespace

TEST(ZTest, keeps_its_false_alarm_rate_and_finds_one_wrong_pixel) {
    std::mt19937_64 rng(10);
    int alarms = 0, found = 0;
    for (int i = 0; i < 200; ++i) {
        alarms += !random_z_test(rng, 0.0, 0.05).passed;
        const ZTest wrong = random_z_test(rng, 8.0, 0.01);
        found += !wrong.passed && wrong.worst_index == 1234;
    }
    EXPECT_LE(alarms, 21);  // 200 at 5 %: 99.9 % quantile 21
    EXPECT_GE(alarms, 2);   // and 0.1 % quantile 2: Sidak's threshold is no stricter than said
    EXPECT_GE(found, 198);  // 8 standard errors against a threshold of 4.7: power 0.9995
}

TEST(ZTest, takes_the_degrees_of_freedom_of_estimated_variances_into_account) {
    const std::vector<float> a = {1.0f}, b = {2.0f}, v = {0.05f};
    EXPECT_NEAR(z_test(a, v, b, v, 0.01).worst_p, 2 * normal_cdf(-1.0 / std::sqrt(0.1)), 1e-7);
    EXPECT_NEAR(z_test(a, v, b, v, 0.01, 4).worst_p, 2 * t_cdf(-1.0 / std::sqrt(0.1), 8), 1e-7);
}

TEST(ZTest, gives_uniform_p_to_equal_means_of_few_runs_with_unequal_variances) {
    std::mt19937_64 rng(14);
    std::normal_distribution<double> normal;
    constexpr size_t kPixels = 4096, kFewRuns = 8;
    std::vector<float> mean[2], variance[2];
    for (size_t k = 0; k < 2; ++k)
        for (size_t i = 0; i < kPixels; ++i) {
            std::vector<double> runs(kFewRuns);
            for (double& run : runs) run = 5.0 + (k == 0 ? 0.1 : 0.4) * normal(rng);
            const Moments m = moments(runs);
            mean[k].push_back(static_cast<float>(m.mean));
            variance[k].push_back(static_cast<float>(m.variance / double(kFewRuns)));
        }
    const std::vector<double> p = z_test_p(mean[0], variance[0], mean[1], variance[1], kFewRuns - 1);
    EXPECT_GT(kolmogorov_smirnov_test(p, [](double x) { return x; }).p, 0.001);
    EXPECT_EQ(*std::min_element(p.begin(), p.end()), z_test(mean[0], variance[0], mean[1], variance[1], 0.01, kFewRuns - 1).worst_p);
    // As if the variances were known, p is not uniform: this test can fail.
    EXPECT_LT(kolmogorov_smirnov_test(z_test_p(mean[0], variance[0], mean[1], variance[1]), [](double x) { return x; }).p, 0.001);
}

TEST(ZTest, pixels_without_variance_must_be_equal) {
    const std::vector<float> zero(3, 0.0f), a = {0.0f, 1.0f, 2.0f};
    EXPECT_TRUE(z_test(a, zero, a, zero, 0.01).passed);
    EXPECT_TRUE(z_test(a, zero, std::vector<float>{0.0f, 1.0000005f, 2.0f}, zero, 0.01).passed) << "rounding";
    EXPECT_FALSE(z_test(a, zero, std::vector<float>{0.0f, 1.001f, 2.0f}, zero, 0.01).passed);
    EXPECT_FALSE(z_test(a, zero, std::vector<float>{1e-20f, 1.0f, 2.0f}, zero, 0.01).passed);
    EXPECT_FALSE(z_test(a, zero, std::vector<float>{0.0f, NAN, 2.0f}, zero, 0.01).passed);
}

TEST(ChiSquareTest, keeps_its_false_alarm_rate_and_finds_a_loaded_die) {
    std::mt19937_64 rng(11);
    int alarms = 0, found = 0;
    for (int i = 0; i < 400; ++i) {
        std::vector<double> fair(20), loaded(20), expected(20, 500.0);
        for (int throws = 0; throws < 10000; ++throws) {
            ++fair[rng() % 20];
            ++loaded[rng() % 50 == 0 ? 7 : rng() % 20];  // 2 % of the throws are forced
        }
        alarms += chi_square_test(fair, expected).p < 0.01;
        found += chi_square_test(loaded, expected).p < 0.01;
    }
    EXPECT_LE(alarms, 11);  // 400 at 1 %: 99.9 % quantile 11
    EXPECT_GE(found, 396);  // power above 0.99
}

TEST(ChiSquareTest, pools_rare_cells_and_forbids_impossible_ones) {
    const std::vector<double> counts = {1, 0, 2, 1, 1, 50, 45}, expected = {1, 1, 1, 1, 1, 48, 47};
    const ChiSquare test = chi_square_test(counts, expected);
    EXPECT_EQ(test.degrees_of_freedom, 2.0);
    EXPECT_NEAR(test.chi2, 0.0 + 4.0 / 48.0 + 4.0 / 47.0, 1e-12);
    const std::vector<double> impossible = {3, 50, 50}, never = {0, 51, 52};
    EXPECT_EQ(chi_square_test(impossible, never).p, 0.0);
    EXPECT_THROW(chi_square_test(std::vector<double>{3, 2}, std::vector<double>{2, 3}), std::invalid_argument);
}

TEST(KolmogorovSmirnovTest, keeps_its_false_alarm_rate_and_finds_a_bent_distribution) {
    std::mt19937_64 rng(12);
    std::uniform_real_distribution<double> uniform;
    const auto cdf = [](double x) { return x; };
    int alarms = 0, found = 0;
    for (int i = 0; i < 400; ++i) {
        std::vector<double> straight, bent;
        for (int k = 0; k < 2000; ++k) {
            straight.push_back(uniform(rng));
            bent.push_back(std::pow(uniform(rng), 1.2));
        }
        alarms += kolmogorov_smirnov_test(straight, cdf).p < 0.01;
        found += kolmogorov_smirnov_test(bent, cdf).p < 0.01;
    }
    EXPECT_LE(alarms, 11);
    EXPECT_GE(found, 396);
    EXPECT_EQ(kolmogorov_smirnov_test({0.25, 0.75}, cdf).distance, 0.25);
}

TEST(SlopeFit, recovers_a_line_and_its_error) {
    const std::vector<double> x = {1, 2, 3, 4}, y = {5, 7, 9, 11};
    const SlopeFit exact = fit_slope(x, y);
    EXPECT_NEAR(exact.slope, 2.0, 1e-12);
    EXPECT_NEAR(exact.intercept, 3.0, 1e-12);
    EXPECT_NEAR(exact.standard_error, 0.0, 1e-12);

    // The error over n independent samples falls with slope -1/2: errors with 10 % noise of their own.
    std::mt19937_64 rng(13);
    std::normal_distribution<double> normal;
    int inside = 0;
    for (int trial = 0; trial < 400; ++trial) {
        std::vector<double> n, error;
        for (double count = 4; count <= 4096; count *= 2) n.push_back(count), error.push_back(std::exp(0.1 * normal(rng)) / std::sqrt(count));
        const SlopeFit fit = fit_log_slope(n, error);
        inside += std::abs(fit.slope + 0.5) < t_quantile(0.995, 9) * fit.standard_error;
        ASSERT_NEAR(fit.slope, -0.5, 0.07);
    }
    EXPECT_GE(inside, 389);  // 400 at 1 %: 99.9 % quantile 11 outside
    EXPECT_THROW(fit_slope(std::vector<double>{1, 1, 1}, std::vector<double>{1, 2, 3}), std::invalid_argument);
}

}  // namespace parhelion::testing::statistics_test
