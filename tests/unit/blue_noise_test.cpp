// The blue-noise tile: every rank once, no low frequencies, the same on every machine.
#include "sampling/blue_noise.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "base/hash.h"
#include "lib/sampler.glsl"

namespace parhelion::blue_noise_test {
namespace {

constexpr uint32_t kSize = shared::kBlueNoiseSize;

std::vector<uint32_t> tile_ranks() {
    std::vector<uint32_t> ranks;
    for (const uint32_t word : sampling::blue_noise_words()) ranks.insert(ranks.end(), {word & 0xFFFFu, word >> 16});
    return ranks;
}

// Mean power at each whole distance from zero frequency (in cycles a tile), relative to white noise of the same variance.
std::vector<double> radial_power(const std::vector<double>& values) {
    using Complex = std::complex<double>;
    std::vector<Complex> turn(kSize), rows(kSize * kSize), spectrum(kSize * kSize);
    for (uint32_t i = 0; i < kSize; ++i) turn[i] = std::polar(1.0, -2 * std::numbers::pi * i / kSize);
    for (uint32_t y = 0; y < kSize; ++y)
        for (uint32_t k = 0; k < kSize; ++k)
            for (uint32_t x = 0; x < kSize; ++x) rows[y * kSize + k] += turn[k * x % kSize] * values[y * kSize + x];
    for (uint32_t l = 0; l < kSize; ++l)
        for (uint32_t y = 0; y < kSize; ++y)
            for (uint32_t k = 0; k < kSize; ++k) spectrum[l * kSize + k] += turn[l * y % kSize] * rows[y * kSize + k];
    std::vector<double> power(kSize / 2, 0.0), count(kSize / 2, 0.0);
    const double white = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
    for (uint32_t i = 0; i < kSize * kSize; ++i) {
        const auto centred = [](uint32_t k) { return k < kSize / 2 ? double(k) : double(k) - kSize; };
        const auto radius = static_cast<size_t>(std::lround(std::hypot(centred(i % kSize), centred(i / kSize))));
        if (radius >= power.size()) continue;
        power[radius] += std::norm(spectrum[i]) / white;
        count[radius] += 1;
    }
    for (size_t r = 0; r < power.size(); ++r) power[r] /= count[r];
    return power;
}

TEST(BlueNoise, every_rank_occurs_once) {
    std::vector<uint32_t> ranks = tile_ranks();
    ASSERT_EQ(ranks.size(), kSize * kSize);
    std::sort(ranks.begin(), ranks.end());
    for (uint32_t i = 0; i < kSize * kSize; ++i) ASSERT_EQ(ranks[i], i);
}

TEST(BlueNoise, the_shader_function_finds_the_ranks_in_row_order_and_repeats_them) {
    const std::vector<uint32_t> ranks = tile_ranks();
    const auto address = reinterpret_cast<uint64_t>(sampling::blue_noise_words().data());
    for (uint32_t i = 0; i < kSize * kSize; ++i) {
        const glm::uvec2 pixel(i % kSize, i / kSize);
        ASSERT_EQ(shared::blue_noise_rank(address, pixel, 0), ranks[i]);
        ASSERT_EQ(shared::blue_noise_rank(address, pixel + 5 * kSize, 0), ranks[i]);
    }
}

// Pictures made with the tile must not change with the compiler or the maths library.
TEST(BlueNoise, the_tile_is_the_same_everywhere) {
    const std::vector<uint32_t>& words = sampling::blue_noise_words();
    EXPECT_EQ(hash_bytes(words.data(), words.size() * sizeof(uint32_t)), 137931321425431163ull);
}

TEST(BlueNoise, seeds_make_different_tiles) { EXPECT_NE(sampling::make_blue_noise(32, 1), sampling::make_blue_noise(32, 2)); }

TEST(BlueNoise, low_frequencies_are_missing) {
    std::vector<double> values;
    for (const uint32_t rank : tile_ranks()) values.push_back((rank + 0.5) / (kSize * kSize) - 0.5);
    const std::vector<double> power = radial_power(values);
    for (size_t r = 0; r < 24; ++r) EXPECT_LT(power[r], 0.01) << "frequency " << r << " of 64";
    for (size_t r = 24; r < 32; ++r) EXPECT_LT(power[r], 0.1) << "frequency " << r << " of 64";
    EXPECT_GT(*std::max_element(power.begin() + 44, power.end()), 1.0);
    // No direction or frequency stands out, as in ordered dither.
    EXPECT_LT(*std::max_element(power.begin(), power.end()), 2.5);
}

// The first ranks alone are evenly spread points. Of 256 on this tile the nearest two are 8.6 pixels apart in the best case, a
// hexagonal lattice, and 1 apart at random.
TEST(BlueNoise, the_first_ranks_lie_apart) {
    const std::vector<uint32_t> ranks = tile_ranks();
    std::vector<glm::ivec2> first;
    for (uint32_t i = 0; i < ranks.size(); ++i)
        if (ranks[i] < 256) first.emplace_back(i % kSize, i / kSize);
    for (size_t a = 0; a < first.size(); ++a)
        for (size_t b = 0; b < a; ++b) {
            const glm::ivec2 d = glm::abs(first[a] - first[b]), t = glm::min(d, glm::ivec2(kSize) - d);
            EXPECT_GE(t.x * t.x + t.y * t.y, 25);
        }
}

}  // namespace
}  // namespace parhelion::blue_noise_test
