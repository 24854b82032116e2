#pragma once
// Builder of our own two-level BVH. Bottom levels by binned SAH (Wald 2007), collapsed to 4-wide nodes two levels at a time, so
// that the depth is bounded and no traversal stack can overflow. Deterministic: the result depends on the input alone.
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "shared/bvh.h"

namespace parhelion::bvh {

struct Box {
    glm::vec3 min{1e38f}, max{-1e38f};
    void add(glm::vec3 p) { min = glm::min(min, p), max = glm::max(max, p); }
    void add(const Box& b) { min = glm::min(min, b.min), max = glm::max(max, b.max); }
    bool empty() const { return min.x > max.x; }
    float half_area() const {
        const glm::vec3 d = max - min;
        return empty() ? 0.0f : d.x * d.y + d.y * d.z + d.z * d.x;
    }
};

struct BottomGeometry {
    std::span<const glm::vec3> positions;
    std::span<const glm::uvec3> triangles;
};

// Every mesh's bottom level in shared arrays.
struct Bottoms {
    std::vector<shared::BvhNode> nodes;
    std::vector<shared::BvhTriangle> triangles;
    struct Entry {
        uint32_t root = shared::kBvhEmpty;  // kBvhEmpty: nothing to hit
        Box box;
    };
    std::vector<Entry> entries;
};

// Adds a mesh; returns its index in `entries`. Triangles with non-finite corners are left out; degenerate ones are kept (no ray
// hits them). Throws Error beyond 2^29 triangles in all.
uint32_t add_bottom(Bottoms& bottoms, std::span<const BottomGeometry> geometries);

// An instance of a bottom level, for build_top.
struct TopItem {
    shared::BvhTopItem item;
    Box world_box;
};
TopItem make_top_item(const Bottoms& bottoms, uint32_t entry, const glm::mat4& world_from_object, uint32_t instance);

struct Top {
    std::vector<shared::BvhNode> nodes;  // the root is node 0; an empty scene has one node with four empty children
    std::vector<shared::BvhTopItem> items;
};
Top build_top(std::span<const TopItem> items);

// The tree under both: over boxes, calling back nothing. Leaves hold ranges of `order`.
struct WideTree {
    std::vector<shared::BvhNode> nodes;
    std::vector<uint32_t> order;  // leaf items are order[first + i]
};
WideTree build_wide_tree(std::span<const Box> boxes, uint32_t max_leaf);

}  // namespace parhelion::bvh
