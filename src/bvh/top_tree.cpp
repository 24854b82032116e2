// Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies", with what a frame can afford: bins along one axis, the
// widest of the centers; small ranges sorted instead; wide nodes made straight away, by opening the child with the largest surface.
#include "bvh/top_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>

#include "base/error.h"
#include "base/parallel.h"
#include "bvh/bounds.h"

namespace parhelion::bvh {

namespace {

constexpr uint32_t kBins = 16;
constexpr uint32_t kSmall = 8;       // ranges up to this size are sorted, and every split is tried
constexpr uint32_t kSubtree = 1024;  // ranges up to this size are built by one thread

// Items that belong together: `side` says in which of the two arrays. A split writes its halves into the other one.
struct Range {
    uint32_t first = 0, count = 0, side = 0;
    float area = 0;  // of its box
    Bounds box, centers;
};

// A range that becomes a node, `depth` levels below the root: child `slot` of the node `parent`, or the root.
struct Task {
    Range range;
    uint32_t parent, slot, depth;
};
constexpr uint32_t kNoParent = ~0u;

class Builder {
public:
    Builder(std::span<const Box> boxes, uint32_t width, uint32_t max_depth) : width_(width), max_depth_(max_depth) {
        for (Side& side : sides_) side.boxes.resize(boxes.size()), side.index.resize(boxes.size());
        for (uint32_t i = 0; i < boxes.size(); ++i) {
            if (boxes[i].empty()) continue;
            const Bounds bounds = to_bounds(boxes[i]);
            sides_[0].boxes[root_.count] = bounds;
            sides_[0].index[root_.count++] = i;
            root_.box.add(bounds);
            root_.centers.add(bounds.center());
        }
        order_.resize(root_.count);
    }

    // Large ranges one after the other, then small ones side by side, whose nodes follow in their order.
    TopTree build() {
        std::vector<WideNode> nodes;
        if (root_.count == 0) return {{.width = width_, .nodes = {WideNode{}}, .order = {}, .rest = {}}, {}};
        std::vector<Task> small;
        build_nodes({root_, kNoParent, 0, 0}, nodes, &small);
        std::vector<std::vector<WideNode>> subtrees(small.size());
        parallel_for(small.size(), 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) build_nodes({small[i].range, kNoParent, 0, small[i].depth}, subtrees[i], nullptr);
        });
        nodes.reserve(std::accumulate(subtrees.begin(), subtrees.end(), nodes.size(), [](size_t sum, const auto& subtree) { return sum + subtree.size(); }));
        std::vector<uint32_t> parts;
        for (size_t i = 0; i < small.size(); ++i) {
            const auto first = static_cast<uint32_t>(nodes.size());
            parts.push_back(first);
            if (small[i].parent != kNoParent) nodes[small[i].parent].child[small[i].slot] = first;
            for (WideNode& node : subtrees[i]) {
                for (uint32_t& child : node.child)
                    if ((child & shared::kBvhLeaf) == 0) child += first;
                nodes.push_back(node);
            }
        }
        return {{.width = width_, .nodes = std::move(nodes), .order = std::move(order_), .rest = std::vector<uint8_t>(root_.count, 0)}, std::move(parts)};
    }

private:
    struct Side {
        std::vector<Bounds> boxes;
        std::vector<uint32_t> index;  // in the caller's array
    };

    // Appends the nodes of a range and of all below; with `small`, small ranges are left there.
    void build_nodes(const Task& root, std::vector<WideNode>& nodes, std::vector<Task>* small) {
        if (!small) nodes.reserve(root.range.count / 2 + 1);
        std::vector<Task> tasks{root};
        Range children[4];
        while (!tasks.empty()) {
            const Task task = tasks.back();
            tasks.pop_back();
            if (small && task.range.count <= kSubtree) {
                small->push_back(task);
                continue;
            }
            const auto at = static_cast<uint32_t>(nodes.size());
            if (task.parent != kNoParent) nodes[task.parent].child[task.slot] = at;
            WideNode& node = nodes.emplace_back();
            const uint32_t count = gather_children(task.range, children_hold(task.depth), children);
            for (uint32_t c = 0; c < count; ++c) {
                const Range& child = children[c];
                node.box[c] = to_box(child.box);
                if (child.count == 1) {
                    node.child[c] = shared::kBvhLeaf | child.first;
                    order_[child.first] = sides_[child.side].index[child.first];
                } else {
                    tasks.push_back({child, at, c, task.depth + 1});
                }
            }
        }
    }

    // Items that the children of a node at this depth may hold.
    uint64_t children_hold(uint32_t depth) const {
        const uint32_t bits = (width_ == 2 ? 1u : 2u) * (max_depth_ - depth - 1);
        return bits < 32 ? uint64_t(1) << bits : uint64_t(1) << 32;
    }

    // A node's children; `most`: items that each may hold. Ranges that are too large are split first, and so that two splits after
    // each other are enough; else the one with the largest surface, which rays would most likely open anyway.
    uint32_t gather_children(const Range& range, uint64_t most, Range (&children)[4]) {
        uint32_t count = 1;
        children[0] = range;
        if (range.count <= width_) {
            for (uint32_t i = range.count; i-- > 0;) children[i] = single(range.side, range.first + i);
            return range.count;
        }
        while (count < width_) {
            uint32_t best = 4;
            for (uint32_t c = 0; c < count; ++c) {
                if (children[c].count == 1) continue;
                const bool large = children[c].count > most, best_large = best < 4 && children[best].count > most;
                if (best == 4 || large > best_large || (large == best_large && children[c].area > children[best].area)) best = c;
            }
            if (best == 4) break;
            split(children[best], children[count++], children[best].count > 2 * most ? 2 * most : most);
        }
        return count;
    }

    Range single(uint32_t side, uint32_t position) const { return {.first = position, .count = 1, .side = side, .area = 0, .box = sides_[side].boxes[position], .centers = {}}; }

    // Divides a range of at least two items in two of at most `most`: itself and `right`.
    void split(Range& range, Range& right, uint64_t most) {
        if (range.count == 2) {
            right = single(range.side, range.first + 1);
            range = single(range.side, range.first);
        } else if (range.count <= kSmall) {
            split_small(range, right, most);
        } else if (!split_binned(range, right, most)) {
            halve(range, right);
        }
    }

    // Writes the items in this order to the other side, and the first `left` of them remain the range's.
    void divide(Range& range, Range& right, std::span<const uint32_t> order, uint32_t left) {
        const Side& from = sides_[range.side];
        Side& to = sides_[1 - range.side];
        Range halves[2] = {{.first = range.first, .count = left, .side = 1 - range.side}, {.first = range.first + left, .count = range.count - left, .side = 1 - range.side}};
        for (uint32_t i = 0; i < range.count; ++i) {
            const Bounds bounds = from.boxes[order[i]];
            to.boxes[range.first + i] = bounds;
            to.index[range.first + i] = from.index[order[i]];
            halves[i >= left].box.add(bounds);
            halves[i >= left].centers.add(bounds.center());
        }
        for (Range& half : halves) half.area = half.box.half_area();
        range = halves[0];
        right = halves[1];
    }

    // Sorted along the widest axis, the caller's order between equal centers; then the best split of all.
    void split_small(Range& range, Range& right, uint64_t most) {
        const std::vector<Bounds>& boxes = sides_[range.side].boxes;
        const int axis = range.centers.widest();
        const uint32_t count = range.count;
        std::array<float, kSmall> center;
        std::array<uint32_t, kSmall> order;
        for (uint32_t i = 0; i < count; ++i) {
            const float here = boxes[range.first + i].center(axis);
            uint32_t to = i;
            for (; to > 0 && center[to - 1] > here; --to) center[to] = center[to - 1], order[to] = order[to - 1];
            center[to] = here, order[to] = range.first + i;
        }
        std::array<float, kSmall> right_area;
        Bounds sum;
        for (uint32_t i = count; i-- > 1;) sum.add(boxes[order[i]]), right_area[i] = sum.half_area();
        sum = {};
        uint32_t best = count / 2;
        float best_cost = 3e38f;
        for (uint32_t i = 1; i < count; ++i) {
            sum.add(boxes[order[i - 1]]);
            const float cost = sum.half_area() * static_cast<float>(i) + right_area[i] * static_cast<float>(count - i);
            if (cost < best_cost && std::max(i, count - i) <= most) best_cost = cost, best = i;
        }
        divide(range, right, std::span(order).first(count), best);
    }

    // False: no split between bins serves.
    bool split_binned(Range& range, Range& right, uint64_t most) {
        const int axis = range.centers.widest();
        const float low = range.centers.low.v[axis], extent = range.centers.extent(axis);
        if (!(extent > 1e-30f)) return false;
        const float scale = static_cast<float>(kBins) * (1.0f - 1e-6f) / extent;
        const auto bin_of = [&](float center) { return std::min(static_cast<uint32_t>((center - low) * scale), kBins - 1); };
        const Side& from = sides_[range.side];
        std::array<Bounds, kBins> bins;
        std::array<uint32_t, kBins> counts{};
        for (uint32_t i = range.first; i < range.first + range.count; ++i) {
            const uint32_t bin = bin_of(from.boxes[i].center(axis));
            bins[bin].add(from.boxes[i]);
            ++counts[bin];
        }
        std::array<Bounds, kBins> right_of;  // of this bin and all that follow
        Bounds sum;
        for (uint32_t b = kBins; b-- > 1;) sum.add(bins[b]), right_of[b] = sum;
        sum = {};
        Range halves[2] = {{.first = range.first, .side = 1 - range.side}, {.side = 1 - range.side}};
        uint32_t best = 0, left = 0;
        float best_cost = 3e38f;
        for (uint32_t b = 1; b < kBins; ++b) {
            sum.add(bins[b - 1]);
            left += counts[b - 1];
            if (left == 0 || std::max(left, range.count - left) > most || left == range.count) continue;
            const float left_area = sum.half_area(), right_area = right_of[b].half_area();
            const float cost = left_area * static_cast<float>(left) + right_area * static_cast<float>(range.count - left);
            if (!(cost < best_cost)) continue;
            best_cost = cost, best = b;
            halves[0].count = left, halves[0].box = sum, halves[0].area = left_area;
            halves[1].box = right_of[b], halves[1].area = right_area;
        }
        if (best == 0) return false;
        halves[1].first = range.first + halves[0].count;
        halves[1].count = range.count - halves[0].count;
        Side& to = sides_[1 - range.side];
        uint32_t next[2] = {halves[0].first, halves[1].first};
        for (uint32_t i = range.first; i < range.first + range.count; ++i) {
            const Four center = from.boxes[i].center();
            const uint32_t half = bin_of(center.v[axis]) >= best, position = next[half]++;
            to.boxes[position] = from.boxes[i];
            to.index[position] = from.index[i];
            halves[half].centers.add(center);
        }
        range = halves[0];
        right = halves[1];
        return true;
    }

    // Equal numbers on both sides of the widest axis of the centers; the caller's order decides between equal ones.
    void halve(Range& range, Range& right) {
        const Side& from = sides_[range.side];
        const int axis = range.centers.widest();
        std::vector<uint32_t> order(range.count);
        std::iota(order.begin(), order.end(), range.first);
        std::nth_element(order.begin(), order.begin() + range.count / 2, order.end(), [&](uint32_t a, uint32_t b) {
            const float x = from.boxes[a].center(axis), y = from.boxes[b].center(axis);
            return x != y ? x < y : from.index[a] < from.index[b];
        });
        divide(range, right, order, range.count / 2);
    }

    uint32_t width_, max_depth_;
    Side sides_[2];
    Range root_;
    std::vector<uint32_t> order_;
};

}  // namespace

TopTree build_top_tree(std::span<const Box> boxes, uint32_t width, uint32_t max_depth) {
    PARHELION_CHECK((width == 2 || width == 4) && boxes.size() <= uint64_t(1) << std::min(32u, max_depth * (width == 2 ? 1 : 2)), "{} boxes do not fit into {} levels of {}", boxes.size(),
                    max_depth, width);
    return Builder(boxes, width, max_depth).build();
}

}  // namespace parhelion::bvh
