// What a refit leans on: the plan holds every triangle once, and its nodes hang together.
#include "bvh/refit.h"
#include "support/bvh_scene.h"

namespace parhelion::bvh::testing {
namespace {

class RefitPlans : public EachLayout {};
INSTANTIATE_TEST_SUITE_P(Nodes, RefitPlans, ::testing::ValuesIn(kLayouts), layout_of);

TEST_P(RefitPlans, hold_every_triangle_once_and_know_their_parents) {
    Random random(1);
    TestGeometry flat = make_soup(random, 300, 1.0f, 0.3f);
    for (glm::vec3& p : flat.positions) p *= glm::vec3(1.0f, 0.0f, 0.0f);  // degenerate triangles may grow: they count
    const TestMesh mesh{make_soup(random, 2000, 2.0f, 0.4f), flat, make_icosphere(1, 1.0f)};
    std::vector<BottomGeometry> geometries;
    std::vector<std::vector<int>> times;
    for (const TestGeometry& g : mesh) geometries.push_back({g.positions, g.triangles}), times.emplace_back(g.triangles.size(), 0);
    const RefitPlan plan = plan_refit(geometries, GetParam());

    std::vector<int> seen(plan.triangles.size(), 0), named(plan.nodes.size(), 0);
    EXPECT_EQ(plan.nodes[0].parent, shared::kBvhEmpty);
    for (uint32_t n = 0; n < plan.nodes.size(); ++n)
        for (uint32_t c = 0; c < 4; ++c) {
            const uint32_t child = plan.nodes[n].child[static_cast<int>(c)];
            if (child == shared::kBvhEmpty) continue;
            EXPECT_LT(c, node_width(GetParam()));
            if ((child & shared::kBvhLeaf) == 0) {
                ASSERT_LT(child, plan.nodes.size());
                EXPECT_EQ(plan.nodes[child].parent, n);
                ++named[child];
                continue;
            }
            for (uint32_t i = child & shared::kBvhItemMask, rest = 1; rest != 0; ++i) {
                ASSERT_LT(i, plan.triangles.size());
                rest = plan.triangles[i].rest;
                ++seen[i];
                ++times[plan.triangles[i].geometry][plan.triangles[i].primitive];
            }
        }
    EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), static_cast<std::ptrdiff_t>(seen.size()));
    EXPECT_EQ(std::count(named.begin() + 1, named.end(), 1), static_cast<std::ptrdiff_t>(named.size()) - 1);
    for (const std::vector<int>& of_geometry : times) EXPECT_EQ(std::count(of_geometry.begin(), of_geometry.end(), 1), static_cast<std::ptrdiff_t>(of_geometry.size()));
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
}  // namespace parhelion::bvh::testing
