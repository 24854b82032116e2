// The clear sky: the atmosphere against what can be integrated by hand, and against measured daylight.
#include "scene/sky.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "scene/atmosphere.h"
#include "scene/scene.h"

namespace parhelion::sky_test {
namespace {

constexpr double kPi = std::numbers::pi;

double luminance(glm::dvec3 c) { return glm::dot(c, glm::dvec3(0.2126, 0.7152, 0.0722)); }
glm::dvec3 to_sun(const Light& sun) { return glm::dvec3(sun.place.node_from_object[2]); }
glm::dvec3 texel(const Environment& e, uint32_t x, uint32_t y) { return glm::dvec3(e.radiance[size_t(y) * e.width + x]); }

// Illuminance of level ground by the upper half of the map, lux.
glm::dvec3 sky_illuminance(const Environment& e) {
    glm::dvec3 sum(0.0);
    for (uint32_t y = 0; y < e.height / 2; ++y) {
        const double polar = kPi * (y + 0.5) / e.height, solid_angle = 2 * kPi / e.width * kPi / e.height * std::sin(polar);
        for (uint32_t x = 0; x < e.width; ++x) sum += texel(e, x, y) * solid_angle * std::cos(polar);
    }
    return sum;
}

Sky sky_at(double elevation_degrees, uint32_t rows = 64) {
    return make_clear_sky({.sun_elevation = static_cast<float>(elevation_degrees * kPi / 180), .rows = rows});
}

TEST(Atmosphere, straight_up_the_depth_is_that_of_the_layers) {
    // Two exponential layers of 60 km (8 and 1.2 km scale height) and a tent of ozone with an area of 15 km.
    const glm::dvec3 rayleigh(5.802e-6, 13.558e-6, 33.1e-6), ozone(0.650e-6, 1.881e-6, 0.085e-6);
    const glm::dvec3 depth = rayleigh * 8000.0 * (1 - std::exp(-60.0 / 8)) + 44.4e-6 * 1200.0 * (1 - std::exp(-50.0)) + ozone * 15000.0;
    const glm::dvec3 passed = Atmosphere(0.2).transmittance(0.0, 1.0);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(passed[c], std::exp(-depth[c]), 2e-3) << c;
}

TEST(Atmosphere, transmittance_falls_towards_the_horizon_and_ends_there) {
    const Atmosphere air(0.2);
    glm::dvec3 before(1.0);
    for (const double up : {1.0, 0.7, 0.4, 0.2, 0.1, 0.03, 0.0}) {
        const glm::dvec3 passed = air.transmittance(2.0, up);
        for (int c = 0; c < 3; ++c) EXPECT_LT(passed[c], before[c]) << up;
        EXPECT_GT(passed.r, passed.b);
        before = passed;
    }
    EXPECT_EQ(air.transmittance(2.0, -0.1), glm::dvec3(0.0));
    EXPECT_GT(air.transmittance(50'000.0, -0.05).g, 0.5);  // from high up the horizon lies lower
}

// Clear days: 80 to 100 klx of direct light on a surface that faces a sun 40 degrees high, 10 to 20 klx from the sky (IES Lighting Handbook;
// CIE 85: 1989).
TEST(Sky, daylight_has_the_illuminance_of_clear_days) {
    const Sky sky = sky_at(40);
    const double direct = luminance(glm::dvec3(sky.sun.color) * double(sky.sun.intensity)), diffuse = luminance(sky_illuminance(sky.environment));
    EXPECT_GT(direct, 75'000);
    EXPECT_LT(direct, 105'000);
    EXPECT_GT(diffuse, 8'000);
    EXPECT_LT(diffuse, 22'000);
    // Never more than what arrives from space.
    EXPECT_LT(direct * std::sin(40 * kPi / 180) + diffuse, 133'000 * std::sin(40 * kPi / 180));
}

TEST(Sky, the_zenith_is_blue_and_the_horizon_pale_and_bright) {
    const Environment e = sky_at(40).environment;
    const glm::dvec3 zenith = texel(e, 0, 0), horizon = texel(e, e.width / 2, e.height / 2 - 2);
    EXPECT_GT(zenith.b, 2.0 * zenith.r);
    EXPECT_GT(luminance(horizon), 2.0 * luminance(zenith));
    EXPECT_LT(horizon.b / horizon.r, zenith.b / zenith.r);
}

TEST(Sky, the_ground_reflects_what_falls_on_it) {
    const Sky sky = sky_at(40);
    const Environment& e = sky.environment;
    const double falling = luminance(glm::dvec3(sky.sun.color) * double(sky.sun.intensity)) * std::sin(40 * kPi / 180) + luminance(sky_illuminance(e));
    EXPECT_NEAR(luminance(texel(e, 3, e.height - 1)), 0.2 / kPi * falling, 0.01 * falling * 0.2 / kPi);
}

TEST(Sky, the_map_is_brightest_around_the_sun_and_even_on_both_sides_of_it) {
    const Sky sky = sky_at(30);
    const Environment& e = sky.environment;
    uint32_t best_x = 0, best_y = 0;
    for (uint32_t y = 0; y < e.height; ++y)
        for (uint32_t x = 0; x < e.width; ++x)
            if (luminance(texel(e, x, y)) > luminance(texel(e, best_x, best_y))) best_x = x, best_y = y;
    const double polar = kPi * (best_y + 0.5) / e.height, azimuth = 2 * kPi * ((best_x + 0.5) / e.width - 0.5);
    const glm::dvec3 brightest(std::sin(polar) * std::sin(azimuth), std::cos(polar), -std::sin(polar) * std::cos(azimuth));
    EXPECT_GT(glm::dot(brightest, to_sun(sky.sun)), std::cos(3 * kPi / 180));
    // Azimuth 45 degrees from +Z towards +X lies at u = 0.5 + 135 / 360: columns mirrored about it are equal.
    const uint32_t middle = e.width / 2 + e.width * 135 / 360;
    for (uint32_t k = 1; k < 20; ++k) {
        const double a = luminance(texel(e, (middle + k) % e.width, 20)), b = luminance(texel(e, middle - 1 - k, 20));
        EXPECT_NEAR(a, b, 1e-4 * a) << k;
    }
}

TEST(Sky, a_low_sun_is_dim_and_red_and_none_is_left_at_night) {
    const Sky noon = sky_at(60), evening = sky_at(3), night = sky_at(-18);
    EXPECT_LT(evening.sun.intensity, 0.6f * noon.sun.intensity);
    EXPECT_GT(evening.sun.color.r / evening.sun.color.b, 2.0f * noon.sun.color.r / noon.sun.color.b);
    EXPECT_EQ(night.sun.intensity, 0.0f);
    EXPECT_LT(luminance(sky_illuminance(night.environment)), 0.01 * luminance(sky_illuminance(noon.environment)));
}

TEST(Sky, it_is_a_valid_part_of_a_scene_and_the_same_every_time) {
    for (const double elevation : {-18.0, -1.0, 0.0, 10.0, 90.0}) {
        Sky sky = sky_at(elevation, 16), again = sky_at(elevation, 16);
        EXPECT_EQ(sky.environment.radiance, again.environment.radiance);
        EXPECT_NEAR(to_sun(sky.sun).y, std::sin(elevation * kPi / 180), 1e-6);
        EXPECT_NEAR(glm::determinant(sky.sun.place.node_from_object), 1.0f, 1e-5f);
        EXPECT_FLOAT_EQ(sky.sun.angular_radius * float(360 / kPi), 0.53f);
        SceneEdit edit;
        edit.add(std::move(sky.sun));
        edit.set_environment(std::move(sky.environment));
        Scene scene;
        EXPECT_NO_THROW(scene.apply(std::move(edit)));
    }
}

}  // namespace
}  // namespace parhelion::sky_test
