#include "bvh/nodes.h"

#include <cstring>

#include "base/error.h"
#include "base/parallel.h"
#include "lib/bvh_nodes.glsl"

namespace parhelion::bvh {

namespace {

constexpr size_t kGrain = 1u << 14;

struct LayoutInfo {
    std::string_view name;
    uint32_t width, bytes, child_offset;
};
constexpr LayoutInfo kInfo[] = {{"binary", 2, sizeof(shared::BvhNodeBinary), offsetof(shared::BvhNodeBinary, child)},
                                {"four", 4, sizeof(shared::BvhNode), offsetof(shared::BvhNode, child)},
                                {"compact", 4, sizeof(shared::BvhNodeCompact), offsetof(shared::BvhNodeCompact, child)}};
static_assert(sizeof(shared::BvhNodeBinary) == 64 && sizeof(shared::BvhNode) == 112 && sizeof(shared::BvhNodeCompact) == 64);  // as fetch_node() has them

const LayoutInfo& info(Layout layout) { return kInfo[static_cast<size_t>(layout)]; }

shared::BvhNode to_shared(const WideNode& node) {
    shared::BvhNode out{};
    for (int c = 0; c < 4; ++c) {
        const Box& box = node.box[c];
        out.min_x[c] = box.min.x, out.max_x[c] = box.max.x;
        out.min_y[c] = box.min.y, out.max_y[c] = box.max.y;
        out.min_z[c] = box.min.z, out.max_z[c] = box.max.z;
        out.child[c] = node.child[c];
    }
    return out;
}

void write(const shared::BvhNode& node, Layout layout, void* to) {
    const auto copy = [&](const auto& encoded) { std::memcpy(to, &encoded, sizeof(encoded)); };
    if (layout == Layout::Binary) copy(shared::encode_binary(node));
    else if (layout == Layout::Compact) copy(shared::encode_compact(node));
    else copy(node);
}

// Adds to the children's numbers.
void move_references(std::byte* node, const LayoutInfo& layout, uint32_t first_node, uint32_t first_item) {
    uint32_t child[4];
    std::memcpy(child, node + layout.child_offset, layout.width * sizeof(uint32_t));
    for (uint32_t c = 0; c < layout.width; ++c)
        if (child[c] != shared::kBvhEmpty) child[c] += (child[c] & shared::kBvhLeaf) != 0 ? first_item : first_node;
    std::memcpy(node + layout.child_offset, child, layout.width * sizeof(uint32_t));
}

}  // namespace

std::string_view layout_name(Layout layout) { return info(layout).name; }
uint32_t node_width(Layout layout) { return info(layout).width; }
uint32_t node_bytes(Layout layout) { return info(layout).bytes; }
uint32_t max_bottom_depth(Layout layout) { return shared::kBvhBottomLevels * 2 / node_width(layout); }
uint32_t max_top_depth(Layout layout) { return shared::kBvhTopLevels * 2 / node_width(layout); }
float bottom_node_cost(Layout layout) { return layout == Layout::Compact ? 4.0f : 0.0f; }

shared::BvhNode Nodes::read(size_t index) const {
    PARHELION_CHECK(index < size(), "node {} of {}", index, size());
    return shared::fetch_node(reinterpret_cast<uint64_t>(words.data()), static_cast<uint32_t>(index), static_cast<uint32_t>(layout));
}

void Nodes::append(const WideTree& tree, uint32_t first_item) {
    PARHELION_CHECK(tree.width == node_width(layout), "a tree of width {} as nodes of layout {}", tree.width, layout_name(layout));
    const size_t first_node = size(), node_words = node_bytes(layout) / sizeof(uint32_t);
    words.resize(words.size() + tree.nodes.size() * node_words);
    parallel_for(tree.nodes.size(), kGrain, [&](size_t begin, size_t end) {
        for (size_t n = begin; n < end; ++n) {
            uint32_t* to = words.data() + (first_node + n) * node_words;
            write(to_shared(tree.nodes[n]), layout, to);
            move_references(reinterpret_cast<std::byte*>(to), info(layout), static_cast<uint32_t>(first_node), first_item);
        }
    });
}

void Nodes::copy(size_t begin, size_t count, uint32_t first_node, uint32_t first_item, std::byte* to) const {
    const size_t stride = node_bytes(layout);
    std::memcpy(to, words.data() + begin * stride / sizeof(uint32_t), count * stride);
    for (size_t i = 0; i < count; ++i) move_references(to + i * stride, info(layout), first_node, first_item);
}

}  // namespace parhelion::bvh
