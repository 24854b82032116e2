// What a refit leans on: the plan holds every triangle once, and its nodes hang together.
#include "bvh/refit.h"
#include "support/bvh_scene.h"

namespace parhelion::bvh::testing::refit_plan_test {
namespace {

class RefitPlans : public EachLayout {};
INSTANTIATE_TEST_SUITE_P(Nodes, RefitPlans, ::testing::ValuesIn(kLayouts), layout_of);

// Coverage, leaf sizes, depth, and who knows whom.
void check_plan(const RefitPlan& plan, const TestMesh& mesh, Layout layout) {
    std::vector<std::vector<int>> times;
    for (const TestGeometry& g : mesh) times.emplace_back(g.triangles.size(), 0);
    std::vector<int> seen(plan.triangles.size(), 0), named(plan.nodes.size(), 0);
    ASSERT_EQ(plan.nodes.at(0).parent, shared::kBvhEmpty);
    std::vector<std::pair<uint32_t, uint32_t>> stack{{0u, 1u}};  // nodes and their depth
    while (!stack.empty()) {
        const auto [n, depth] = stack.back();
        stack.pop_back();
        ASSERT_LE(depth, max_bottom_depth(layout));
        for (uint32_t c = 0; c < 4; ++c) {
            const uint32_t child = plan.nodes[n].child[static_cast<int>(c)];
            if (child == shared::kBvhEmpty) continue;
            ASSERT_LT(c, node_width(layout));
            if ((child & shared::kBvhLeaf) == 0) {
                ASSERT_LT(child, plan.nodes.size());
                ASSERT_EQ(plan.nodes[child].parent, n);
                ASSERT_EQ(named[child]++, 0) << "node " << child << " has two parents";
                stack.push_back({child, depth + 1});
                continue;
            }
            uint32_t i = child & shared::kBvhItemMask;
            const uint32_t first = i;
            for (uint32_t rest = 1; rest != 0; ++i) {
                ASSERT_LT(i, plan.triangles.size());
                rest = plan.triangles[i].rest;
                ++seen[i];
                ++times.at(plan.triangles[i].geometry).at(plan.triangles[i].primitive);
            }
            ASSERT_LE(i - first, shared::kBvhMaxLeaf);
        }
    }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
    EXPECT_EQ(std::count(named.begin() + 1, named.end(), 1), static_cast<std::ptrdiff_t>(named.size()) - 1);
    for (const std::vector<int>& of_geometry : times) EXPECT_EQ(std::count(of_geometry.begin(), of_geometry.end(), 1), static_cast<std::ptrdiff_t>(of_geometry.size()));
}

RefitPlan plan_of(const TestMesh& mesh, Layout layout) {
    std::vector<BottomGeometry> geometries;
    for (const TestGeometry& g : mesh) geometries.push_back({g.positions, g.triangles});
    return plan_refit(geometries, layout);
}

TEST_P(RefitPlans, hold_every_triangle_once_and_know_their_parents) {
    Random random(1);
    std::vector<TestMesh> meshes;
    for (const uint32_t count : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 17u, 100u, 1000u, 20000u, 40000u})
        meshes.push_back({make_soup(random, count / 3, 10.0f, 1.0f), {}, make_soup(random, count - count / 3, 3.0f, 0.2f)});
    meshes.push_back({make_icosphere(5, 2.0f)});
    double nodes = 0, triangles = 0;
    for (size_t m = 0; m < meshes.size(); ++m) {
        SCOPED_TRACE(m);
        const RefitPlan plan = plan_of(meshes[m], GetParam());
        check_plan(plan, meshes[m], GetParam());
        nodes += double(plan.nodes.size()), triangles += double(plan.triangles.size());
    }
    // A deformed form takes as much as a mesh that keeps its shape.
    EXPECT_LE(node_bytes(GetParam()) * nodes / triangles + double(sizeof(shared::BvhTriangle)), GetParam() == Layout::Compact ? 64.0 : 96.0);
}

// They may grow: every one counts.
TEST_P(RefitPlans, hold_degenerate_triangles_too) {
    Random random(2);
    TestGeometry flat = make_soup(random, 300, 1.0f, 0.3f), same, point, line, shared_center, huge, far = make_soup(random, 500, 1.0f, 0.1f);
    for (glm::vec3& p : flat.positions) p *= glm::vec3(1.0f, 0.0f, 0.0f);
    for (glm::vec3& p : far.positions) p += glm::vec3(1e6f, -1e6f, 1e6f);
    for (int i = 0; i < 1000; ++i) {
        same.add({1, 2, 3}, {2, 2, 3}, {1, 3, 3});
        point.add({5, 5, 5}, {5, 5, 5}, {5, 5, 5});
        line.add({float(i), 0, 0}, {float(i) + 1, 0, 0}, {float(i) + 0.5f, 0, 0});
        const float s = float(i + 1);
        shared_center.add({-s, -s, 0}, {s, s, 0}, {s, -s, 0});
        huge.add(random.in_cube(9e17f), random.in_cube(9e17f), random.in_cube(9e17f));
    }
    for (const TestMesh& mesh : {TestMesh{}, TestMesh{{}, {}}, TestMesh{same}, TestMesh{point}, TestMesh{line}, TestMesh{shared_center}, TestMesh{huge}, TestMesh{far},
                                 TestMesh{make_soup(random, 2000, 2.0f, 0.4f), flat, make_icosphere(1, 1.0f)}})
        check_plan(plan_of(mesh, GetParam()), mesh, GetParam());
}

TEST_P(RefitPlans, one_triangle_is_a_tree_too) {
    const TestGeometry one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
    const BottomGeometry geometry{one.positions, one.triangles};
    const RefitPlan plan = plan_refit({&geometry, 1}, GetParam());
    ASSERT_EQ(plan.nodes.size(), 1u);
    EXPECT_EQ(plan.nodes[0].child[0], shared::kBvhLeaf);
    ASSERT_EQ(plan.triangles.size(), 1u);
    EXPECT_EQ(plan.triangles[0].rest, 0u);
}

}  // namespace
}  // namespace parhelion::bvh::testing::refit_plan_test
