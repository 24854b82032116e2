#pragma once
#include "bvh/binary_tree.h"

namespace parhelion::bvh {

// Costs of the surface area heuristic, in triangle tests: of a node, by width.
constexpr float node_cost(uint32_t width) { return width == 2 ? 2.0f : 1.5f; }

// The wide tree of least cost that can be made of a binary one by leaving out nodes and by ending in leaves of up to max_leaf
// references: by dynamic programming over forests (Ylitie et al. 2017, section 3). The binary tree's height, above ranges of
// max_leaf references, is at most width / 2 * max_depth; where the best solution is deeper than max_depth levels of nodes, it gives
// way to one that is not.
WideTree collapse(BinaryTree tree, uint32_t width, uint32_t max_leaf, uint32_t max_depth, float cost_of_node);

}  // namespace parhelion::bvh
