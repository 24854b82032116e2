#include "bvh/wide_tree.h"

#include <algorithm>

#include "base/parallel.h"
#include "bvh/binary_tree.h"
#include "bvh/collapse.h"

namespace parhelion::bvh {

namespace {

Box box_of(const shared::BvhTriangle& t) {
    Box box;
    if (in_range(t.p0) && in_range(t.p1) && in_range(t.p2)) box.add(t.p0), box.add(t.p1), box.add(t.p2);
    return box;
}

constexpr size_t kChunk = 1u << 15;

// References to the boxes that are not empty; returns their number.
template <class BoxOf>
uint32_t make_references(Reference* to, size_t count, BoxOf&& box_of_item) {
    std::vector<size_t> ends((count + kChunk - 1) / kChunk);
    parallel_for(ends.size(), 1, [&](size_t first, size_t last) {
        for (size_t chunk = first; chunk < last; ++chunk) {
            size_t end = chunk * kChunk;
            for (size_t i = end; i < std::min(count, (chunk + 1) * kChunk); ++i)
                if (const Box box = box_of_item(i); !box.empty()) to[end++] = {box.min, static_cast<uint32_t>(i), box.max, 0};
            ends[chunk] = end;
        }
    });
    size_t used = 0;
    for (size_t chunk = 0; chunk < ends.size(); ++chunk) {
        const size_t begin = chunk * kChunk, size = ends[chunk] - begin;
        if (used < begin) std::copy_n(to + begin, size, to + used);
        used += size;
    }
    return static_cast<uint32_t>(used);
}

template <class BoxOf>
WideTree build(size_t count, BoxOf&& box_of_item, std::span<const shared::BvhTriangle> triangles, const BuildOptions& options) {
    const auto slots = static_cast<uint32_t>(double(count) * (1.0 + options.growth));
    auto references = std::make_unique_for_overwrite<Reference[]>(slots);
    const uint32_t used = make_references(references.get(), count, box_of_item);
    const auto used_slots = std::min(slots, static_cast<uint32_t>(double(used) * (1.0 + options.growth)));
    const BinaryLimits limits{.max_leaf = options.max_leaf, .max_height = options.width / 2 * options.max_depth};
    return collapse(build_binary_tree(std::move(references), used, used_slots, triangles, limits), options.width, options.max_leaf, options.max_depth,
                    options.node_cost > 0.0f ? options.node_cost : node_cost(options.width));
}

}  // namespace

WideTree build_wide_tree(std::span<const Box> boxes, uint32_t width, uint32_t max_leaf, uint32_t max_depth, float cost_of_node) {
    return build(boxes.size(), [&](size_t i) { return boxes[i]; }, {}, {.width = width, .max_leaf = max_leaf, .max_depth = max_depth, .node_cost = cost_of_node});
}

WideTree build_wide_tree(std::span<const shared::BvhTriangle> triangles, const BuildOptions& options) {
    return build(triangles.size(), [&](size_t i) { return box_of(triangles[i]); }, triangles, options);
}

TreeStatistics measure(const WideTree& tree) {
    TreeStatistics statistics;
    Box root;
    for (const Box& box : tree.nodes.front().box) root.add(box);
    double inner = root.half_area(), leaf = 0;
    std::vector<std::pair<uint32_t, size_t>> stack{{0, 1}};
    while (!stack.empty()) {
        const auto [index, depth] = stack.back();
        stack.pop_back();
        ++statistics.nodes;
        statistics.depth = std::max(statistics.depth, depth);
        for (uint32_t c = 0; c < tree.width; ++c) {
            const uint32_t child = tree.nodes[index].child[c];
            if (child == shared::kBvhEmpty) continue;
            const double area = tree.nodes[index].box[c].half_area();
            if ((child & shared::kBvhLeaf) == 0) {
                inner += area;
                stack.push_back({child, depth + 1});
                continue;
            }
            const size_t size = tree.rest[child & shared::kBvhItemMask] + size_t(1);
            leaf += area * double(size);
            ++statistics.leaves;
            statistics.references += size;
        }
    }
    if (root.half_area() > 0.0f) statistics.cost = (node_cost(tree.width) * inner + leaf) / root.half_area();
    return statistics;
}

}  // namespace parhelion::bvh
