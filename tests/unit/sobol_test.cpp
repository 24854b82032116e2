// The Sobol table and Owen's scrambling: structure, not statistics, except where it says so.
#include "sampling/sobol.h"

#include <set>

#include <gtest/gtest.h>

#include "lib/hash.glsl"
#include "lib/sobol.glsl"

namespace parhelion::sobol_test {
namespace {

using shared::kSobolDimensions;

uint32_t point(uint32_t index, uint32_t dimension) { return shared::sobol(reinterpret_cast<uint64_t>(sampling::sobol_table().data()), index, dimension); }

// Do 2^m points put 2^t into each of the elementary intervals of area 2^(t - m), whatever their shape?
bool is_net(const std::vector<glm::uvec2>& points, uint32_t m, uint32_t t) {
    for (uint32_t a = 0; a <= m - t; ++a) {
        const uint32_t b = m - t - a;
        std::vector<uint32_t> count(size_t{1} << (m - t), 0);
        for (const glm::uvec2& p : points) ++count[((uint64_t{p.x} >> (32 - a)) << b) | (uint64_t{p.y} >> (32 - b))];
        for (const uint32_t c : count)
            if (c != (1u << t)) return false;
    }
    return true;
}

std::vector<glm::uvec2> first_points(uint32_t m, uint32_t dimension_x, uint32_t dimension_y) {
    std::vector<glm::uvec2> points;
    for (uint32_t i = 0; i < (1u << m); ++i) points.emplace_back(point(i, dimension_x), point(i, dimension_y));
    return points;
}

TEST(Sobol, dimensions_have_different_polynomials_and_allowed_initial_numbers) {
    std::set<uint32_t> seen;
    for (const sampling::SobolDimension& d : sampling::kSobolData) {
        EXPECT_TRUE(seen.insert(d.polynomial).second) << "polynomial " << d.polynomial << " twice";
        const int degree = std::bit_width(d.polynomial) - 1;
        for (int k = 0; k < degree; ++k) {
            EXPECT_EQ(d.initial[k] & 1u, 1u);
            EXPECT_LT(d.initial[k], 2u << k);
        }
    }
}

// The recurrence runs through all its states just if the polynomial is primitive: the direction numbers' first bits have full period.
TEST(Sobol, polynomials_are_primitive) {
    for (size_t i = 1; i < sampling::kSobolData.size(); ++i) {
        const uint32_t p = sampling::kSobolData[i].polynomial;
        const int degree = std::bit_width(p) - 1;
        uint32_t x = 1, period = 0;
        do {
            x <<= 1;
            if (x >> degree) x ^= p;
            ++period;
        } while (x != 1 && period < (1u << degree));
        EXPECT_EQ(period, (1u << degree) - 1) << "dimension " << i;
    }
}

// Each direction number ends at its own bit: any 2^m consecutive points hit each of 2^m intervals once, up to m = 32.
TEST(Sobol, every_dimension_is_stratified_for_any_number_of_points) {
    for (uint32_t d = 0; d < kSobolDimensions; ++d)
        for (uint32_t k = 0; k < 32; ++k) {
            const uint32_t v = sampling::sobol_table()[32 * d + k];
            EXPECT_EQ(v & ((2u << (31 - k)) - 1u), 1u << (31 - k)) << "dimension " << d << ", bit " << k;
        }
}

TEST(Sobol, the_first_two_dimensions_are_a_0_2_sequence) {
    for (uint32_t m = 0; m <= 12; ++m) EXPECT_TRUE(is_net(first_points(m, 0, 1), m, 0)) << "2^" << m << " points";
}

TEST(Sobol, neighbouring_dimensions_are_good_nets_of_1024_points) {
    uint32_t worst = 0;
    double sum = 0;
    for (uint32_t d = 1; d < kSobolDimensions; ++d) {
        const std::vector<glm::uvec2> points = first_points(10, d - 1, d);
        uint32_t t = 0;
        while (!is_net(points, 10, t)) ++t;
        worst = std::max(worst, t);
        sum += t;
    }
    EXPECT_LE(worst, 4u);
    EXPECT_LE(sum / (kSobolDimensions - 1), 1.75);
}

TEST(Sobol, eight_neighbouring_dimensions_put_one_of_256_points_into_each_orthant) {
    for (uint32_t first = 0; first + 8 <= kSobolDimensions; ++first) {
        std::set<uint32_t> orthants;
        for (uint32_t i = 0; i < 256; ++i) {
            uint32_t orthant = 0;
            for (uint32_t d = 0; d < 8; ++d) orthant = 2 * orthant + (point(i, first + d) >> 31);
            orthants.insert(orthant);
        }
        EXPECT_EQ(orthants.size(), 256u) << "dimensions from " << first;
    }
}

TEST(Sobol, the_butterfly_of_the_second_dimension_equals_the_table) {
    for (uint32_t i = 0; i < 4096; ++i) {
        const uint32_t index = i < 2048 ? i : shared::pcg_hash(i);
        EXPECT_EQ(shared::bitfieldReverse(index), point(index, 0));
        EXPECT_EQ(shared::bitfieldReverse(shared::sobol_second_reversed(index)), point(index, 1));
    }
}

// Owen's scrambling: numbers that share k leading bits share k after it too, and the next bit differs.
TEST(OwenScrambling, keeps_common_prefixes) {
    for (uint32_t i = 0; i < 2000; ++i) {
        const uint32_t a = shared::pcg_hash(i), seed = shared::pcg_hash(i + 5000), bit = i % 32;
        const uint32_t below = (1u << bit) - 1u;
        const uint32_t b = (a ^ (1u << bit)) ^ (shared::pcg_hash(i + 9000) & below);
        const uint32_t difference = shared::nested_uniform_scramble(a, seed) ^ shared::nested_uniform_scramble(b, seed);
        EXPECT_EQ(difference >> bit, 1u);
    }
}

// Each bit flips with probability one half over seeds, given any higher bits: 32 bits x 8 numbers at 4096 seeds. One count is
// off by 5.2 sigma with probability 2e-7, any of the 256 with 5e-5.
TEST(OwenScrambling, flips_every_bit_half_the_time) {
    for (uint32_t number = 0; number < 8; ++number) {
        const uint32_t v = shared::pcg_hash(number + 77);
        std::vector<int> flips(32, 0);
        for (uint32_t seed = 0; seed < 4096; ++seed) {
            const uint32_t changed = v ^ shared::nested_uniform_scramble(v, shared::pcg_hash(seed));
            for (uint32_t bit = 0; bit < 32; ++bit) flips[bit] += (changed >> bit) & 1u;
        }
        for (uint32_t bit = 0; bit < 32; ++bit) EXPECT_NEAR(flips[bit], 2048, 5.2 * 32) << "bit " << bit << " of " << v;
    }
}

}  // namespace
}  // namespace parhelion::sobol_test
