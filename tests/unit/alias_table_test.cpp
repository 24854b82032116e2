// Alias tables: the rows against the weights, and the device's drawing function (compiled as C++) against the rows. A9.
#include "sampling/alias_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "base/error.h"
#include "lib/alias.glsl"
#include "support/statistics.h"

namespace parhelion::alias_table_test {
namespace {

using sampling::AliasTable;

struct WeightSet {
    std::string name;
    std::vector<double> weights;
};

std::vector<WeightSet> weight_sets() {
    std::mt19937 random(7);
    std::vector<WeightSet> sets{{"one", {3.0}},
                                {"equal", std::vector<double>(37, 0.25)},
                                {"a sun of two texels", {1e5, 1.0}},
                                {"zeros around one", {0, 0, 5, 0}},
                                {"tiny, huge and zero", {1e-300, 1e300, 0, 1e-20, 1e299, 1e300}},
                                {"denormal", {5e-324, 5e-324, 1e-323}}};
    WeightSet sky{"sky with a sun", std::vector<double>(512)};
    for (double& w : sky.weights) w = 0.5 + std::generate_canonical<double, 32>(random);
    sky.weights[300] = 1e5;
    sets.push_back(sky);
    WeightSet lamps{"lamps of forty stops", std::vector<double>(1000)};
    for (double& w : lamps.weights) w = std::exp2(static_cast<double>(random() % 40)) * static_cast<double>(random() % 4);
    sets.push_back(lamps);
    return sets;
}

// What the rows yield, added up in units of 2^-24 / rows, all whole numbers.
std::vector<double> enumerate_units(const AliasTable& table) {
    std::vector<double> units(table.entries().size(), 0.0);
    for (size_t i = 0; i < units.size(); ++i) {
        const double own = static_cast<double>(table.entries()[i].probability) * 0x1p24;
        EXPECT_EQ(own, std::floor(own)) << "row " << i << " has a probability that random numbers cannot tell";
        units[i] += own;
        units[table.entries()[i].alias] += 0x1p24 - own;
    }
    return units;
}

std::vector<shared::AliasEntry> device_rows(const AliasTable& table) {
    std::vector<shared::AliasEntry> rows;
    for (size_t i = 0; i < table.entries().size(); ++i) rows.push_back({table.entries()[i].probability, table.entries()[i].alias, table.pmf()[i]});
    return rows;
}
uint32_t draw(const std::vector<shared::AliasEntry>& rows, glm::vec2 u) {
    return shared::sample_alias(reinterpret_cast<uint64_t>(rows.data()), static_cast<uint32_t>(rows.size()), u);
}
glm::vec2 split(uint64_t bits48) { return {static_cast<float>(bits48 >> 24) * 0x1p-24f, static_cast<float>(bits48 & 0xFFFFFF) * 0x1p-24f}; }

TEST(AliasTable, pmf_is_what_the_rows_yield_and_sums_to_one) {
    for (const WeightSet& set : weight_sets()) {
        SCOPED_TRACE(set.name);
        const AliasTable table(set.weights);
        const std::vector<double> units = enumerate_units(table);
        const auto count = static_cast<double>(units.size());
        EXPECT_EQ(std::accumulate(units.begin(), units.end(), 0.0), count * 0x1p24);
        double sum = 0;
        for (size_t i = 0; i < units.size(); ++i) {
            EXPECT_EQ(table.pmf()[i], static_cast<float>(units[i] / 0x1p24 / count)) << "index " << i;
            sum += table.pmf()[i];
        }
        EXPECT_NEAR(sum, 1.0, 1e-6);
    }
}

TEST(AliasTable, pmf_follows_the_weights_and_zero_weights_are_never_drawn) {
    for (const WeightSet& set : weight_sets()) {
        SCOPED_TRACE(set.name);
        const AliasTable table(set.weights);
        const double largest = *std::max_element(set.weights.begin(), set.weights.end());
        double sum = 0;
        for (const double w : set.weights) sum += w / largest;
        const auto count = static_cast<double>(set.weights.size());
        for (size_t i = 0; i < set.weights.size(); ++i) {
            // Rounding moves a row by 2^-24 of a row, and a donor by that of all rows that it fills.
            EXPECT_NEAR(table.pmf()[i], set.weights[i] / largest / sum, 0x1p-24 + table.pmf()[i] * 2e-7) << "index " << i;
            if (set.weights[i] == 0) {
                EXPECT_EQ(table.pmf()[i], 0.0f) << "index " << i;
            } else {
                EXPECT_GE(table.pmf()[i], 0x1p-24 / count * 0.999999) << "index " << i;
            }
        }
    }
}

// False alarms: 1 % over all sets (the seed is fixed).
TEST(AliasTable, draws_follow_the_pmf) {
    const std::vector<WeightSet> sets = weight_sets();
    for (const WeightSet& set : sets) {
        SCOPED_TRACE(set.name);
        const AliasTable table(set.weights);
        const std::vector<shared::AliasEntry> rows = device_rows(table);
        std::mt19937 random(11);
        constexpr int kDraws = 1 << 20;
        std::vector<double> seen(rows.size(), 0);
        for (int i = 0; i < kDraws; ++i) ++seen.at(draw(rows, {static_cast<float>(random() >> 8) * 0x1p-24f, static_cast<float>(random() >> 8) * 0x1p-24f}));
        std::vector<double> expected;
        for (size_t i = 0; i < rows.size(); ++i) {
            expected.push_back(static_cast<double>(rows[i].pmf) * kDraws);
            if (rows[i].pmf == 0) {
                EXPECT_EQ(seen[i], 0) << "index " << i;
            }
        }
        if (std::count_if(expected.begin(), expected.end(), [](double e) { return e > 0; }) < 2) continue;  // one possible index: checked above
        const testing::ChiSquare test = testing::chi_square_test(seen, expected);
        EXPECT_GE(test.p, testing::sidak(0.01, sets.size())) << test.text;
    }
}

// Walks the 48-bit number through every edge of every row: exact to the last bit, whatever the number of rows.
TEST(AliasTable, the_drawing_function_changes_index_exactly_at_the_thresholds) {
    for (const WeightSet& set : weight_sets()) {
        SCOPED_TRACE(set.name);
        const std::vector<shared::AliasEntry> rows = device_rows(AliasTable(set.weights));
        const uint64_t count = rows.size();
        // Least 48-bit number whose product with the count reaches `position` rows of 2^24 units.
        const auto first_at = [&](uint64_t position) { return ((position << 24) + count - 1) / count; };
        for (uint64_t i = 0; i < count; ++i) {
            const auto own = static_cast<uint64_t>(rows[i].probability * 0x1p24f);
            if (own > 0) {
                EXPECT_EQ(draw(rows, split(first_at(i << 24))), i);
                EXPECT_EQ(draw(rows, split(first_at((i << 24) + own) - 1)), i);
            }
            if (own < 0x1000000) {
                EXPECT_EQ(draw(rows, split(first_at((i << 24) + own))), rows[i].alias);
                EXPECT_EQ(draw(rows, split(first_at((i + 1) << 24) - 1)), rows[i].alias);
            }
        }
    }
}

TEST(AliasTable, large_tables_keep_every_positive_weight) {
    std::mt19937 random(3);
    std::vector<double> weights(1000000);
    for (double& w : weights) w = std::exp2(-static_cast<double>(random() % 60));
    const AliasTable table(weights);
    double sum = 0;
    const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
    for (size_t i = 0; i < weights.size(); ++i) {
        ASSERT_GT(table.pmf()[i], 0.0f);
        if (weights[i] == 1.0) {
            ASSERT_NEAR(table.pmf()[i] * total, 1.0, 2e-3);
        }
        sum += table.pmf()[i];
    }
    EXPECT_NEAR(sum, 1.0, 1e-6);
    const std::vector<shared::AliasEntry> rows = device_rows(table);
    EXPECT_LT(draw(rows, split((1ull << 48) - 1)), weights.size());
}

TEST(AliasTable, nothing_to_draw_makes_an_empty_table) {
    EXPECT_TRUE(AliasTable(std::vector<double>{}).empty());
    EXPECT_TRUE(AliasTable(std::vector<double>{0.0, 0.0}).empty());
}

TEST(AliasTable, a_weight_that_is_no_weight_is_named) {
    for (const double bad : {-1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
        try {
            AliasTable(std::vector<double>{1.0, 2.0, bad}, "lamp.hdr");
            FAIL() << bad << " was taken";
        } catch (const Error& error) {
            EXPECT_NE(error.line.find("lamp.hdr"), std::string::npos) << error.line;
            EXPECT_NE(error.line.find("weight 2"), std::string::npos) << error.line;
        }
    }
}

}  // namespace
}  // namespace parhelion::alias_table_test
