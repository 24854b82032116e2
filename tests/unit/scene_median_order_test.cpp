// The order of triangles after import.
#include "scene/median_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "scene/shapes.h"

namespace parhelion::scene_median_order_test {

namespace {

using Key = std::array<uint32_t, 3>;

std::vector<Key> keys(const Primitive& primitive) {
    std::vector<Key> out;
    for (const glm::uvec3& t : primitive.triangles) out.push_back({t.x, t.y, t.z});
    return out;
}

// Sum over the tree that halves the list by index of the surface areas of its boxes, relative to the root's: what a builder
// that does not sort makes rays pay (MacDonald and Booth 1990).
double halving_cost(const Primitive& p, size_t begin, size_t end, double& root_area) {
    Bounds box;
    for (size_t i = begin; i < end; ++i)
        for (int corner = 0; corner < 3; ++corner) box.add(p.positions[p.triangles[i][corner]]);
    const glm::dvec3 d(box.max - box.min);
    const double area = d.x * d.y + d.y * d.z + d.z * d.x;
    if (root_area == 0.0) root_area = area;
    if (end - begin <= 1) return area / root_area;
    const size_t middle = begin + (end - begin) / 2;
    return area / root_area + halving_cost(p, begin, middle, root_area) + halving_cost(p, middle, end, root_area);
}

double halving_cost(const Primitive& p) {
    double root_area = 0.0;
    return halving_cost(p, 0, p.triangles.size(), root_area);
}

Primitive shuffled_sphere(uint32_t rings) {
    Primitive sphere = make_sphere(1.0f, rings, false);
    std::shuffle(sphere.triangles.begin(), sphere.triangles.end(), std::mt19937(3));
    return sphere;
}

}  // namespace

TEST(MedianOrder, keeps_the_set_of_triangles_and_their_corners) {
    for (const uint32_t rings : {2u, 3u, 7u, 20u}) {
        Primitive sphere = shuffled_sphere(rings);
        std::vector<Key> before = keys(sphere);
        const std::vector<glm::vec3> positions = sphere.positions;
        order_triangles_by_median(sphere);
        std::vector<Key> after = keys(sphere);
        EXPECT_EQ(positions, sphere.positions);
        std::sort(before.begin(), before.end());
        std::sort(after.begin(), after.end());
        EXPECT_EQ(before, after);
    }
}

TEST(MedianOrder, makes_a_tree_of_index_halves_several_times_cheaper) {
    Primitive sphere = shuffled_sphere(60);
    const double before = halving_cost(sphere);
    order_triangles_by_median(sphere);
    EXPECT_LT(halving_cost(sphere), before / 5.0);
}

TEST(MedianOrder, is_repeatable_on_more_triangles_than_one_piece) {
    Primitive a = shuffled_sphere(200), b = a;  // 159,200 triangles
    ASSERT_GT(a.triangles.size(), 2u << 16);
    order_triangles_by_median(a);
    order_triangles_by_median(b);
    EXPECT_EQ(keys(a), keys(b));
    const std::vector<Key> once = keys(a);
    order_triangles_by_median(a);
    EXPECT_LT(halving_cost(a), 1.01 * halving_cost(b));
}

TEST(MedianOrder, bears_empty_tiny_and_coincident_meshes) {
    Primitive none;
    EXPECT_NO_THROW(order_triangles_by_median(none));
    Primitive same;
    same.positions = {{1, 1, 1}, {2, 1, 1}, {1, 2, 1}};
    same.triangles.assign(1000, glm::uvec3(0, 1, 2));
    order_triangles_by_median(same);
    EXPECT_EQ(same.triangles.size(), 1000u);
    Primitive far;
    far.positions = {{1e18f, 1e18f, 0}, {-1e18f, 1e18f, 0}, {1e18f, -1e18f, 0}};
    far.triangles.assign(100, glm::uvec3(0, 1, 2));
    EXPECT_NO_THROW(order_triangles_by_median(far));
}

}  // namespace parhelion::scene_median_order_test
