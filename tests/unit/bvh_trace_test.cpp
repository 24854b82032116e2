// The traversal of our own BVH (shaders/lib/traverse.glsl, compiled as C++) against brute force, and against leaks.
#include <cmath>
#include <limits>
#include <map>

#include <gtest/gtest.h>

#include "support/bvh_scene.h"

namespace parhelion::bvh::testing::bvh_trace_test {
namespace {

class BvhTrace : public EachLayout {};
INSTANTIATE_TEST_SUITE_P(Nodes, BvhTrace, ::testing::ValuesIn(kLayouts), layout_of);

glm::mat4 translation(glm::vec3 t) {
    glm::mat4 m(1.0f);
    m[3] = glm::vec4(t, 1.0f);
    return m;
}
glm::mat4 scaling(glm::vec3 s) {
    glm::mat4 m(1.0f);
    for (int c = 0; c < 3; ++c) m[c][c] = s[c];
    return m;
}
glm::mat4 rotation(Random& random) {
    const glm::vec3 x = random.direction(), y = glm::normalize(glm::cross(x, random.direction())), z = glm::cross(x, y);
    return glm::mat4(glm::vec4(x, 0), glm::vec4(y, 0), glm::vec4(z, 0), glm::vec4(0, 0, 0, 1));
}

// From anywhere to somewhere in the middle; every fourth along an axis, every eighth of limited range. Of any length.
shared::TraversalRay random_ray(Random& random, int i, float half_cube) {
    const glm::vec3 origin = random.in_cube(half_cube);
    glm::vec3 direction = random.in_cube(0.3f * half_cube) - origin;
    if (i % 4 == 0) direction = glm::vec3(i % 3 == 0, i % 3 == 1, i % 3 == 2) * (i % 8 == 0 ? 1.0f : -1.0f);
    const float t_min = i % 8 == 1 ? random.range(0.0f, 1.0f) : 0.0f;
    return make_ray(origin, direction, t_min, i % 8 < 2 ? t_min + random.range(0.0f, 1.0f) : 3.4e38f);
}

TEST_P(BvhTrace, closest_and_any_hit_equal_brute_force_on_random_soups) {
    Random random(1);
    for (const uint32_t count : {1u, 4u, 5u, 40u, 400u, 3000u})
        for (const float size : {0.05f, 0.5f, 5.0f}) {
            const TestScene scene(make_soup(random, count, 2.0f, size));
            for (int i = 0; i < (count > 1000 ? 300 : 1000); ++i)
                ASSERT_EQ(compare_with_brute_force(scene, random_ray(random, i, 4.0f)), "") << count << " triangles of " << size << ", ray " << i;
        }
}

// Triangles in several leaves; a filter that refuses some is asked about them several times.
TEST_P(BvhTrace, closest_and_any_hit_equal_brute_force_where_triangles_are_cut) {
    Random random(9);
    const TestScene scene(make_hall(random));
    const AcceptHit filter = [](uint32_t, uint32_t, uint32_t primitive, glm::vec2, bool front) { return (primitive + front) % 3 != 0; };
    for (int i = 0; i < 600; ++i) ASSERT_EQ(compare_with_brute_force(scene, random_ray(random, i, 12.0f), i % 2 == 0 ? filter : AcceptHit{}), "") << "ray " << i;
}

// Mirrored, sheared, nested instances of two meshes, with masks, and with a filter that refuses every third candidate.
TEST_P(BvhTrace, instances_equal_brute_force_whatever_their_transforms) {
    Random random(2);
    std::vector<TestMesh> meshes{{make_soup(random, 60, 1.0f, 1.0f), make_soup(random, 30, 1.0f, 0.5f)}, {make_icosphere(1, 1.0f)}, {}};
    std::vector<TestInstance> instances;
    for (uint32_t i = 0; i < 60; ++i) {
        glm::mat4 m = rotation(random) * scaling({random.range(0.2f, 1.5f), random.range(-1.5f, -0.2f), random.range(0.2f, 1.5f)});
        if (i % 2 == 0) m = m * rotation(random) * scaling({1.0f, -1.0f, 0.3f});
        m[3] = glm::vec4(random.in_cube(4.0f), 1.0f);
        instances.push_back({.mesh = i % 3, .world_from_object = m, .mask = 1u << (i % 5)});
    }
    const TestScene scene(std::move(meshes), std::move(instances));
    const AcceptHit filter = [](uint32_t instance, uint32_t geometry, uint32_t primitive, glm::vec2, bool front) {
        return (instance + geometry + primitive + front) % 3 != 0;
    };
    int hits = 0;
    for (int i = 0; i < 4000; ++i) {
        shared::TraversalRay ray = random_ray(random, i, 5.0f);
        ray.mask = i % 3 == 0 ? 0xFFu : random.below(32);
        ASSERT_EQ(compare_with_brute_force(scene, ray, i % 2 == 0 ? filter : AcceptHit{}), "") << "ray " << i;
        hits += trace_any_host(scene.bottoms, scene.top, ray);
    }
    EXPECT_GT(hits, 1000);
}

// An independent judge of t, barycentrics and side: Moller and Trumbore's test in double precision.
TEST_P(BvhTrace, hits_are_where_another_triangle_test_puts_them) {
    Random random(3);
    glm::mat4 mirrored = rotation(random) * scaling({1.3f, -0.7f, 1.0f});
    mirrored[3] = {0.5f, -0.25f, 0.1f, 1.0f};
    for (const glm::mat4& m : {glm::mat4(1.0f), mirrored}) {
        const TestScene scene({{make_soup(random, 1000, 2.0f, 1.0f)}}, {{.world_from_object = m}});
        int hits = 0;
        for (int i = 0; i < 2000; ++i) {
            const shared::TraversalRay ray = make_ray(random.in_cube(3.0f), random.direction());
            std::map<uint32_t, bool> fronts;  // of all candidates
            const AcceptHit note_side = [&](uint32_t, uint32_t, uint32_t primitive, glm::vec2, bool front) {
                fronts[primitive] = front;
                return true;
            };
            shared::TraversalHit hit{};
            if (!trace_closest_host(scene.bottoms, scene.top, ray, hit, note_side)) continue;
            ++hits;
            const TestGeometry& g = scene.meshes[0][0];
            glm::dvec3 p[3];
            for (int k = 0; k < 3; ++k) p[k] = glm::dvec3(glm::dmat4(m) * glm::dvec4(g.positions[g.triangles[hit.primitive][k]], 1.0));
            const glm::dvec3 o(ray.origin_ws), d(ray.direction_ws), e1 = p[1] - p[0], e2 = p[2] - p[0], n = glm::cross(e1, e2);
            if (std::abs(glm::dot(n, d)) < 1e-2 * glm::length(n)) continue;  // grazing: ill-conditioned
            const double t = glm::dot(p[0] - o, n) / glm::dot(d, n);
            EXPECT_NEAR(hit.t, t, 2e-4);
            EXPECT_LT(glm::length(o + t * d - (p[0] + double(hit.barycentrics.x) * e1 + double(hit.barycentrics.y) * e2)), 2e-4);
            // Mirroring turns the corners over in world space; the front side stays what it is in object space.
            const bool flipped = glm::determinant(glm::dmat4(m)) < 0;
            EXPECT_EQ(fronts.at(hit.primitive), (glm::dot(n, d) < 0) != flipped);
        }
        EXPECT_GT(hits, 500);
    }
}

TEST_P(BvhTrace, back_faces_that_are_refused_let_the_ray_through) {
    const TestScene scene({{make_icosphere(3, 1.0f)}}, {{}, {.world_from_object = scaling({-0.5f, 0.5f, 0.5f})}});
    Random random(4);
    const AcceptHit front_only = [](uint32_t, uint32_t, uint32_t, glm::vec2, bool front) { return front; };
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 d = random.direction();
        shared::TraversalHit hit{};
        EXPECT_FALSE(trace_any_host(scene.bottoms, scene.top, make_ray(d * 0.1f, d), front_only)) << "from inside only back faces are seen";
        EXPECT_TRUE(trace_closest_host(scene.bottoms, scene.top, make_ray(d * 0.1f, d), hit));
        EXPECT_EQ(hit.instance, 1u);
        EXPECT_TRUE(trace_closest_host(scene.bottoms, scene.top, make_ray(d * 0.75f, -d), hit, front_only));
        EXPECT_EQ(hit.instance, 1u) << "the mirrored sphere shows its front outside, too";
        EXPECT_NEAR(hit.t, 0.25f, 0.01f);
    }
}

TEST_P(BvhTrace, equal_distances_go_to_the_smallest_ids) {
    Random random(5);
    const TestGeometry soup = make_soup(random, 40, 1.0f, 1.0f);
    TestGeometry twice = soup;
    for (const glm::uvec3 t : soup.triangles) twice.triangles.push_back(t);
    std::vector<TestInstance> instances(9, TestInstance{.world_from_object = rotation(random)});
    for (uint32_t i = 0; i < 9; ++i) instances[i].mesh = (i + 1) % 2;
    const TestScene scene({{twice, soup, twice}, {soup, soup}}, std::move(instances));
    int hits = 0;
    for (int i = 0; i < 2000; ++i) {
        const shared::TraversalRay ray = random_ray(random, i, 2.0f);
        ASSERT_EQ(compare_with_brute_force(scene, ray), "");
        shared::TraversalHit hit{};
        if (!trace_closest_host(scene.bottoms, scene.top, ray, hit)) continue;
        ++hits;
        EXPECT_EQ(hit.instance, 0u);
        EXPECT_EQ(hit.geometry, 0u);
        EXPECT_LT(hit.primitive, 40u);
    }
    EXPECT_GT(hits, 500);
}

TEST_P(BvhTrace, rays_in_the_planes_of_boxes_equal_brute_force) {
    Random random(6);
    TestMesh mesh;
    for (int i = 0; i < 27; ++i) {
        const glm::vec3 low(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
        mesh.push_back(make_box(low, low + 1.0f));
    }
    const TestScene scene({mesh}, {{}});
    for (int i = 0; i < 20000; ++i) {
        glm::vec3 origin, direction;
        for (int k = 0; k < 3; ++k) {
            origin[k] = float(random.below(9)) * 0.5f - 1.5f;
            direction[k] = float(int(random.below(3)) - 1);
        }
        if (direction == glm::vec3(0.0f)) direction.x = -0.0f, direction.y = 1.0f;
        ASSERT_EQ(compare_with_brute_force(scene, make_ray(origin, direction)), "") << i;
    }
}

// Counts the rays from inside a closed sphere that get out; every ray aims at a corner, at an edge, or near one.
int count_leaks(const TestScene& scene, const TestGeometry& sphere, const glm::mat4& m, glm::vec3 middle, float spread, int rays, Random& random) {
    int leaks = 0;
    for (int i = 0; i < rays; ++i) {
        const glm::uvec3 t = sphere.triangles[random.below(static_cast<uint32_t>(sphere.triangles.size()))];
        const glm::vec3 a = sphere.positions[t[random.below(3)]], b = sphere.positions[t[random.below(3)]];
        glm::vec3 target = i % 3 == 0 ? a : a + random.unit() * (b - a);
        if (i % 5 == 0) target += random.in_cube(1e-6f);
        const glm::vec3 origin = glm::vec3(m * glm::vec4(middle + random.in_cube(spread), 1.0f)), direction = glm::vec3(m * glm::vec4(target, 1.0f)) - origin;
        leaks += !trace_any_host(scene.bottoms, scene.top, make_ray(origin, direction));
    }
    return leaks;
}

TEST_P(BvhTrace, no_ray_slips_out_of_a_closed_sphere) {
    Random random(7);
    const TestGeometry sphere = make_icosphere(4, 1.0f);
    const TestScene plain(sphere);
    EXPECT_EQ(count_leaks(plain, sphere, glm::mat4(1.0f), glm::vec3(0.0f), 0.5f, 100000, random), 0);
    EXPECT_EQ(count_leaks(plain, sphere, glm::mat4(1.0f), glm::vec3(0.0f), 0.0f, 20000, random), 0) << "from the very middle";
    const TestGeometry coarse = make_icosphere(0, 1.0f);
    EXPECT_EQ(count_leaks(TestScene(coarse), coarse, glm::mat4(1.0f), glm::vec3(0.0f), 0.1f, 20000, random), 0);
}

TEST_P(BvhTrace, no_ray_slips_out_at_any_scale_and_place) {
    Random random(8);
    const TestGeometry sphere = make_icosphere(3, 1.0f);
    for (const float scale : {1e-4f, 1e-2f, 1.0f, 1e3f, 1e6f})
        for (const glm::vec3 place : {glm::vec3(0.0f), glm::vec3(1e3f, -2e3f, 7.0f), glm::vec3(1e6f, -1e6f, 9e5f)}) {
            // A world coordinate resolves 1/16 at 1e6: smaller spheres have no inside there.
            if (scale * 2.0f < glm::length(place) * 1e-6f) continue;
            const glm::mat4 m = translation(place) * rotation(random) * scaling(glm::vec3(scale, -0.5f * scale, 1.7f * scale));
            const TestScene scene({{sphere}}, {{.world_from_object = m}});
            EXPECT_EQ(count_leaks(scene, sphere, m, glm::vec3(0.0f), 0.1f, 4000, random), 0) << scale << " at " << place.x;
        }
    // The place in the vertices themselves, as scanned terrain has it.
    const glm::vec3 far(1e6f, 1e6f, -1e6f);
    const TestGeometry hill = make_icosphere(3, 100.0f, far);
    EXPECT_EQ(count_leaks(TestScene(hill), hill, glm::mat4(1.0f), far, 20.0f, 10000, random), 0);
}

// Far from the origin a plane's distance, plane / d - origin / d, is a difference of large numbers; the corners' differences
// to the origin, which the triangle test takes, are exact.
TEST_P(BvhTrace, boxes_far_from_the_origin_lose_no_ray) {
    Random random(10);
    for (const glm::vec3 place : {glm::vec3(1e6f, -1e6f, 1e6f), glm::vec3(0.0f, 1e6f, 0.0f), glm::vec3(3.0f, 1e5f, -1e6f)}) {
        TestGeometry grid;
        for (int x = 0; x < 24; ++x)
            for (int z = 0; z < 24; ++z) {
                const glm::vec3 corner = place + glm::vec3(x, 0, z) * 0.5f;
                grid.add(corner, corner + glm::vec3(0, 0, 0.5f), corner + glm::vec3(0.5f, 0, 0));
            }
        const TestScene scene(grid);
        int hits = 0;
        for (int i = 0; i < 2000; ++i) {
            const glm::vec3 a = grid.positions[random.below(static_cast<uint32_t>(grid.positions.size()))];
            const glm::vec3 origin = a + glm::round(random.in_cube(80.0f)) / 16.0f, target = a + glm::vec3(random.below(3), 0, random.below(3)) * 0.125f;
            const shared::TraversalRay ray = make_ray(origin, target - origin);
            if (ray.direction_ws == glm::vec3(0.0f)) continue;
            ASSERT_EQ(compare_with_brute_force(scene, ray), "") << "ray " << i << " at " << place.x;
            hits += trace_any_host(scene.bottoms, scene.top, ray);
        }
        EXPECT_GT(hits, 1000);
    }
}

// Subtracting the instance's place first keeps near hits exact where coordinates are coarse.
TEST_P(BvhTrace, a_translation_of_a_million_metres_keeps_distances) {
    Random random(9);
    const TestGeometry sphere = make_icosphere(4, 1.0f);
    const TestScene near({{sphere}}, {{}}), far({{sphere}}, {{.world_from_object = translation({1e6f, -1e6f, 1e6f})}});
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 origin = glm::round(random.in_cube(40.0f)) / 16.0f, direction = -glm::normalize(origin + 0.01f * random.direction());
        shared::TraversalHit a{}, b{};
        const bool hit = trace_closest_host(near.bottoms, near.top, make_ray(origin, direction), a);
        ASSERT_EQ(trace_closest_host(far.bottoms, far.top, make_ray(origin + glm::vec3(1e6f, -1e6f, 1e6f), direction), b), hit);
        ASSERT_TRUE(!hit || a.t == b.t) << a.t << " and " << b.t;
    }
}

TEST_P(BvhTrace, hits_lie_strictly_between_t_min_and_t_max) {
    TestGeometry wall;
    wall.add({-1, -1, 2}, {1, -1, 2}, {0, 1, 2});
    const TestScene scene(wall);
    const auto sees = [&](float t_min, float t_max) {
        shared::TraversalHit hit{};
        const shared::TraversalRay ray = make_ray({0, 0, 0}, {0, 0, 1}, t_min, t_max);
        EXPECT_EQ(trace_any_host(scene.bottoms, scene.top, ray), trace_closest_host(scene.bottoms, scene.top, ray, hit));
        return trace_any_host(scene.bottoms, scene.top, ray);
    };
    const float after = std::nextafter(2.0f, 3.0f), before = std::nextafter(2.0f, 1.0f);
    EXPECT_TRUE(sees(0.0f, 10.0f));
    EXPECT_TRUE(sees(before, after));
    EXPECT_FALSE(sees(0.0f, 2.0f));
    EXPECT_FALSE(sees(2.0f, 10.0f));
    EXPECT_TRUE(sees(0.0f, std::numeric_limits<float>::infinity()));
}

TEST_P(BvhTrace, nothing_to_hit_is_no_hit) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    TestGeometry points;
    for (int i = 0; i < 20; ++i) points.add(glm::vec3(float(i)), glm::vec3(float(i)), glm::vec3(float(i)));
    glm::mat4 flat(1.0f);
    flat[2] = glm::vec4(0.0f);
    const TestScene empty({}, {}), degenerate({{}, {points}, {make_icosphere(1, 1.0f)}}, {{.mesh = 0}, {.mesh = 1}, {.mesh = 2, .world_from_object = flat}});
    const TestScene sphere(make_icosphere(2, 1.0f));
    for (const TestScene* scene : {&empty, &degenerate})
        for (const glm::vec3 d : {glm::vec3(1.0f), glm::vec3(0.0f, 0.0f, 1.0f)})
            EXPECT_FALSE(trace_any_host(scene->bottoms, scene->top, make_ray(glm::vec3(-1.0f), d)));
    // Broken rays end, and hit nothing.
    for (const float x : {nan, infinity, -infinity, 0.0f}) {
        EXPECT_FALSE(trace_any_host(sphere.bottoms, sphere.top, make_ray({0, 0, 0}, {x, nan, 0})));
        EXPECT_FALSE(trace_any_host(sphere.bottoms, sphere.top, make_ray({x, nan, 0}, {0, 0, 1})));
    }
    EXPECT_FALSE(trace_any_host(sphere.bottoms, sphere.top, make_ray({0, 0, 0}, {0, 0, 0})));
}

}  // namespace
}  // namespace parhelion::bvh::testing::bvh_trace_test
