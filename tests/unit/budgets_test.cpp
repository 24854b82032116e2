// The bounds that budgets are judged on hold as often as they say.
#include "support/budgets.h"

#include <random>

#include <gtest/gtest.h>

namespace parhelion::testing::budgets_test {
namespace {

constexpr int kTrials = 2000;

// Passed by the truth 1 % of the time: 20 of 2000, and between 5 and 40 but for one case in ten thousand.
void expect_one_in_a_hundred(int outside) {
    EXPECT_GE(outside, 5);
    EXPECT_LE(outside, 40);
}

TEST(Budgets, the_true_ratio_passes_each_bound_once_in_a_hundred_times) {
    std::mt19937_64 rng(1);
    std::normal_distribution<double> normal;
    int above = 0, below = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        std::vector<double> test, reference;
        for (int i = 0; i < 16; ++i) test.push_back(3.0 + 0.3 * normal(rng)), reference.push_back(2.0 + 0.1 * normal(rng));
        const Ratio ratio = ratio_of_means(test, reference);
        above += ratio.upper() < 1.5;
        below += ratio.lower() > 1.5;
    }
    expect_one_in_a_hundred(above);
    expect_one_in_a_hundred(below);
}

TEST(Budgets, what_pairs_have_in_common_does_not_widen_their_ratio) {
    std::mt19937_64 rng(2);
    std::normal_distribution<double> normal;
    int above = 0, below = 0;
    double widest = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        std::vector<double> test, reference;
        for (int i = 0; i < 64; ++i) {
            const double common = 1.0 + 0.2 * normal(rng);
            test.push_back(0.9 * common * (1.0 + 0.001 * normal(rng)));
            reference.push_back(common);
        }
        const Ratio ratio = paired_ratio(test, reference);
        widest = std::max(widest, ratio.upper() - ratio.lower());
        above += ratio.upper() < 0.9;
        below += ratio.lower() > 0.9;
    }
    expect_one_in_a_hundred(above);
    expect_one_in_a_hundred(below);
    EXPECT_LE(widest, 0.002);
}

TEST(Budgets, a_tenth_of_the_tiles_that_is_wrong_shows_in_their_quantile) {
    std::mt19937_64 rng(3);
    std::normal_distribution<float> normal;
    const auto runs = [&](float error) {
        Runs out(64, 64);
        for (int run = 0; run < 32; ++run) {
            std::vector<float> values(64 * 64);
            for (size_t p = 0; p < values.size(); ++p) values[p] = (p < 8 * 64 ? 1.0f + error : 1.0f) * (1.0f + 0.2f * normal(rng));
            out.add_run(values);
        }
        return out;
    };
    const Runs reference = runs(0.0f);
    const Ratio equal = tile_quantile(runs(0.0f), reference, 0.95), wrong = tile_quantile(runs(0.10f), reference, 0.95);
    EXPECT_LE(equal.upper(), 0.03);
    EXPECT_NEAR(wrong.value, 0.10, 0.02);
    EXPECT_GE(wrong.upper(), 0.10);
    EXPECT_LE(wrong.error, 0.02);
}

}  // namespace
}  // namespace parhelion::testing::budgets_test
