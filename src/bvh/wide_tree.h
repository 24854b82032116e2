#pragma once
// The tree between the builder and the layouts of nodes: float boxes, two or four children a node.
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "shared/bvh.h"

namespace parhelion::bvh {

struct Box {
    glm::vec3 min{3e38f}, max{-3e38f};  // empty
    void add(glm::vec3 p) { min = glm::min(min, p), max = glm::max(max, p); }
    void add(const Box& b) { min = glm::min(min, b.min), max = glm::max(max, b.max); }
    bool empty() const { return !(min.x <= max.x); }
    // Half its surface, the SAH's measure; 0 if empty.
    float half_area() const {
        const glm::vec3 d = max - min;
        return empty() ? 0.0f : d.x * d.y + d.y * d.z + d.z * d.x;
    }
};

// What the builder can use; false for NaN.
inline bool in_range(glm::vec3 p) { return std::abs(p.x) <= 1e18f && std::abs(p.y) <= 1e18f && std::abs(p.z) <= 1e18f; }

struct WideNode {
    Box box[4];
    uint32_t child[4] = {shared::kBvhEmpty, shared::kBvhEmpty, shared::kBvhEmpty, shared::kBvhEmpty};  // a node, or kBvhLeaf | first position in `order`
};

struct WideTree {
    uint32_t width = 4;          // children in use: the first 2, or 4
    std::vector<WideNode> nodes;  // the root is node 0
    std::vector<uint32_t> order;  // leaf by leaf: indices of items. With spatial splits a triangle may be in several leaves.
    std::vector<uint8_t> rest;    // items of the same leaf that follow, by position in `order`
};

// At most max_leaf (a power of two) boxes in a leaf and max_depth levels of nodes; needs boxes.size() <= max_leaf * width^max_depth.
// Every box is in one leaf, empty ones in none. The cost as BuildOptions has it.
WideTree build_wide_tree(std::span<const Box> boxes, uint32_t width, uint32_t max_leaf, uint32_t max_depth, float cost_of_node = 0.0f);

struct BuildOptions {
    uint32_t width = 4;
    uint32_t max_leaf = shared::kBvhMaxLeaf;
    uint32_t max_depth = 0;
    // References that spatial splits may add, as a share of the triangles. Where it is 0, every triangle is in one leaf; else in one or
    // several, whose boxes together contain it.
    float growth = 0.0f;
    float node_cost = 0.0f;  // in triangle tests; larger: fewer nodes and larger leaves. 0: what suits the width
};

// Triangles with a corner that is not finite or beyond +-1e18 are in no leaf.
WideTree build_wide_tree(std::span<const shared::BvhTriangle> triangles, const BuildOptions& options);

// What a tree is expected to cost a ray that crosses its root, in triangle tests, by the surface area heuristic; and what it holds.
struct TreeStatistics {
    double cost = 0;
    size_t nodes = 0, leaves = 0, references = 0, depth = 0;
};
TreeStatistics measure(const WideTree& tree);

}  // namespace parhelion::bvh
