#include "bvh/binary_tree.h"

#include <algorithm>
#include <array>
#include <bit>

#include "base/error.h"
#include "base/parallel.h"

namespace parhelion::bvh {

namespace {

constexpr uint32_t kMaxBins = 16;
constexpr uint32_t kSubtree = 1u << 14;     // ranges up to this size are built by one thread
constexpr uint32_t kChunk = 1u << 15;       // larger ranges are scanned by all threads in chunks of this size
constexpr float kTraversalCost = 2.0f;      // of a binary node, in triangle tests: as fast as 1 and a sixth smaller

// Twice the center of a box: saves a product.
glm::vec3 center(const BuildItem& item) { return item.min + item.max; }

struct Range {
    uint32_t node, depth;
};

// Box of a range's items, and of their centers.
struct Extent {
    Box box, centers;
    void add(const Extent& e) { box.add(e.box), centers.add(e.centers); }
};

struct Bin {
    Box box;
    uint32_t count = 0;
};
using Bins = std::array<std::array<Bin, kMaxBins>, 3>;

// Maps centers to bins. A small range gets few bins: scanning them would cost more than the items.
struct Binning {
    Binning(const Box& centers, uint32_t item_count) : low(centers.min), bins(std::clamp(item_count, 4u, kMaxBins)) {
        const glm::vec3 extent = centers.max - centers.min;
        for (int axis = 0; axis < 3; ++axis) scale[axis] = extent[axis] > 0.0f ? static_cast<float>(bins) * (1.0f - 1e-6f) / extent[axis] : 0.0f;
    }
    uint32_t bin(const BuildItem& item, int axis) const {
        const float scaled = (item.min[axis] + item.max[axis] - low[axis]) * scale[axis];
        return scaled > 0.0f ? std::min(static_cast<uint32_t>(scaled), bins - 1) : 0;
    }
    glm::vec3 low, scale;
    uint32_t bins;
};

struct Split {
    float cost = 3e38f;
    int axis = -1;
    uint32_t bin = 0;         // first bin of the second half
    uint32_t left_count = 0;
};

class Builder {
public:
    Builder(std::vector<BuildItem> items, uint32_t max_leaf, uint32_t max_height) : max_leaf_(max_leaf), max_height_(max_height) {
        tree_.items = std::move(items);
        tree_.nodes.resize(std::max<size_t>(1, 2 * tree_.items.size()));
        tree_.nodes[0].count = static_cast<uint32_t>(tree_.items.size());
    }

    BinaryTree build() {
        // Large ranges one after the other, each by all threads; then small ones side by side. Children have fixed places in
        // the node array (a split point splits one range only), so threads need no common counter.
        std::vector<Range> large{{0, 0}}, small;
        while (!large.empty()) {
            const Range range = large.back();
            large.pop_back();
            const uint32_t count = tree_.nodes[range.node].count;
            if (count <= kSubtree) {
                small.push_back(range);
                continue;
            }
            split_range(range, large);
        }
        parallel_for(small.size(), 1, [&](size_t begin, size_t end) {
            std::vector<Range> stack;
            for (size_t i = begin; i < end; ++i) {
                stack.push_back(small[i]);
                while (!stack.empty()) {
                    const Range range = stack.back();
                    stack.pop_back();
                    split_range(range, stack);
                }
            }
        });
        set_heights();
        return std::move(tree_);
    }

private:
    std::span<BuildItem> items_of(const BinaryNode& node) { return std::span(tree_.items).subspan(node.first, node.count); }

    // Makes the range's node; pushes its halves, if any.
    void split_range(const Range& range, std::vector<Range>& out) {
        BinaryNode& node = tree_.nodes[range.node];
        if (node.count == 0) return;
        const Extent extent = scan<Extent>(node, [](Extent& e, const BuildItem& item) {
            e.box.add({item.min, item.max});
            e.centers.add(center(item));
        });
        node.box = extent.box;
        const uint32_t left_count = choose_split(node, extent, max_height_ - range.depth);
        if (left_count == 0) return;
        node.split = node.first + left_count;
        tree_.nodes[2 * node.split] = {.first = node.first, .count = left_count};
        tree_.nodes[2 * node.split + 1] = {.first = node.split, .count = node.count - left_count};
        out.push_back({2 * node.split, range.depth + 1});
        out.push_back({2 * node.split + 1, range.depth + 1});
    }

    // Orders the items into two halves; returns the size of the first, 0 for a leaf. `room`: levels that may follow.
    uint32_t choose_split(const BinaryNode& node, const Extent& extent, uint32_t room) {
        if (node.count == 1) return 0;
        const Binning binning(extent.centers, node.count);
        const Split split = best_split(node, binning);
        if (node.count <= max_leaf_ && (room == 0 || static_cast<float>(node.count) * node.box.half_area() <= split.cost)) return 0;
        // Halving always fits into the room that is left; a SAH split is taken only if both of its parts still can be halved.
        const bool fits = split.axis >= 0 && halvings(std::max(split.left_count, node.count - split.left_count)) < room;
        return fits ? partition(node, binning, split) : halve(node, extent.centers);
    }

    // Levels that halving a range down to leaves takes.
    uint32_t halvings(uint32_t count) const { return static_cast<uint32_t>(std::bit_width((count - 1) / max_leaf_)); }

    Split best_split(const BinaryNode& node, const Binning& binning) {
        const Bins bins = scan<BinsSum>(node, [&](BinsSum& sum, const BuildItem& item) {
            for (int axis = 0; axis < 3; ++axis) {
                Bin& bin = sum.bins[axis][binning.bin(item, axis)];
                bin.box.add({item.min, item.max});
                ++bin.count;
            }
        }).bins;
        Split best;
        for (int axis = 0; axis < 3; ++axis) {
            if (!(binning.scale[axis] > 0.0f)) continue;
            std::array<float, kMaxBins> right_cost{};
            Bin right;
            for (uint32_t b = binning.bins - 1; b > 0; --b) {
                right.box.add(bins[axis][b].box);
                right.count += bins[axis][b].count;
                right_cost[b] = right.box.half_area() * static_cast<float>(right.count);
            }
            Bin left;
            for (uint32_t b = 1; b < binning.bins; ++b) {
                left.box.add(bins[axis][b - 1].box);
                left.count += bins[axis][b - 1].count;
                if (left.count == 0 || left.count == node.count) continue;
                const float cost = kTraversalCost * node.box.half_area() + left.box.half_area() * static_cast<float>(left.count) + right_cost[b];
                if (cost < best.cost) best = {cost, axis, b, left.count};
            }
        }
        return best;
    }

    uint32_t partition(const BinaryNode& node, const Binning& binning, const Split& split) {
        const auto is_left = [&](const BuildItem& item) { return binning.bin(item, split.axis) < split.bin; };
        const std::span<BuildItem> items = items_of(node);
        if (items.size() <= kChunk) {
            std::partition(items.begin(), items.end(), is_left);
            return split.left_count;
        }
        // By all threads: count chunk by chunk, then every chunk writes to its own places.
        const size_t chunks = (items.size() + kChunk - 1) / kChunk;
        const auto chunk = [&](size_t c) { return items.subspan(c * kChunk, std::min<size_t>(kChunk, items.size() - c * kChunk)); };
        std::vector<uint32_t> left_before(chunks + 1, 0);
        for_each_chunk(chunks, [&](size_t c) { left_before[c + 1] = static_cast<uint32_t>(std::count_if(chunk(c).begin(), chunk(c).end(), is_left)); });
        for (size_t c = 0; c < chunks; ++c) left_before[c + 1] += left_before[c];
        scratch_.resize(std::max(scratch_.size(), items.size()));
        for_each_chunk(chunks, [&](size_t c) {
            uint32_t left = left_before[c], right = split.left_count + static_cast<uint32_t>(c * kChunk) - left_before[c];
            for (const BuildItem& item : chunk(c)) scratch_[is_left(item) ? left++ : right++] = item;
        });
        for_each_chunk(chunks, [&](size_t c) { std::copy_n(scratch_.begin() + static_cast<std::ptrdiff_t>(c * kChunk), chunk(c).size(), chunk(c).begin()); });
        return split.left_count;
    }

    // Equal numbers on both sides of the widest axis of the centers; the caller's order decides between equal centers.
    uint32_t halve(const BinaryNode& node, const Box& centers) {
        const glm::vec3 extent = centers.max - centers.min;
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        const std::span<BuildItem> items = items_of(node);
        std::nth_element(items.begin(), items.begin() + node.count / 2, items.end(), [&](const BuildItem& a, const BuildItem& b) {
            const float x = center(a)[axis], y = center(b)[axis];
            return x != y ? x < y : a.index < b.index;
        });
        return node.count / 2;
    }

    struct BinsSum {
        Bins bins;
        void add(const BinsSum& other) {
            for (int axis = 0; axis < 3; ++axis)
                for (uint32_t b = 0; b < kMaxBins; ++b) bins[axis][b].box.add(other.bins[axis][b].box), bins[axis][b].count += other.bins[axis][b].count;
        }
    };

    // Adds up a range's items. Minima, maxima and counts are exact, so the chunks do not show in the result.
    template <class Sum, class AddItem>
    Sum scan(const BinaryNode& node, AddItem&& add_item) {
        const std::span<const BuildItem> items = items_of(node);
        Sum sum;
        if (items.size() <= kChunk) {
            for (const BuildItem& item : items) add_item(sum, item);
            return sum;
        }
        std::vector<Sum> parts((items.size() + kChunk - 1) / kChunk);
        for_each_chunk(parts.size(), [&](size_t c) {
            for (const BuildItem& item : items.subspan(c * kChunk, std::min<size_t>(kChunk, items.size() - c * kChunk))) add_item(parts[c], item);
        });
        for (const Sum& part : parts) sum.add(part);
        return sum;
    }

    template <class Body>
    static void for_each_chunk(size_t chunks, Body&& body) {
        parallel_for(chunks, 1, [&](size_t begin, size_t end) {
            for (size_t c = begin; c < end; ++c) body(c);
        });
    }

    void set_heights() {
        std::vector<uint32_t> order{0};  // parents before children
        for (size_t i = 0; i < order.size(); ++i)
            if (const uint32_t split = tree_.nodes[order[i]].split; split != 0) order.insert(order.end(), {2 * split, 2 * split + 1});
        for (size_t i = order.size(); i-- > 0;) {
            BinaryNode& node = tree_.nodes[order[i]];
            if (node.split != 0) node.height = 1 + std::max(tree_.nodes[2 * node.split].height, tree_.nodes[2 * node.split + 1].height);
        }
    }

    uint32_t max_leaf_, max_height_;
    BinaryTree tree_;
    std::vector<BuildItem> scratch_;
};

}  // namespace

BinaryTree build_binary_tree(std::vector<BuildItem> items, uint32_t max_leaf, uint32_t max_height) {
    PARHELION_CHECK(std::has_single_bit(max_leaf) && items.size() <= uint64_t(max_leaf) << max_height, "{} items do not fit into {} levels of leaves of {}", items.size(),
                    max_height, max_leaf);
    return Builder(std::move(items), max_leaf, max_height).build();
}

}  // namespace parhelion::bvh
