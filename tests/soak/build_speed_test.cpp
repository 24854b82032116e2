// What it costs to build our bottom levels, and what comes of it: time and processor time a triangle, the trees' expected cost and their
// bytes. Prints a table, which docs/performance.md quotes; `PARHELION_SOAK_TRIANGLES` sets the size of the forest.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/parallel.h"
#include "bvh/bvh.h"
#include "scene/load.h"

namespace parhelion::testing::build_speed_test {
namespace {

constexpr int kRounds = 3;
constexpr size_t kBatch = 64;  // meshes that are built side by side, as they are for a scene

struct Sum {
    size_t triangles = 0, references = 0, bytes = 0;
    double seconds = 1e300, cpu = 0;  // of the fastest round
    double cost = 0;                  // mean of the meshes, each by its triangles
};

// Expected triangle tests of a ray that crosses the root, by the surface area heuristic.
double expected_cost(const bvh::Nodes& nodes, std::span<const shared::BvhTriangle> triangles) {
    const auto box = [](const shared::BvhNode& node, int c) { return bvh::Box{{node.min_x[c], node.min_y[c], node.min_z[c]}, {node.max_x[c], node.max_y[c], node.max_z[c]}}; };
    bvh::Box root;
    double sum = 0;
    for (size_t n = 0; n < nodes.size(); ++n) {
        const shared::BvhNode node = nodes.read(n);
        for (int c = 0; c < 4; ++c) {
            const uint32_t child = node.child[c];
            if (child == shared::kBvhEmpty) continue;
            if (n == 0) root.add(box(node, c));
            const double size = (child & shared::kBvhLeaf) != 0 ? triangles[child & shared::kBvhItemMask].rest + 1.0 : nodes.layout == bvh::Layout::Binary ? 2.0 : 1.5;
            sum += size * double(box(node, c).half_area());
        }
    }
    return sum / double(root.half_area());
}

Sum build(const Scene& scene, bvh::Layout layout) {
    std::vector<std::vector<bvh::BottomGeometry>> meshes;
    for (const auto& [handle, mesh] : scene.meshes()) {
        meshes.emplace_back();
        for (const Primitive& p : mesh.primitives) meshes.back().push_back({p.positions, p.triangles});
    }
    Sum best;
    for (int round = 0; round < kRounds; ++round) {
        Sum sum{.seconds = 0};
        for (size_t first = 0; first < meshes.size(); first += kBatch) {
            std::vector<bvh::Bottoms> built(std::min(kBatch, meshes.size() - first));
            const std::clock_t cpu = std::clock();
            const auto begin = std::chrono::steady_clock::now();
            parallel_for(built.size(), 1, [&](size_t from, size_t to) {
                for (size_t i = from; i < to; ++i) built[i].nodes.layout = layout, bvh::add_bottom(built[i], meshes[first + i]);
            });
            sum.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
            sum.cpu += double(std::clock() - cpu) / CLOCKS_PER_SEC;
            for (size_t i = 0; i < built.size(); ++i) {
                size_t triangles = 0;
                for (const bvh::BottomGeometry& geometry : meshes[first + i]) triangles += geometry.triangles.size();
                sum.triangles += triangles;
                sum.references += built[i].triangles.size();
                sum.bytes += built[i].nodes.bytes() + built[i].triangles.size() * sizeof(shared::BvhTriangle);
                sum.cost += double(triangles) * expected_cost(built[i].nodes, built[i].triangles);
            }
        }
        if (sum.seconds < best.seconds) best = sum;
    }
    best.cost /= double(best.triangles);
    return best;
}

TEST(BuildSpeed, of_bottom_levels) {
    const char* wanted = std::getenv("PARHELION_SOAK_TRIANGLES");
    struct Case {
        const char *name, *scene;
        uint64_t triangles;
    };
    const Case cases[] = {{"room S", "builtin:room", 10'368}, {"room M", "builtin:room", 249'600}, {"room L", "builtin:room", 1'997'568},
                          {"forest", "builtin:forest", wanted ? std::strtoull(wanted, nullptr, 10) : 1'000'000}};
    for (const Case& c : cases) {
        const LoadedScene loaded = load_scene(c.scene, {.builtin = {.triangles = c.triangles}});
        for (const bvh::Layout layout : bvh::kLayouts) {
            const Sum sum = build(loaded.scene, layout);
            const double n = double(sum.triangles);
            std::printf("%s\n", fmt::format("{:8} {:9} triangles, {:8} {:.3f} us a triangle, {:.3f} of processors; cost {:.4f}, {:.3f} references, {:.1f} bytes", c.name, sum.triangles, bvh::layout_name(layout),
                                            1e6 * sum.seconds / n, 1e6 * sum.cpu / n, sum.cost, double(sum.references) / n, double(sum.bytes) / n)
                                    .c_str());
            EXPECT_GT(sum.triangles, c.triangles * 9 / 10);
        }
    }
}

}  // namespace
}  // namespace parhelion::testing::build_speed_test
