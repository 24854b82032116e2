#pragma once
// Arrays of nodes in one of the layouts of shared/bvh.h.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "bvh/wide_tree.h"
#include "lib/bvh_nodes.glsl"

namespace parhelion::bvh {

enum class Layout : uint32_t { Binary = shared::kBvhBinary, Four = shared::kBvhFour, Compact = shared::kBvhCompact };
inline constexpr Layout kLayouts[] = {Layout::Binary, Layout::Four, Layout::Compact};

std::string_view layout_name(Layout layout);
uint32_t node_width(Layout layout);  // children
uint32_t node_bytes(Layout layout);
// Levels of nodes that a tree may have.
uint32_t max_bottom_depth(Layout layout);
uint32_t max_top_depth(Layout layout);
// What bottom levels count a node for, in triangle tests; with the compact layout they then take at most 64 bytes a triangle. 0: what
// suits the width.
float bottom_node_cost(Layout layout);

shared::BvhNode to_shared(const WideNode& node);
// shared::quantise_axis(), to the last bit, where children that are not there have empty planes: 3e38 and -3e38.
shared::QuantisedAxis quantise_axis(const glm::vec4& low, const glm::vec4& high);

struct Nodes {
    Layout layout = Layout::Four;
    std::vector<uint32_t> words;

    size_t size() const { return words.size() * sizeof(uint32_t) / node_bytes(layout); }
    size_t bytes() const { return words.size() * sizeof(uint32_t); }
    // Its children's boxes, which contain those that it was made from, and the children.
    shared::BvhNode read(size_t index) const;
    // Makes the node what read() gives back. There must be one of this index.
    void write(size_t index, const shared::BvhNode& node);
    // Appends a tree of the layout's width. References become those of this array, and leaves begin at first_item.
    void append(const WideTree& tree, uint32_t first_item);
    // Copies nodes for an array in which node 0 has the number first_node, and item 0 the number first_item.
    void copy(size_t begin, size_t count, uint32_t first_node, uint32_t first_item, std::byte* to) const;
};

}  // namespace parhelion::bvh
