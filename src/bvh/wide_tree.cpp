// From a binary tree to one with two or four children a node.
#include <array>

#include "base/error.h"
#include "bvh/binary_tree.h"
#include "bvh/wide_tree.h"

namespace parhelion::bvh {

namespace {

struct Children {
    std::array<uint32_t, 4> node;  // of the binary tree
    uint32_t count = 0;
};

// The binary nodes that become the children of a wide node: starting from `root`, inner nodes are opened until there are `width`.
// A node too high for the `room` levels of wide nodes that may follow is opened first: four children take two of its levels along,
// so a tree of height 2 max_depth always fits. Else the one with the largest surface, which rays would most likely open anyway.
Children gather_children(const BinaryTree& tree, uint32_t root, uint32_t width, uint32_t room) {
    Children children{.node = {root}, .count = 1};
    while (children.count < width) {
        uint32_t best = 4;
        bool best_forced = false;
        float best_area = 0;
        for (uint32_t c = 0; c < children.count; ++c) {
            const BinaryNode& node = tree.nodes[children.node[c]];
            if (node.split == 0) continue;
            const bool forced = node.height > width / 2 * room;
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

// max_depth: levels of wide nodes, for a binary tree of at most width / 2 times that height.
std::vector<WideNode> collapse(const BinaryTree& tree, uint32_t width, uint32_t max_depth) {
    struct Task {
        uint32_t binary, wide, depth;
    };
    std::vector<WideNode> nodes(1);
    if (tree.items.empty()) return nodes;
    std::vector<Task> tasks{{0, 0, 0}};
    while (!tasks.empty()) {
        const Task task = tasks.back();
        tasks.pop_back();
        const Children children = gather_children(tree, task.binary, width, max_depth - task.depth - 1);
        for (uint32_t c = 0; c < children.count; ++c) {
            const BinaryNode& child = tree.nodes[children.node[c]];
            WideNode& node = nodes[task.wide];
            node.box[c] = child.box;
            node.child[c] = child.split == 0 ? shared::kBvhLeaf | child.first : static_cast<uint32_t>(nodes.size());
            if (child.split == 0) continue;
            tasks.push_back({children.node[c], static_cast<uint32_t>(nodes.size()), task.depth + 1});
            nodes.emplace_back();
        }
    }
    return nodes;
}

}  // namespace

WideTree build_wide_tree(std::span<const Box> boxes, uint32_t width, uint32_t max_leaf, uint32_t max_depth) {
    std::vector<BuildItem> items;
    items.reserve(boxes.size());
    for (size_t i = 0; i < boxes.size(); ++i)
        if (!boxes[i].empty()) items.push_back({boxes[i].min, static_cast<uint32_t>(i), boxes[i].max});
    const BinaryTree binary = build_binary_tree(std::move(items), max_leaf, width / 2 * max_depth);
    WideTree tree{.width = width, .nodes = collapse(binary, width, max_depth), .order = {}, .rest = {}};
    tree.order.resize(binary.items.size());
    tree.rest.resize(binary.items.size());
    for (size_t i = 0; i < binary.items.size(); ++i) tree.order[i] = binary.items[i].index;
    for (const BinaryNode& node : binary.nodes)
        if (node.split == 0)
            for (uint32_t i = 0; i < node.count; ++i) tree.rest[node.first + i] = static_cast<uint8_t>(node.count - 1 - i);
    return tree;
}

}  // namespace parhelion::bvh
