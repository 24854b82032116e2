#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "base/error.h"
#include "bvh/bvh.h"

namespace parhelion::bvh {

namespace {

constexpr uint32_t kBins = 16;
constexpr uint32_t kMaxBinaryDepth = 2 * shared::kBvhMaxDepth - 1;
constexpr float kTraversalCost = 1.0f;  // of a node, in triangle tests

struct BinaryNode {
    Box box;
    uint32_t left = 0, right = 0;         // children; left == 0: a leaf
    uint32_t first = 0, count = 0;
};

struct Builder {
    std::span<const Box> boxes;
    std::vector<glm::vec3> centers;
    std::vector<uint32_t> order;
    std::vector<BinaryNode> nodes;
    uint32_t max_leaf;

    struct Task {
        uint32_t node, depth;
    };

    void build() {
        order.resize(boxes.size());
        std::iota(order.begin(), order.end(), 0u);
        centers.resize(boxes.size());
        for (size_t i = 0; i < boxes.size(); ++i) centers[i] = 0.5f * boxes[i].min + 0.5f * boxes[i].max;
        nodes.push_back({.first = 0, .count = static_cast<uint32_t>(boxes.size())});
        std::vector<Task> tasks{{0, 0}};
        while (!tasks.empty()) {
            const Task task = tasks.back();
            tasks.pop_back();
            const uint32_t middle = split(task);
            if (middle == 0) continue;
            const uint32_t first = nodes[task.node].first, count = nodes[task.node].count, left = static_cast<uint32_t>(nodes.size());
            nodes.push_back({.first = first, .count = middle - first});
            nodes.push_back({.first = middle, .count = first + count - middle});
            nodes[task.node].left = left;
            nodes[task.node].right = left + 1;
            tasks.push_back({left, task.depth + 1});
            tasks.push_back({left + 1, task.depth + 1});
        }
    }

    // Orders the node's items into two halves; returns where the second begins, 0 for a leaf.
    uint32_t split(const Task& task) {
        BinaryNode& node = nodes[task.node];
        Box center_box;
        for (uint32_t i = node.first; i < node.first + node.count; ++i) node.box.add(boxes[order[i]]), center_box.add(centers[order[i]]);
        if (node.count <= 1) return 0;
        // When the levels that are left just suffice to halve down to leaves, halve.
        const uint32_t halvings = static_cast<uint32_t>(std::bit_width((node.count - 1) / max_leaf));
        if (task.depth + halvings >= kMaxBinaryDepth) return node.count <= max_leaf ? 0 : median(node, center_box);
        return sah(node, center_box);
    }

    uint32_t median(const BinaryNode& node, const Box& center_box) {
        const glm::vec3 extent = center_box.max - center_box.min;
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const auto first = order.begin() + node.first, middle = first + node.count / 2, last = first + node.count;
        std::nth_element(first, middle, last, [&](uint32_t a, uint32_t b) { return centers[a][axis] != centers[b][axis] ? centers[a][axis] < centers[b][axis] : a < b; });
        return node.first + node.count / 2;
    }

    uint32_t sah(const BinaryNode& node, const Box& center_box) {
        const glm::vec3 extent = center_box.max - center_box.min;
        float best_cost = node.count <= max_leaf ? static_cast<float>(node.count) * node.box.half_area() : 3e38f;
        int best_axis = -1;
        uint32_t best_bin = 0;
        for (int axis = 0; axis < 3; ++axis) {
            if (!(extent[axis] > 0.0f)) continue;
            std::array<Box, kBins> bins;
            std::array<uint32_t, kBins> counts{};
            for (uint32_t i = node.first; i < node.first + node.count; ++i) {
                const uint32_t bin = bin_of(centers[order[i]][axis], center_box, axis);
                bins[bin].add(boxes[order[i]]);
                ++counts[bin];
            }
            std::array<float, kBins> right_cost{};
            Box right;
            uint32_t right_count = 0;
            for (uint32_t b = kBins - 1; b > 0; --b) {
                right.add(bins[b]);
                right_count += counts[b];
                right_cost[b] = right.half_area() * static_cast<float>(right_count);
            }
            Box left;
            uint32_t left_count = 0;
            for (uint32_t b = 1; b < kBins; ++b) {
                left.add(bins[b - 1]);
                left_count += counts[b - 1];
                if (left_count == 0 || left_count == node.count) continue;
                const float cost = kTraversalCost * node.box.half_area() + left.half_area() * static_cast<float>(left_count) + right_cost[b];
                if (cost < best_cost) best_cost = cost, best_axis = axis, best_bin = b;
            }
        }
        if (best_axis < 0) return node.count <= max_leaf ? 0 : median(node, center_box);
        const auto first = order.begin() + node.first;
        const auto middle = std::stable_partition(first, first + node.count, [&](uint32_t i) { return bin_of(centers[i][best_axis], center_box, best_axis) < best_bin; });
        return static_cast<uint32_t>(middle - order.begin());
    }

    static uint32_t bin_of(float center, const Box& box, int axis) {
        const float scaled = (center - box.min[axis]) / (box.max[axis] - box.min[axis]) * static_cast<float>(kBins);
        return std::min(static_cast<uint32_t>(std::max(scaled, 0.0f)), kBins - 1);
    }
};

// Two binary levels become one 4-wide node.
void collapse(const Builder& builder, std::vector<shared::BvhNode>& out) {
    struct Task {
        uint32_t binary, wide;
    };
    out.push_back({});
    std::vector<Task> tasks{{0, 0}};
    while (!tasks.empty()) {
        const Task task = tasks.back();
        tasks.pop_back();
        std::vector<uint32_t> children;
        const auto expand = [&](uint32_t n, auto&& take) {
            const BinaryNode& node = builder.nodes[n];
            if (node.left == 0) take(n);
            else take(node.left), take(node.right);
        };
        expand(task.binary, [&](uint32_t child) { child == task.binary ? children.push_back(child) : expand(child, [&](uint32_t grandchild) { children.push_back(grandchild); }); });
        shared::BvhNode wide{};
        for (int c = 0; c < 4; ++c) {
            const bool used = c < static_cast<int>(children.size()) && builder.nodes[children[c]].count != 0;
            const Box box = used ? builder.nodes[children[c]].box : Box{};
            wide.min_x[c] = box.min.x, wide.min_y[c] = box.min.y, wide.min_z[c] = box.min.z;
            wide.max_x[c] = box.max.x, wide.max_y[c] = box.max.y, wide.max_z[c] = box.max.z;
            wide.child[c] = shared::kBvhEmpty;
            if (!used) continue;
            const BinaryNode& node = builder.nodes[children[c]];
            if (node.left == 0) {
                wide.child[c] = shared::kBvhLeaf | (node.count - 1) << shared::kBvhCountShift | node.first;
            } else {
                wide.child[c] = static_cast<uint32_t>(out.size());
                tasks.push_back({children[c], static_cast<uint32_t>(out.size())});
                out.push_back({});
            }
        }
        out[task.wide] = wide;
    }
}

}  // namespace

WideTree build_wide_tree(std::span<const Box> boxes, uint32_t max_leaf) {
    PARHELION_CHECK(boxes.size() <= shared::kBvhFirstMask, "{} items are more than a tree holds", boxes.size());
    Builder builder{.boxes = boxes, .max_leaf = max_leaf};
    builder.build();
    WideTree tree;
    collapse(builder, tree.nodes);
    tree.order = std::move(builder.order);
    return tree;
}

}  // namespace parhelion::bvh
