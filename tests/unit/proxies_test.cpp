// Proxies on the host: what simplification leaves, and how far it is measured to be off.
#include <algorithm>
#include <bit>
#include <map>

#include <gtest/gtest.h>

#include "scene/shapes.h"
#include "scene/simplify.h"
#include "scene_gpu/proxies.h"

namespace parhelion::proxies_test {
namespace {

constexpr float kRadius = 2.0f, kDeviation = 0.04f;

Primitive ball(bool inward = false) {
    Primitive out = make_sphere(kRadius, 48, true);
    if (inward)
        for (glm::uvec3& t : out.triangles) std::swap(t.y, t.z);
    return out;
}

float front_of(uint32_t heights) { return std::bit_cast<float>(heights & 0xFFFF0000u); }
float behind(uint32_t heights) { return std::bit_cast<float>(heights << 16); }

// The edges that only one triangle has, by the places of their ends.
std::vector<std::pair<std::array<float, 3>, std::array<float, 3>>> open_edges(const Primitive& shape, const std::vector<glm::uvec3>& triangles) {
    using Place = std::array<float, 3>;
    std::map<std::pair<Place, Place>, int> uses;
    const auto place = [&](uint32_t i) { return Place{shape.positions[i].x, shape.positions[i].y, shape.positions[i].z}; };
    for (const glm::uvec3& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const Place a = place(t[k]), b = place(t[(k + 1) % 3]);
            ++uses[std::minmax(a, b)];
        }
    std::vector<std::pair<Place, Place>> open;
    for (const auto& [edge, count] : uses)
        if (count == 1) open.push_back(edge);
    return open;
}

// Of the middles of triangles over a ball's vertices, and of their edges.
float lowest_radius(const Primitive& ball, const std::vector<glm::uvec3>& triangles) {
    float lowest = kRadius;
    for (const glm::uvec3& t : triangles) {
        const glm::vec3 a = ball.positions[t.x], b = ball.positions[t.y], c = ball.positions[t.z];
        for (const glm::vec3 point : {0.5f * (a + b), 0.5f * (b + c), 0.5f * (c + a), (a + b + c) / 3.0f}) lowest = std::min(lowest, glm::length(point));
    }
    return lowest;
}

TEST(Proxies, are_triangles_over_the_same_vertices) {
    const Primitive whole = ball();
    const Proxy proxy = make_proxy(whole, 0.25f, 1.0f);
    ASSERT_FALSE(proxy.triangles.empty());
    EXPECT_LE(proxy.triangles.size(), whole.triangles.size() / 4);
    EXPECT_GE(proxy.triangles.size(), whole.triangles.size() / 5);
    EXPECT_EQ(proxy.heights.size(), whole.triangles.size());
    for (const glm::uvec3& t : proxy.triangles) {
        EXPECT_LT(std::max({t.x, t.y, t.z}), whole.positions.size());
        EXPECT_TRUE(t.x != t.y && t.y != t.z && t.z != t.x);
    }
}

TEST(Proxies, stop_at_the_deviation_that_is_allowed) {
    const Primitive whole = ball();
    const SimplifiedTriangles near = simplify_triangles(whole, {.ratio = 0.01f, .deviation = kDeviation}), far = simplify_triangles(whole, {.ratio = 0.01f, .deviation = 4 * kDeviation});
    EXPECT_LE(near.deviation, kDeviation);
    EXPECT_GT(near.triangles.size(), 1.5 * double(far.triangles.size()));
    const float lowest = lowest_radius(whole, near.triangles);
    EXPECT_LE(kRadius - lowest, 4 * kDeviation);
    EXPECT_GE(kRadius - lowest, kDeviation / 4);
}

TEST(Proxies, that_gain_little_are_none) {
    EXPECT_TRUE(make_proxy(ball(), 0.9f, 1.0f).triangles.empty());
    EXPECT_TRUE(make_proxy(ball(), 0.1f, 0.0f).triangles.empty());
    Primitive box;
    add_box(box, glm::vec3(-1), glm::vec3(1));
    EXPECT_TRUE(make_proxy(box, 0.1f, 0.01f).heights.empty());
    EXPECT_TRUE(make_proxy({}, 0.1f, 1.0f).triangles.empty());
}

TEST(Proxies, keep_open_borders_and_repeat_to_the_bit) {
    Primitive sheet;
    add_textured_quad(sheet, {0, 0, 0}, {1, 0, 0}, {0, 0, -1}, glm::vec2(1.0f), 24);
    for (glm::vec3& p : sheet.positions) p.y = 0.02f * std::sin(9.0f * p.x) * std::cos(7.0f * p.z);
    const Proxy proxy = make_proxy(sheet, 0.3f, 0.05f), again = make_proxy(sheet, 0.3f, 0.05f);
    ASSERT_FALSE(proxy.triangles.empty());
    EXPECT_EQ(open_edges(sheet, proxy.triangles), open_edges(sheet, sheet.triangles));
    EXPECT_EQ(proxy.triangles, again.triangles);
    EXPECT_EQ(proxy.heights, again.heights);
}

// A sphere's proxy lies within it: behind what faces out, before what faces in.
TEST(Proxies, know_how_far_they_rise_over_a_sphere) {
    for (const bool inward : {false, true}) {
        const Primitive whole = ball(inward);
        const Proxy proxy = make_proxy(whole, 0.1f, 1.0f);
        float within = 0.0f, without = 0.0f;
        for (const uint32_t heights : proxy.heights) {
            within = std::max(within, inward ? front_of(heights) : behind(heights));
            without = std::max(without, inward ? behind(heights) : front_of(heights));
        }
        const float lowest = lowest_radius(whole, proxy.triangles);
        EXPECT_GE(within, kRadius - lowest) << inward;
        EXPECT_LE(within, 1.5f * (kRadius - lowest)) << inward;
        EXPECT_LT(without, 0.1f * within) << inward;
    }
}

TEST(Proxies, stand_for_plain_opaque_materials_alone) {
    EXPECT_TRUE(takes_proxies({}));
    Material material;
    material.emission = glm::vec3(0, 0, 1);
    EXPECT_FALSE(takes_proxies(material));
    for (const AlphaMode mode : {AlphaMode::Mask, AlphaMode::Blend}) {
        material = {};
        material.alpha_mode = mode;
        EXPECT_FALSE(takes_proxies(material));
    }
    material = {};
    material.transmission = 0.5f;
    EXPECT_FALSE(takes_proxies(material));
}

}  // namespace
}  // namespace parhelion::proxies_test
