#pragma once
// The binary tree that is built first, down to single references, and then collapsed to wide nodes.
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bvh/wide_tree.h"

namespace parhelion::bvh {

// A box that is sorted into the tree: of an item, or of a part of a triangle that a spatial split has cut.
struct Reference {
    glm::vec3 min;
    uint32_t index;  // of the item, in the caller's array
    glm::vec3 max;
    uint32_t pad;
    Box box() const { return {min, max}; }
};

// A child is kBvhLeaf | a reference, or another node.
struct BinaryNode {
    glm::vec3 min;
    uint32_t left;
    glm::vec3 max;
    uint32_t right;
    Box box() const { return {min, max}; }
};

// Both arrays have `slots` places, of which some may be unused (and uninitialised). A pass over all nodes from below takes the
// subtrees side by side, then `top` from its end.
struct BinaryTree {
    std::unique_ptr<Reference[]> references;
    std::unique_ptr<BinaryNode[]> nodes;
    uint32_t slots = 0;
    uint32_t root = shared::kBvhEmpty;  // a child
    std::vector<uint32_t> top;          // nodes above the subtrees, parents first
    std::vector<uint32_t> subtrees;     // children

    Box box_of(uint32_t child) const {
        return (child & shared::kBvhLeaf) != 0 ? references[child & shared::kBvhItemMask].box() : nodes[child].box();
    }
};

struct BinaryLimits {
    uint32_t max_leaf = 1;    // a power of two
    uint32_t max_height = 0;  // levels of nodes above ranges of at most max_leaf references
};

// Splits by the surface area heuristic (MacDonald and Booth 1990): every position where few references are left, 16 bins an axis
// above that (Wald 2007); and, where that leaves overlap, in space (Stich et al. 2009), each range of references with a part of the
// budget to itself (Fuetterling et al. 2016). `references` has place for `slots`, `count` of which are in use; spatial splits fill the
// others, cutting `triangles` (by Reference::index). Needs count <= max_leaf << max_height. The result depends on the input alone, not
// on the number of threads.
BinaryTree build_binary_tree(std::unique_ptr<Reference[]> references, uint32_t count, uint32_t slots, std::span<const shared::BvhTriangle> triangles, const BinaryLimits& limits);

}  // namespace parhelion::bvh
