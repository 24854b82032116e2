// Boxes of a tree that stays while what is in it moves: Wald, Boulos and Shirley 2007, "Ray tracing deformable scenes using dynamic
// bounding volume hierarchies"; when to build anew: Lauterbach et al. 2006, "RT-DEFORM", by expected cost instead of volumes.
#include "bvh/moving_top.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "base/parallel.h"
#include "bvh/collapse.h"
#include "bvh/top_tree.h"

namespace parhelion::bvh {

bool worn_out(const TopCost& built, const TopCost& now, uint32_t refits) {
    return refits > kMostRefits || now.sum > kMostWear * built.sum || now.relative() > kMostWear * built.relative();
}

const Top& MovingTop::update(std::span<const TopItem> items) {
    if (items.size() > size_t(1) << shared::kBvhTopLevels)
        throw Error(ErrorCode::Failed, fmt::format("the scene has {} instances; our own BVH holds 2^24", items.size()), "own BVH", "trace by pipeline or query");
    if (may_serve(items)) {
        ++refits_;
        fit(items);
        if (!worn_out(built_, cost_, refits_)) return top_;
    }
    build(items);
    fit(items);
    built_ = cost_;
    refits_ = 0;
    return top_;
}

// As many boxes as there are leaves; and fit_nodes() finds one for each leaf: then it is the same items that have none.
bool MovingTop::may_serve(std::span<const TopItem> items) const {
    return !children_.empty() && items.size() == item_count_ && size_t(std::ranges::count_if(items, [](const TopItem& item) { return !item.box_ws.empty(); })) == order_.size();
}

void MovingTop::build(std::span<const TopItem> items) {
    boxes_.resize(items.size());
    for (size_t i = 0; i < items.size(); ++i) boxes_[i] = items[i].box_ws;
    const Layout layout = top_.nodes.layout;
    TopTree tree = build_top_tree(boxes_, node_width(layout), max_top_depth(layout));
    item_count_ = items.size();
    order_ = std::move(tree.order);
    parts_ = std::move(tree.parts);
    bounds_.resize(tree.nodes.size());
    children_.resize(tree.nodes.size());
    std::ranges::transform(tree.nodes, children_.begin(), [](const WideNode& node) { return glm::uvec4(node.child[0], node.child[1], node.child[2], node.child[3]); });
    top_.nodes.words.resize(children_.size() * node_bytes(layout) / sizeof(uint32_t));
    top_.items.resize(order_.size());
}

// Parts side by side, then what is above them; sums in that order, so that they do not show the threads.
void MovingTop::fit(std::span<const TopItem> items) {
    const auto node_count = static_cast<uint32_t>(children_.size());
    std::vector<double> sums(parts_.size());
    parallel_for(parts_.size(), 1, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) sums[p] = fit_nodes(items, parts_[p], p + 1 < parts_.size() ? parts_[p + 1] : node_count);
    });
    const double above = fit_nodes(items, 0, parts_.empty() ? node_count : parts_.front());
    cost_.root = order_.empty() ? 0 : double(bounds_.front().half_area());
    cost_.sum = std::accumulate(sums.begin(), sums.end(), above + double(node_cost(node_width(top_.nodes.layout))) * cost_.root);
}

// Nodes [begin, end) from the last up, and the items in their leaves; returns the cost of all their children, infinite if one of the
// items has no box.
double MovingTop::fit_nodes(std::span<const TopItem> items, uint32_t begin, uint32_t end) {
    const uint32_t width = node_width(top_.nodes.layout);
    double inner = 0, leaves = 0;
    for (uint32_t n = end; n-- > begin;) {
        Bounds boxes[4], all;
        for (uint32_t c = 0; c < width; ++c) {
            const uint32_t child = children_[n][c];
            if (child == shared::kBvhEmpty) continue;
            if ((child & shared::kBvhLeaf) != 0) {
                const uint32_t leaf = child & shared::kBvhItemMask;
                const TopItem& item = items[order_[leaf]];
                top_.items[leaf] = item.item;
                boxes[c] = to_bounds(item.box_ws);
                leaves += item.box_ws.empty() ? std::numeric_limits<double>::infinity() : double(boxes[c].half_area());
            } else {
                boxes[c] = bounds_[child];
                inner += double(boxes[c].half_area());
            }
            all.add(boxes[c]);
        }
        bounds_[n] = all;
        top_.nodes.write(n, {.min_x = lows(boxes, 0), .max_x = highs(boxes, 0), .min_y = lows(boxes, 1), .max_y = highs(boxes, 1), .min_z = lows(boxes, 2), .max_z = highs(boxes, 2), .child = children_[n]});
    }
    return double(node_cost(width)) * inner + leaves;
}

}  // namespace parhelion::bvh
