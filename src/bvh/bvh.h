#pragma once
// Builder of our own two-level BVH (shared/bvh.h): a bottom level per mesh, a top level over instances, both by the surface area
// heuristic (binary_tree.h) and collapsed to the width of the nodes' layout at least cost (collapse.h). Depths are bounded by
// construction, so that no traversal stack can overflow. The result depends on the input alone, not on the number of threads.
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "bvh/nodes.h"
#include "shared/bvh.h"

namespace parhelion::bvh {

// ---- bottom levels ----

// Object space. Every index is below positions.size(). Hits count its triangles from `first_primitive` on.
struct BottomGeometry {
    std::span<const glm::vec3> positions;
    std::span<const glm::uvec3> triangles;
    uint32_t first_primitive = 0;
};

// Every mesh's bottom level in shared arrays, as they are uploaded.
struct Bottoms {
    Nodes nodes;
    std::vector<shared::BvhTriangle> triangles;
    std::vector<uint32_t> roots;  // by mesh
};

// Adds a mesh that keeps its shape (what deforms: refit.h), in the layout that bottoms.nodes has; returns its index in `roots`. Large
// triangles may be in several leaves, whose boxes together contain them; at most 1.3 leaf entries a triangle. Degenerate triangles are in
// leaves too (no ray hits them); those with a corner that is not finite or beyond +-1e18 are left out. Takes at most 250 bytes a
// triangle on the way. Throws Error beyond 2^31 triangles or nodes in all.
uint32_t add_bottom(Bottoms& bottoms, std::span<const BottomGeometry> geometries);

// ---- top level ----

// An instance for build_top. Its box is empty, and build_top leaves it out, if there is nothing to hit: an empty mesh, or a
// transform that cannot be inverted.
struct TopItem {
    shared::BvhTopItem item;
    Box box_ws;
};

// `instance` is what hits report; rays see it if their mask shares a bit with `mask`; `flags` are BvhTopItem's.
TopItem make_top_item(const Bottoms& bottoms, uint32_t mesh, const glm::mat4& world_from_object, uint32_t instance, uint32_t mask = 0xFFu, uint32_t flags = 0);

// The boxes in a bottom level's root: an instance's box is around what they become in the world, which is tighter under rotation than
// the whole's.
struct RootBoxes {
    RootBoxes() = default;
    explicit RootBoxes(const shared::BvhNode& root);
    uint32_t count = 0;
    glm::vec3 middle[4], half[4];
};

// The same for a bottom level that lies elsewhere by now: what its root holds, and the root's place in the node array.
TopItem make_top_item(const RootBoxes& root_boxes, uint32_t root, const glm::mat4& world_from_object, uint32_t instance, uint32_t mask = 0xFFu, uint32_t flags = 0);

// And where the inverse of the transform's linear part is known: its rows.
TopItem make_top_item(const RootBoxes& root_boxes, uint32_t root, const glm::mat4& world_from_object, const glm::vec3 (&inverse_rows)[3], uint32_t instance, uint32_t mask, uint32_t flags);

struct Top {
    Nodes nodes;  // the root is node 0; an empty scene has one node with no children
    std::vector<shared::BvhTopItem> items;
};

// For what moves, MovingTop (moving_top.h) does less. At most 2^24 instances (the depth bound); throws Error beyond.
Top build_top(std::span<const TopItem> items, Layout layout);

}  // namespace parhelion::bvh
