// The light of environments by cells, against sums over many directions.
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "image/image.h"
#include "scene/environment_flux.h"

namespace parhelion::environment_flux_test {
namespace {

constexpr double kPi = std::numbers::pi;

Environment random_map(uint32_t width, uint32_t height, uint32_t seed) {
    Environment e{.width = width, .height = height, .scale = glm::vec3(1.0f)};
    std::mt19937 random(seed);
    for (uint32_t i = 0; i < width * height; ++i) e.radiance.emplace_back(random() % 1000 * 0.001f, random() % 1000 * 0.002f, random() % 5 == 0 ? 40.0f : 0.0f);
    return e;
}

// Bilinear, round about in u, clamped in v.
double luminance_at(const Environment& e, double u, double v) {
    const double x = u * e.width - 0.5, y = v * e.height - 0.5, fx = x - std::floor(x), fy = y - std::floor(y);
    const auto texel = [&](double i, double k) {
        const auto w = int64_t(e.width), column = (int64_t(i) % w + w) % w, row = std::clamp<int64_t>(int64_t(k), 0, int64_t(e.height) - 1);
        const glm::dvec3 c(e.radiance[size_t(row * w + column)]);
        return image::luminance(c.r, c.g, c.b);
    };
    const double left = std::floor(x), top = std::floor(y);
    return (1 - fy) * ((1 - fx) * texel(left, top) + fx * texel(left + 1, top)) + fy * ((1 - fx) * texel(left, top + 1) + fx * texel(left + 1, top + 1));
}

}  // namespace

TEST(EnvironmentFlux, a_cell_holds_the_integral_of_what_the_filter_shows_whatever_the_sizes) {
    const uint32_t sizes[][4] = {{8, 4, 8, 4}, {13, 7, 13, 7}, {13, 7, 5, 3}, {1, 1, 1, 1}, {6, 1, 6, 1}, {1, 5, 1, 5}, {2, 2, 2, 2}, {40, 20, 16, 8}, {5, 3, 8, 8}};
    for (const auto& [width, height, columns, rows] : sizes) {
        const Environment e = random_map(width, height, width * height);
        const std::vector<double> flux = environment_flux(e, columns, rows);
        const uint32_t fine = 120;  // points across a cell
        for (uint32_t r = 0; r < rows; ++r)
            for (uint32_t c = 0; c < columns; ++c) {
                double sum = 0;
                for (uint32_t i = 0; i < fine; ++i) {
                    const double v = (r + (i + 0.5) / fine) / rows, weight = 2 * kPi / columns / fine * (kPi / rows / fine) * std::sin(kPi * v);
                    for (uint32_t k = 0; k < fine; ++k) sum += weight * luminance_at(e, (c + (k + 0.5) / fine) / columns, v);
                }
                ASSERT_NEAR(flux[size_t(r) * columns + c], sum, 2e-4 * sum) << width << 'x' << height << ' ' << columns << 'x' << rows << ' ' << r << ' ' << c;
            }
    }
}

TEST(EnvironmentFlux, the_cells_of_a_constant_map_have_their_solid_angle_and_fill_the_sphere) {
    Environment e{.width = 37, .height = 2048, .scale = glm::vec3(1.0f)};
    e.radiance.assign(size_t(37) * 2048, glm::vec3(1.0f));
    for (const bool image : {true, false}) {
        if (!image) e.radiance.clear();
        const std::vector<double> flux = environment_flux(e, 37, 512);
        double sum = 0;
        for (size_t i = 0; i < flux.size(); ++i) {
            ASSERT_NEAR(flux[i], environment_cell_solid_angle(static_cast<uint32_t>(i / 37), 37, 512), 1e-8 * flux[i]) << i;
            sum += flux[i];
        }
        EXPECT_NEAR(sum, 4 * kPi, 1e-9);
    }
    EXPECT_NEAR(environment_cell_solid_angle(0, 1, 1), 4 * kPi, 1e-12);
    EXPECT_NEAR(environment_cell_solid_angle(0, 4, 1000), 2 * kPi / 4 * (1 - std::cos(kPi / 1000)), 1e-13);
}

TEST(EnvironmentFlux, black_stays_black_and_a_bright_texel_shines_as_far_as_the_filter_takes_it) {
    Environment e{.width = 16, .height = 8, .scale = glm::vec3(1.0f)};
    e.radiance.assign(size_t(16) * 8, glm::vec3(0.0f));
    e.radiance[size_t(2) * 16 + 0] = glm::vec3(1e5f);
    const std::vector<double> flux = environment_flux(e, 16, 8);
    for (uint32_t y = 0; y < 8; ++y)
        for (uint32_t x = 0; x < 16; ++x) EXPECT_EQ(flux[y * 16 + x] > 0, y >= 1 && y <= 3 && (x <= 1 || x == 15)) << x << ' ' << y;
    EXPECT_NEAR(flux[2 * 16 + 1], flux[2 * 16 + 15], 1e-9 * flux[2 * 16 + 1]);
}

}  // namespace parhelion::environment_flux_test
