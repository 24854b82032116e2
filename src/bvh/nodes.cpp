#include "bvh/nodes.h"

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "base/parallel.h"
#include "bvh/bounds.h"

namespace parhelion::bvh {

namespace {

constexpr size_t kNodeGrain = 1u << 14;

struct LayoutInfo {
    std::string_view name;
    uint32_t width, bytes, child_offset;
};
constexpr LayoutInfo kInfo[] = {{"binary", 2, sizeof(shared::BvhNodeBinary), offsetof(shared::BvhNodeBinary, child)},
                                {"four", 4, sizeof(shared::BvhNode), offsetof(shared::BvhNode, child)},
                                {"compact", 4, sizeof(shared::BvhNodeCompact), offsetof(shared::BvhNodeCompact, child)}};
static_assert(sizeof(shared::BvhNodeBinary) == 64 && sizeof(shared::BvhNode) == 112 && sizeof(shared::BvhNodeCompact) == 64);  // as fetch_node() has them

const LayoutInfo& info(Layout layout) { return kInfo[static_cast<size_t>(layout)]; }

Four four(const glm::vec4& v) { return {{v.x, v.y, v.z, v.w}}; }

// Calls would pass four floats through memory, in two halves: inlined they stay in registers.
// guess_n() of shaders/lib/bvh_nodes.glsl.
[[gnu::always_inline]] inline Four guesses(const Four& difference, const Four& per_scale) {
    const Four limited = lower(higher(difference * per_scale, all_four(0.0f)), all_four(255.0f));
    Four n;
    for (int i = 0; i < 4; ++i) n.v[i] = static_cast<float>(static_cast<int>(limited.v[i]));
    return n;
}

[[gnu::always_inline]] inline Four one_where_less(const Four& a, const Four& b) {
    Four out;
    for (int i = 0; i < 4; ++i) out.v[i] = a.v[i] < b.v[i] ? 1.0f : 0.0f;
    return out;
}

// Numbers of 0 to 255: floats hold two bytes exactly.
[[gnu::always_inline]] inline uint32_t pack_bytes(const Four& n) {
    return static_cast<uint32_t>(static_cast<int>(n.v[0] + 256.0f * n.v[1])) | static_cast<uint32_t>(static_cast<int>(n.v[2] + 256.0f * n.v[3])) << 16;
}

}  // namespace

shared::QuantisedAxis quantise_axis(const glm::vec4& low_planes, const glm::vec4& high_planes) {
    const Four low = four(low_planes), high = four(high_planes);
    const float first = lowest(low), last = highest(high), smallest = 1e-30f;
    shared::QuantisedAxis axis;
    axis.origin = first <= last ? first : 0.0f;
    axis.scale = shared::next_scale(first <= last ? std::max((last - first) * (1.0f / 255.0f), smallest) : smallest);
    const Four origin = all_four(axis.origin), scale = all_four(axis.scale), per_scale = all_four(1.0f / axis.scale);
    Four from = guesses(low - origin, per_scale);
    from = from - one_where_less(low, origin + from * scale);
    from = from + all_four(1.0f) - one_where_less(low, origin + (from + all_four(1.0f)) * scale);
    axis.low = pack_bytes(lower(higher(from, all_four(0.0f)), all_four(255.0f)));
    Four to = guesses(high - origin, per_scale);
    to = to + one_where_less(origin + to * scale, high);
    to = to + one_where_less(origin + to * scale, high);
    axis.high = pack_bytes(lower(to, all_four(255.0f)));
    return axis;
}

namespace {

shared::BvhNodeCompact quantised(const shared::BvhNode& node) {
    const shared::QuantisedAxis x = quantise_axis(node.min_x, node.max_x), y = quantise_axis(node.min_y, node.max_y), z = quantise_axis(node.min_z, node.max_z);
    return {.origin = {x.origin, y.origin, z.origin}, .min_x = x.low, .scale = {x.scale, y.scale, z.scale}, .max_x = x.high, .min_y = y.low, .max_y = y.high, .min_z = z.low, .max_z = z.high, .child = node.child};
}

void encode(const shared::BvhNode& node, Layout layout, void* to) {
    const auto copy = [&](const auto& encoded) { std::memcpy(to, &encoded, sizeof(encoded)); };
    if (layout == Layout::Binary) copy(shared::encode_binary(node));
    else if (layout == Layout::Compact) copy(quantised(node));
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

shared::BvhNode Nodes::read(size_t index) const {
    PARHELION_CHECK(index < size(), "node {} of {}", index, size());
    return shared::fetch_node(reinterpret_cast<uint64_t>(words.data()), static_cast<uint32_t>(index), static_cast<uint32_t>(layout));
}

void Nodes::write(size_t index, const shared::BvhNode& node) { encode(node, layout, words.data() + index * (node_bytes(layout) / sizeof(uint32_t))); }

void Nodes::append(const WideTree& tree, uint32_t first_item) {
    PARHELION_CHECK(tree.width == node_width(layout), "a tree of width {} as nodes of layout {}", tree.width, layout_name(layout));
    const size_t first_node = size(), node_words = node_bytes(layout) / sizeof(uint32_t);
    words.resize(words.size() + tree.nodes.size() * node_words);
    parallel_for(tree.nodes.size(), kNodeGrain, [&](size_t begin, size_t end) {
        for (size_t n = begin; n < end; ++n) {
            uint32_t* to = words.data() + (first_node + n) * node_words;
            encode(to_shared(tree.nodes[n]), layout, to);
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
