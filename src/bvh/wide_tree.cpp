// From a binary tree to one with four children a node.
#include <array>

#include "base/error.h"
#include "bvh/binary_tree.h"

namespace parhelion::bvh {

namespace {

struct Children {
    std::array<uint32_t, 4> node;  // of the binary tree
    uint32_t count = 0;
};

// The binary nodes that become the children of a wide node: starting from `root`, inner nodes are opened until there are four.
// A node too high for the `room` levels of wide nodes that may follow is opened first: it takes two of its levels along, so a
// tree of height 2 max_depth always fits. Else the one with the largest surface, which rays would most likely open anyway.
Children gather_children(const BinaryTree& tree, uint32_t root, uint32_t room) {
    Children children{.node = {root}, .count = 1};
    while (children.count < 4) {
        uint32_t best = 4;
        bool best_forced = false;
        float best_area = 0;
        for (uint32_t c = 0; c < children.count; ++c) {
            const BinaryNode& node = tree.nodes[children.node[c]];
            if (node.split == 0) continue;
            const bool forced = node.height > 2 * room;
            const float area = node.box.half_area();
            if (best == 4 || forced > best_forced || (forced == best_forced && area > best_area)) best = c, best_forced = forced, best_area = area;
        }
        if (best == 4) break;
        const uint32_t split = tree.nodes[children.node[best]].split;
        children.node[best] = 2 * split;
        children.node[children.count++] = 2 * split + 1;
    }
    return children;
}

void set_box(shared::BvhNode& node, int c, const Box& box) {
    node.min_x[c] = box.min.x, node.max_x[c] = box.max.x;
    node.min_y[c] = box.min.y, node.max_y[c] = box.max.y;
    node.min_z[c] = box.min.z, node.max_z[c] = box.max.z;
}

shared::BvhNode empty_node() {
    shared::BvhNode node{};
    for (int c = 0; c < 4; ++c) {
        set_box(node, c, {});
        node.child[c] = shared::kBvhEmpty;
    }
    return node;
}

// max_depth: levels of wide nodes, for a binary tree of at most twice that height.
std::vector<shared::BvhNode> collapse(const BinaryTree& tree, uint32_t max_depth) {
    struct Task {
        uint32_t binary, wide, depth;
    };
    std::vector<shared::BvhNode> nodes{empty_node()};
    if (tree.items.empty()) return nodes;
    std::vector<Task> tasks{{0, 0, 0}};
    while (!tasks.empty()) {
        const Task task = tasks.back();
        tasks.pop_back();
        const Children children = gather_children(tree, task.binary, max_depth - task.depth - 1);
        for (uint32_t c = 0; c < children.count; ++c) {
            const BinaryNode& child = tree.nodes[children.node[c]];
            shared::BvhNode& node = nodes[task.wide];
            set_box(node, static_cast<int>(c), child.box);
            node.child[c] = child.split == 0 ? shared::kBvhLeaf | child.first : static_cast<uint32_t>(nodes.size());
            if (child.split == 0) continue;
            tasks.push_back({children.node[c], static_cast<uint32_t>(nodes.size()), task.depth + 1});
            nodes.push_back(empty_node());
        }
    }
    return nodes;
}

}  // namespace

WideTree build_wide_tree(std::span<const Box> boxes, uint32_t max_leaf, uint32_t max_depth) {
    std::vector<BuildItem> items;
    items.reserve(boxes.size());
    for (size_t i = 0; i < boxes.size(); ++i)
        if (!boxes[i].empty()) items.push_back({boxes[i].min, static_cast<uint32_t>(i), boxes[i].max});
    const BinaryTree binary = build_binary_tree(std::move(items), max_leaf, 2 * max_depth);
    WideTree tree;
    tree.nodes = collapse(binary, max_depth);
    tree.order.resize(binary.items.size());
    tree.rest.resize(binary.items.size());
    for (size_t i = 0; i < binary.items.size(); ++i) tree.order[i] = binary.items[i].index;
    for (const BinaryNode& node : binary.nodes)
        if (node.split == 0)
            for (uint32_t i = 0; i < node.count; ++i) tree.rest[node.first + i] = static_cast<uint8_t>(node.count - 1 - i);
    return tree;
}

}  // namespace parhelion::bvh
