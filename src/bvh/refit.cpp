#include "bvh/refit.h"

#include "base/error.h"
#include "base/parallel.h"

namespace parhelion::bvh {

namespace {

constexpr size_t kRefitGrain = 1u << 15;

// Box and identity of every triangle.
void read_triangles(std::span<const BottomGeometry> geometries, std::vector<Box>& boxes, std::vector<shared::RefitTriangle>& triangles) {
    size_t first = 0;
    for (uint32_t g = 0; g < geometries.size(); ++g) {
        const BottomGeometry& geometry = geometries[g];
        parallel_for(geometry.triangles.size(), kRefitGrain, [&](size_t begin, size_t end) {
            for (size_t t = begin; t < end; ++t) {
                triangles[first + t] = {.geometry = g, .primitive = geometry.first_primitive + static_cast<uint32_t>(t), .rest = 0};
                for (int corner = 0; corner < 3; ++corner) boxes[first + t].add(geometry.positions[geometry.triangles[t][corner]]);
            }
        });
        first += geometry.triangles.size();
    }
}

}  // namespace

RefitPlan plan_refit(std::span<const BottomGeometry> geometries, Layout layout) {
    size_t count = 0;
    for (const BottomGeometry& geometry : geometries) count += geometry.triangles.size();
    if (count > shared::kBvhItemMask) throw Error(ErrorCode::Failed, "a mesh has more than 2^31 triangles", "own BVH", "trace by pipeline or query");
    std::vector<Box> boxes(count);
    std::vector<shared::RefitTriangle> triangles(count);
    read_triangles(geometries, boxes, triangles);
    const WideTree tree = build_wide_tree(boxes, node_width(layout), shared::kBvhMaxLeaf, max_bottom_depth(layout), bottom_node_cost(layout));
    PARHELION_CHECK(tree.order.size() == count, "{} triangles in the leaves of a tree of {}", tree.order.size(), count);

    RefitPlan plan;
    plan.nodes.resize(tree.nodes.size());
    plan.nodes[0].parent = shared::kBvhEmpty;
    for (uint32_t n = 0; n < tree.nodes.size(); ++n)
        for (int c = 0; c < 4; ++c) {
            const uint32_t child = tree.nodes[n].child[c];
            plan.nodes[n].child[c] = child;
            if ((child & shared::kBvhLeaf) == 0) plan.nodes[child].parent = n;
        }
    plan.triangles.resize(count);
    for (size_t i = 0; i < count; ++i) {
        plan.triangles[i] = triangles[tree.order[i]];
        plan.triangles[i].rest = tree.rest[i];
    }
    return plan;
}

}  // namespace parhelion::bvh
