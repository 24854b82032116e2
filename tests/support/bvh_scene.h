#pragma once
// What the tests of our own BVH share: random numbers, meshes, and tracing by brute force.
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "bvh/trace_host.h"
#include "lib/ray_triangle.glsl"

namespace parhelion::bvh::testing {

class Random {
public:
    explicit Random(uint32_t seed) : engine_(seed) {}
    float unit() { return static_cast<float>(engine_() >> 8) * 0x1p-24f; }  // [0, 1)
    float range(float low, float high) { return low + (high - low) * unit(); }
    uint32_t below(uint32_t n) { return engine_() % n; }
    glm::vec3 in_cube(float half) { return {range(-half, half), range(-half, half), range(-half, half)}; }
    glm::vec3 direction() {
        for (;;) {
            const glm::vec3 d = in_cube(1.0f);
            if (const float length = glm::length(d); length > 0.01f && length <= 1.0f) return d / length;
        }
    }

private:
    std::mt19937 engine_;
};

struct TestGeometry {
    std::vector<glm::vec3> positions;
    std::vector<glm::uvec3> triangles;

    void add(glm::vec3 a, glm::vec3 b, glm::vec3 c) {
        const uint32_t first = static_cast<uint32_t>(positions.size());
        positions.insert(positions.end(), {a, b, c});
        triangles.push_back({first, first + 1, first + 2});
    }
};
using TestMesh = std::vector<TestGeometry>;

// Triangles of this size scattered in a cube.
inline TestGeometry make_soup(Random& random, uint32_t count, float half_cube, float size) {
    TestGeometry soup;
    for (uint32_t i = 0; i < count; ++i) {
        const glm::vec3 p = random.in_cube(half_cube);
        soup.add(p, p + random.in_cube(size), p + random.in_cube(size));
    }
    return soup;
}

// A closed sphere of 20 * 4^levels triangles with shared corners, counter-clockwise from outside.
TestGeometry make_icosphere(uint32_t levels, float radius, glm::vec3 middle = glm::vec3(0.0f));

// A closed box with shared corners, counter-clockwise from outside.
TestGeometry make_box(glm::vec3 low, glm::vec3 high);

void append(TestGeometry& to, const TestGeometry& from);

// Walls of two triangles, long slanted beams, and small things between them: large triangles that spatial splits cut.
TestGeometry make_hall(Random& random);

struct TestInstance {
    uint32_t mesh = 0;
    glm::mat4 world_from_object{1.0f};
    uint32_t mask = 0xFFu;
};

// Meshes and instances with both levels built; instances are numbered in order.
struct TestScene {
    TestScene(std::vector<TestMesh> all_meshes, std::vector<TestInstance> all_instances);
    explicit TestScene(TestGeometry geometry) : TestScene({{std::move(geometry)}}, {{}}) {}

    std::vector<TestMesh> meshes;
    std::vector<TestInstance> instances;
    std::vector<TopItem> items;
    Bottoms bottoms;
    Top top;

    static Layout layout;  // of the nodes of scenes that are made
};

// A fixture whose scenes have nodes of each layout in turn.
class EachLayout : public ::testing::TestWithParam<Layout> {
protected:
    void SetUp() override { TestScene::layout = GetParam(); }
    void TearDown() override { TestScene::layout = Layout::Four; }
};
inline std::string layout_of(const ::testing::TestParamInfo<Layout>& info) { return std::string(layout_name(info.param)); }

// Tries every triangle of every instance with the triangle test of the traversal: must agree with it to the last bit.
bool trace_brute_force(const TestScene& scene, const shared::TraversalRay& ray, shared::TraversalHit& best, const AcceptHit& accept = {});

inline shared::TraversalRay make_ray(glm::vec3 origin, glm::vec3 direction, float t_min = 0.0f, float t_max = 3.4e38f, uint32_t mask = 0xFFu) {
    return {.origin_ws = origin, .t_min = t_min, .direction_ws = direction, .t_max = t_max, .mask = mask, .alpha_key = 0};
}

// Traces closest and any by both methods and returns what differs; empty if nothing.
std::string compare_with_brute_force(const TestScene& scene, const shared::TraversalRay& ray, const AcceptHit& accept = {});

}  // namespace parhelion::bvh::testing
