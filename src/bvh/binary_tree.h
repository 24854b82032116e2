#pragma once
// The binary tree that is built first and then collapsed to wide nodes.
#include <cstdint>
#include <span>
#include <vector>

#include "bvh/wide_tree.h"

namespace parhelion::bvh {

// A box that is sorted into the tree.
struct BuildItem {
    glm::vec3 min;
    uint32_t index;  // in the caller's array
    glm::vec3 max;
};

struct BinaryNode {
    Box box;
    uint32_t split = 0;  // its children are nodes 2 split and 2 split + 1; 0: a leaf
    uint32_t first = 0, count = 0;  // of BinaryTree::items
    uint32_t height = 0;  // levels below it
};

struct BinaryTree {
    std::vector<BuildItem> items;  // in leaf order
    std::vector<BinaryNode> nodes;  // the root is node 0. Not every entry is in use.
};

// Binned SAH with at most max_leaf (a power of two) items in a leaf and max_height levels below the root; needs
// items.size() <= max_leaf << max_height.
BinaryTree build_binary_tree(std::vector<BuildItem> items, uint32_t max_leaf, uint32_t max_height);

}  // namespace parhelion::bvh
