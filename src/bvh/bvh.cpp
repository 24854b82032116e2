#include "bvh/bvh.h"

#include <cmath>

#include "base/error.h"

namespace parhelion::bvh {

namespace {

bool finite(glm::vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// Shifts what a tree of its own refers to, to its place in shared arrays.
void append_nodes(std::vector<shared::BvhNode>& to, const std::vector<shared::BvhNode>& from, uint32_t first_item) {
    const uint32_t base = static_cast<uint32_t>(to.size());
    for (shared::BvhNode node : from) {
        for (int c = 0; c < 4; ++c)
            if (node.child[c] != shared::kBvhEmpty) node.child[c] += (node.child[c] & shared::kBvhLeaf) != 0 ? first_item : base;
        to.push_back(node);
    }
}

}  // namespace

uint32_t add_bottom(Bottoms& bottoms, std::span<const BottomGeometry> geometries) {
    std::vector<shared::BvhTriangle> triangles;
    std::vector<Box> boxes;
    Bottoms::Entry entry;
    for (uint32_t g = 0; g < geometries.size(); ++g)
        for (uint32_t t = 0; t < geometries[g].triangles.size(); ++t) {
            const glm::uvec3 index = geometries[g].triangles[t];
            const glm::vec3 p0 = geometries[g].positions[index.x], p1 = geometries[g].positions[index.y], p2 = geometries[g].positions[index.z];
            if (!finite(p0) || !finite(p1) || !finite(p2)) continue;
            Box box;
            box.add(p0), box.add(p1), box.add(p2);
            entry.box.add(box);
            boxes.push_back(box);
            triangles.push_back({.p0 = p0, .geometry = g, .p1 = p1, .primitive = t, .p2 = p2});
        }
    if (bottoms.triangles.size() + triangles.size() > shared::kBvhFirstMask)
        throw Error(ErrorCode::Failed, "the scene has more than 2^29 triangles", "own BVH", "trace by pipeline or query");
    if (!triangles.empty()) {
        const WideTree tree = build_wide_tree(boxes, shared::kBvhMaxLeaf);
        entry.root = static_cast<uint32_t>(bottoms.nodes.size());
        append_nodes(bottoms.nodes, tree.nodes, static_cast<uint32_t>(bottoms.triangles.size()));
        for (const uint32_t i : tree.order) bottoms.triangles.push_back(triangles[i]);
    }
    bottoms.entries.push_back(entry);
    return static_cast<uint32_t>(bottoms.entries.size() - 1);
}

TopItem make_top_item(const Bottoms& bottoms, uint32_t entry, const glm::mat4& world_from_object, uint32_t instance) {
    const Box& box = bottoms.entries.at(entry).box;
    const glm::mat4 m(glm::inverse(glm::dmat4(world_from_object)));
    TopItem out{.item = {.object_from_world = {{m[0][0], m[1][0], m[2][0], m[3][0]}, {m[0][1], m[1][1], m[2][1], m[3][1]}, {m[0][2], m[1][2], m[2][2], m[3][2]}},
                         .instance = instance,
                         .root = bottoms.entries[entry].root}};
    if (box.empty()) return out;
    glm::dvec3 low(1e300), high(-1e300);
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 p((corner & 1) ? box.max.x : box.min.x, (corner & 2) ? box.max.y : box.min.y, (corner & 4) ? box.max.z : box.min.z);
        const glm::dvec3 w(glm::dmat4(world_from_object) * glm::dvec4(p, 1.0));
        low = glm::min(low, w), high = glm::max(high, w);
    }
    // The ray is rounded on its way into object space: the box grows by some units in the last place of its largest coordinate.
    const double reach = std::max(glm::length(low), glm::length(high));
    out.world_box.min = glm::vec3(low - reach * 1e-6);
    out.world_box.max = glm::vec3(high + reach * 1e-6);
    return out;
}

Top build_top(std::span<const TopItem> items) {
    std::vector<Box> boxes;
    std::vector<uint32_t> kept;
    for (uint32_t i = 0; i < items.size(); ++i)
        if (items[i].item.root != shared::kBvhEmpty) boxes.push_back(items[i].world_box), kept.push_back(i);
    Top top;
    WideTree tree = build_wide_tree(boxes, 1);
    top.nodes = std::move(tree.nodes);
    for (const uint32_t i : tree.order) top.items.push_back(items[kept[i]].item);
    return top;
}

}  // namespace parhelion::bvh
