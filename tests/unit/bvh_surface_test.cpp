// The exact parts under the traversal and the canonical surface (shaders/lib/ray_triangle.glsl, affine.glsl, compiled as C++).
#include <cmath>

#include <gtest/gtest.h>

#include "lib/affine.glsl"
#include "support/bvh_scene.h"

namespace parhelion::bvh::testing::bvh_surface_test {
namespace {

int sign(double x) { return (x > 0.0) - (x < 0.0); }

// Products of floats are exact in double, and a difference of doubles has the right sign.
TEST(RayTriangle, edge_areas_have_the_exact_sign_and_are_antisymmetric) {
    Random random(1);
    int hidden = 0;
    for (int i = 0; i < 200000; ++i) {
        const glm::vec3 a = random.in_cube(std::pow(10.0f, random.range(-4.0f, 5.0f)));
        // Nearly parallel, so that the products often round to the same number.
        const float factor = random.range(-2.0f, 2.0f);
        const glm::vec3 b = i % 4 == 0 ? random.in_cube(1.0f) : glm::vec3(a.x * factor, a.y * factor, 0.0f);
        const int exact = sign(double(a.x) * b.y - double(a.y) * b.x);
        const float quick = shared::edge_area(a, b), area = shared::edge_area_accurate(a, b, false);
        hidden += quick == 0.0f && area != 0.0f;
        ASSERT_EQ(sign(area), exact) << a.x << ' ' << a.y << ' ' << b.x << ' ' << b.y;
        ASSERT_TRUE(quick == 0.0f || sign(quick) == exact) << a.x << ' ' << a.y << ' ' << b.x << ' ' << b.y;
        ASSERT_EQ(shared::edge_area_accurate(a, b, true), area);
        ASSERT_EQ(shared::edge_area(b, a), -quick);
        ASSERT_EQ(shared::edge_area_accurate(b, a, false), -area);
    }
    EXPECT_GT(hidden, 10000) << "rounding has to hide the sign often for this to test anything";
}

struct Canonical {
    float t = 0;
    glm::vec2 barycentrics{0.0f};
    glm::dvec3 point(const glm::vec3 (&p)[3]) const {
        const double x = barycentrics.x, y = barycentrics.y;
        return (1.0 - x - y) * glm::dvec3(p[0]) + x * glm::dvec3(p[1]) + y * glm::dvec3(p[2]);
    }
    bool inside() const { return t >= 0.0f && barycentrics.x >= 0.0f && barycentrics.y >= 0.0f && 1.0f - barycentrics.x - barycentrics.y >= 0.0f; }
};

Canonical intersect(glm::vec3 origin, glm::vec3 direction, const glm::vec3 (&p)[3]) {
    Canonical c;
    shared::intersect_canonical(origin, direction, p[0], p[1], p[2], c.t, c.barycentrics);
    return c;
}

double distance_to_ray(glm::dvec3 p, glm::dvec3 origin, glm::dvec3 direction) {
    return glm::length(glm::cross(p - origin, direction)) / glm::length(direction);
}

TEST(RayTriangle, a_canonical_hit_is_on_the_ray_and_in_the_triangle) {
    Random random(2);
    for (int i = 0; i < 100000; ++i) {
        const glm::vec3 p[3] = {random.in_cube(1.0f), random.in_cube(1.0f), random.in_cube(1.0f)}, origin = random.in_cube(3.0f);
        const float u = random.unit(), v = random.unit() * (1.0f - u);
        const glm::vec3 target = p[0] + u * (p[1] - p[0]) + v * (p[2] - p[0]), direction = glm::normalize(target - origin);
        const Canonical c = intersect(origin, direction, p);
        ASSERT_TRUE(c.inside());
        ASSERT_LT(distance_to_ray(c.point(p), glm::dvec3(origin), glm::dvec3(direction)), 3e-6);
        ASSERT_LT(std::abs(glm::dot(c.point(p) - glm::dvec3(origin), glm::dvec3(direction)) - c.t), 3e-6);
    }
}

TEST(RayTriangle, a_canonical_hit_stays_in_the_triangle_when_the_ray_passes_it) {
    Random random(3);
    for (int i = 0; i < 50000; ++i) {
        const glm::vec3 p[3] = {random.in_cube(1.0f), random.in_cube(1.0f), random.in_cube(1.0f)}, origin = random.in_cube(3.0f);
        // Past an edge or a corner by a little.
        const float s = i % 2 == 0 ? random.unit() : float(i % 4 == 1);
        const glm::vec3 target = p[i % 3] + s * (p[(i + 1) % 3] - p[i % 3]) + random.in_cube(1e-4f), direction = glm::normalize(target - origin);
        const Canonical c = intersect(origin, direction, p);
        ASSERT_TRUE(c.inside());
        ASSERT_LT(distance_to_ray(c.point(p), glm::dvec3(origin), glm::dvec3(direction)), 2e-4);
    }
}

TEST(RayTriangle, a_canonical_hit_exists_for_edge_on_and_degenerate_triangles) {
    Random random(4);
    for (int i = 0; i < 20000; ++i) {
        const glm::vec3 a = random.in_cube(1.0f), b = random.in_cube(1.0f);
        const bool point = i % 3 == 0, line = i % 3 == 1;
        glm::vec3 p[3] = {a, point ? a : b, point ? a : line ? a + 0.25f * (b - a) : random.in_cube(1.0f)};
        glm::vec3 origin = random.in_cube(3.0f), target = a + random.unit() * (p[1] - a);
        // In the triangle's plane.
        if (!point && !line) origin = a + 3.0f * (p[1] - a) - 2.0f * (p[2] - a);
        const glm::vec3 direction = glm::normalize(target - origin);
        const Canonical c = intersect(origin, direction, p);
        ASSERT_TRUE(c.inside());
        ASSERT_LT(distance_to_ray(c.point(p), glm::dvec3(origin), glm::dvec3(direction)), 1e-5);
    }
    const glm::vec3 flat[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    EXPECT_TRUE(intersect({-1, 0.25f, 0}, {1, 0, 0}, flat).inside());
    EXPECT_NEAR(intersect({-1, 0.25f, 0}, {1, 0, 0}, flat).point(flat).y, 0.25, 1e-6);
}

TEST(Affine, error_bounds_hold_and_are_not_wasteful) {
    Random random(5);
    double largest = 0;
    for (int i = 0; i < 100000; ++i) {
        const float scale = std::pow(10.0f, random.range(-3.0f, 3.0f));
        const auto row = [&] { return glm::vec4(random.in_cube(1.0f), random.range(-1.0f, 1.0f) * scale); };
        const shared::Affine a{row(), row(), row()};
        const glm::vec3 p = random.in_cube(scale), p_error = i % 2 == 0 ? glm::vec3(0.0f) : glm::abs(random.in_cube(1e-6f)) * scale;
        glm::vec3 error;
        const glm::vec3 r = shared::transform_point_precise(a, p, p_error, error);
        const glm::dvec3 off(random.below(2) ? p_error.x : -p_error.x, random.below(2) ? p_error.y : -p_error.y, random.below(2) ? p_error.z : -p_error.z);
        const glm::dvec4 q(glm::dvec3(p) + off, 1.0);
        const glm::dvec3 exact(glm::dot(glm::dvec4(a.row0), q), glm::dot(glm::dvec4(a.row1), q), glm::dot(glm::dvec4(a.row2), q));
        for (int k = 0; k < 3; ++k) {
            ASSERT_LE(std::abs(double(r[k]) - exact[k]), double(error[k]));
            largest = std::max(largest, std::abs(double(r[k]) - exact[k]) / double(error[k]));
        }
    }
    EXPECT_GT(largest, 0.4);
}

TEST(Affine, vectors_and_normals_follow_the_matrix) {
    const shared::Affine a{{1, 2, 0, 5}, {0, 1, 3, 6}, {0, 0, 2, 7}}, inverse{{1, -2, 3, 0}, {0, 1, -1.5f, 0}, {0, 0, 0.5f, 0}};
    EXPECT_EQ(shared::transform_vector(a, {1, 1, 1}), glm::vec3(3, 4, 2));
    const glm::vec3 n(1, 2, 3), tangent(2, -1, 0);
    EXPECT_EQ(glm::dot(n, tangent), 0.0f);
    EXPECT_EQ(glm::dot(shared::transform_normal(inverse, n), shared::transform_vector(a, tangent)), 0.0f);
}

}  // namespace
}  // namespace parhelion::bvh::testing::bvh_surface_test
