// The traversal of our own BVH on the device against the same traversal on the host.
#include <bit>
#include <cmath>
#include <cstdlib>

#include "support/bvh_scene.h"
#include "support/gpu_helpers.h"

namespace parhelion::bvh::testing::bvh_test {
namespace {

using namespace parhelion::testing;

class BvhDevice : public GpuTest, public ::testing::WithParamInterface<Layout> {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        TestScene::layout = GetParam();
    }
    void TearDown() override {
        TestScene::layout = Layout::Four;
        GpuTest::TearDown();
    }
};
INSTANTIATE_TEST_SUITE_P(Nodes, BvhDevice, ::testing::ValuesIn(kLayouts), layout_of);

constexpr uint32_t kWidth = 256;  // rays in a row; their number is a multiple of it, and of four rows

struct Push {
    shared::BvhAddresses bvh;
    uint64_t rays, hits;
    uint32_t width, any;
};

std::vector<shared::TraversalHit> trace(const gpu::DevicePtr& device, const TestScene& scene, const std::vector<shared::TraversalRay>& rays, bool any, uint32_t loop = 0) {
    const gpu::Buffer top_nodes = mapped_buffer(device, scene.top.nodes.words), top_items = mapped_buffer(device, scene.top.items),
                      nodes = mapped_buffer(device, scene.bottoms.nodes.words), triangles = mapped_buffer(device, scene.bottoms.triangles), ray_buffer = mapped_buffer(device, rays),
                      hits(device, "test/hits", rays.size() * sizeof(shared::TraversalHit), gpu::MemoryKind::Readback);
    gpu::CommandList commands(device);
    commands.bind(gpu::Program::get(device, test_shader_pack(), "device/bvh_trace", "", false, static_cast<uint32_t>(scene.top.nodes.layout) | loop), nullptr, {},
                  bytes_of(Push{{top_nodes.address(), top_items.address(), nodes.address(), triangles.address()}, ray_buffer.address(), hits.address(), kWidth, any}));
    commands.dispatch(kWidth / 8, static_cast<uint32_t>(rays.size()) / kWidth / 4, 1);
    EXPECT_TRUE(gpu::wait(device, gpu::submit(device, std::move(commands))));
    const auto out = hits.mapped_as<shared::TraversalHit>();
    return {out.begin(), out.end()};
}

TEST_P(BvhDevice, the_device_finds_what_the_host_finds) {
    Random random(1);
    std::vector<TestInstance> instances;
    for (uint32_t i = 0; i < 40; ++i) {
        glm::mat4 m(1.0f);
        for (int c = 0; c < 3; ++c) m[c] = glm::vec4(random.in_cube(0.8f), 0.0f);
        m[3] = glm::vec4(random.in_cube(3.0f), 1.0f);
        instances.push_back({.mesh = i % 2, .world_from_object = m, .mask = i % 3 == 0 ? 1u : 2u});
    }
    const TestScene scene({{make_soup(random, 2000, 2.0f, 0.4f), make_soup(random, 300, 1.0f, 1.0f)}, {make_icosphere(3, 1.0f)}}, std::move(instances));
    std::vector<shared::TraversalRay> rays;
    for (uint32_t i = 0; i < kWidth * 64; ++i) {
        const glm::vec3 origin = random.in_cube(5.0f);
        rays.push_back(make_ray(origin, i % 16 == 0 ? glm::vec3(0, -1, 0) : random.in_cube(2.0f) - origin, 0.0f, i % 5 == 0 ? 0.7f : 3.4e38f, 1u + i % 3));
        rays.back().alpha_key = i % 2;
    }
    const std::vector<shared::TraversalHit> closest = trace(device(), scene, rays, false), any = trace(device(), scene, rays, true);
    const AcceptHit filter = [](uint32_t instance, uint32_t geometry, uint32_t primitive, glm::vec2, bool front) { return (instance + geometry + primitive + front) % 3 != 0; };
    int hits = 0, other_triangle = 0;
    for (uint32_t i = 0; i < rays.size(); ++i) {
        shared::TraversalHit expected{};
        const bool found = trace_closest_host(scene.bottoms, scene.top, rays[i], expected, rays[i].alpha_key != 0 ? filter : AcceptHit{});
        EXPECT_EQ(any[i].t > 0.0f, closest[i].t > 0.0f) << i;
        hits += found;
        const shared::TraversalHit& hit = closest[i];
        if (!found && hit.t < 0.0f) continue;
        // A division may differ in its last bits, and with it a ray that just touches an edge.
        other_triangle += !found || hit.t < 0.0f || hit.instance != expected.instance || hit.geometry != expected.geometry || hit.primitive != expected.primitive;
        // Coordinates are a few metres large: their roundings bound how well a distance near 0 is known.
        EXPECT_NEAR(hit.t, expected.t, 1e-4f * expected.t + 1e-6f) << i;
    }
    EXPECT_GT(hits, 8000);
    EXPECT_LE(other_triangle, 3);
}

// Each ray sees the same bits in every layout and by both loops: what a device traces does not show in a picture.
TEST_P(BvhDevice, every_layout_and_loop_gives_the_same_hits) {
    Random random(3);
    const TestMesh soup{make_soup(random, 3000, 2.0f, 0.4f)}, sphere{make_icosphere(3, 1.0f)};
    std::vector<TestInstance> instances;
    for (uint32_t i = 0; i < 30; ++i) {
        glm::mat4 m(1.0f);
        for (int c = 0; c < 3; ++c) m[c] = glm::vec4(random.in_cube(0.8f), 0.0f);
        m[3] = glm::vec4(random.in_cube(3.0f), 1.0f);
        instances.push_back({.mesh = i % 2, .world_from_object = m});
    }
    std::vector<shared::TraversalRay> rays;
    for (uint32_t i = 0; i < kWidth * 64; ++i) {
        const glm::vec3 origin = random.in_cube(5.0f);
        rays.push_back(make_ray(origin, random.in_cube(2.0f) - origin));
        rays.back().alpha_key = i % 2;
    }
    const TestScene scene({soup, sphere}, instances);
    TestScene::layout = Layout::Four;
    const TestScene plain({soup, sphere}, instances);
    const std::vector<shared::TraversalHit> expected = trace(device(), plain, rays, false), any = trace(device(), scene, rays, true, shared::kBvhRounds);
    for (const uint32_t loop : {0u, shared::kBvhRounds}) {
        const std::vector<shared::TraversalHit> hits = trace(device(), scene, rays, false, loop);
        for (size_t i = 0; i < rays.size(); ++i) {
            ASSERT_EQ(std::bit_cast<uint32_t>(hits[i].t), std::bit_cast<uint32_t>(expected[i].t)) << i;
            ASSERT_EQ(any[i].t > 0.0f, expected[i].t > 0.0f) << i;
            if (hits[i].t < 0.0f) continue;
            ASSERT_TRUE(hits[i].instance == expected[i].instance && hits[i].geometry == expected[i].geometry && hits[i].primitive == expected[i].primitive) << i;
            ASSERT_TRUE(hits[i].barycentrics == expected[i].barycentrics) << i;
        }
    }
}

// A million rays for all layouts together; more where PARHELION_LEAK_RAYS names their number for each (docs/testing.md).
TEST_P(BvhDevice, no_ray_slips_out_of_a_closed_mesh) {
    Random random(2);
    const char* wanted = std::getenv("PARHELION_LEAK_RAYS");
    const uint64_t ray_count = wanted ? std::strtoull(wanted, nullptr, 10) : 340'000;
    const glm::vec3 far(1e6f, -1e6f, 1e6f);
    const TestGeometry unit = make_icosphere(4, 1.0f), far_away = make_icosphere(4, 100.0f, far);
    uint64_t traced = 0, leaks = 0;
    for (uint32_t batch = 0; traced < ray_count; ++batch) {
        // Sheared and mirrored, at the origin or 10^6 m away, where a coordinate resolves 1/16 m; or that far in the corners themselves.
        const float place = batch % 3 == 1 ? 1e6f : 0.0f;
        const TestGeometry& sphere = batch % 3 == 2 ? far_away : unit;
        const glm::vec3 middle = batch % 3 == 2 ? far : glm::vec3(0.0f);
        glm::mat4 m(1.0f);
        while (batch % 3 != 2 && (m == glm::mat4(1.0f) || std::abs(glm::determinant(glm::mat3(m))) < (place > 1e5f ? 1e6f : 1.0f)))
            for (int c = 0; c < 3; ++c) m[c] = glm::vec4(random.in_cube(place > 1e5f ? 200.0f : 2.0f), 0.0f);
        m[3] = glm::vec4(random.in_cube(place), 1.0f);
        const float spread = batch % 3 == 2 ? 10.0f : 0.1f;
        const TestScene scene({{sphere}}, {{.world_from_object = m}});
        std::vector<shared::TraversalRay> rays;
        for (uint32_t i = 0; i < kWidth * 448; ++i) {
            const glm::uvec3 t = sphere.triangles[random.below(static_cast<uint32_t>(sphere.triangles.size()))];
            const glm::vec3 a = sphere.positions[t.x], b = sphere.positions[t.y];
            const glm::vec3 target = i % 3 == 0 ? a : a + random.unit() * (b - a), origin(m * glm::vec4(middle + random.in_cube(spread), 1.0f));
            rays.push_back(make_ray(origin, glm::vec3(m * glm::vec4(target, 1.0f)) - origin));
        }
        for (const shared::TraversalHit& hit : trace(device(), scene, rays, batch % 2 == 1)) leaks += hit.t < 0.0f;
        traced += rays.size();
    }
    EXPECT_EQ(leaks, 0u) << "of " << traced;
}

}  // namespace
}  // namespace parhelion::bvh::testing::bvh_test
