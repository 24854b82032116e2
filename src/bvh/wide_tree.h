#pragma once
// The tree between the builder and the layouts of nodes: float boxes, two or four children a node.
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

struct WideNode {
    Box box[4];
    uint32_t child[4] = {shared::kBvhEmpty, shared::kBvhEmpty, shared::kBvhEmpty, shared::kBvhEmpty};  // a node, or kBvhLeaf | first position in `order`
};

struct WideTree {
    uint32_t width = 4;          // children in use: the first 2, or 4
    std::vector<WideNode> nodes;  // the root is node 0
    std::vector<uint32_t> order;  // leaf by leaf: indices of boxes. Empty boxes are in no leaf.
    std::vector<uint8_t> rest;    // items of the same leaf that follow, by position in `order`
};

// At most max_leaf (a power of two) boxes in a leaf and max_depth levels of nodes; needs boxes.size() <= max_leaf * width^max_depth.
WideTree build_wide_tree(std::span<const Box> boxes, uint32_t width, uint32_t max_leaf, uint32_t max_depth);

}  // namespace parhelion::bvh
