// Boxes of a tree that stays while what is in it moves: Wald, Boulos and Shirley 2007, "Ray tracing deformable scenes using dynamic
// bounding volume hierarchies"; when to build anew: Lauterbach et al. 2006, "RT-DEFORM", by expected cost instead of volumes.
#include "bvh/moving_top.h"

#include <algorithm>
#include <limits>
#include <numeric>

#include "base/error.h"
#include "base/parallel.h"
#include "bvh/collapse.h"
#include "bvh/four.h"
#include "bvh/top_tree.h"

namespace parhelion::bvh {

namespace {

Four four(const glm::vec4& v) { return {{v.x, v.y, v.z, v.w}}; }

// All children's boxes in one; those of children that are not there are empty.
Box joined(const shared::BvhNode& node) {
    return {{lowest(four(node.min_x)), lowest(four(node.min_y)), lowest(four(node.min_z))}, {highest(four(node.max_x)), highest(four(node.max_y)), highest(four(node.max_z))}};
}

}  // namespace

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
    return !nodes_.empty() && items.size() == item_count_ && size_t(std::ranges::count_if(items, [](const TopItem& item) { return !item.box_ws.empty(); })) == order_.size();
}

void MovingTop::build(std::span<const TopItem> items) {
    boxes_.resize(items.size());
    for (size_t i = 0; i < items.size(); ++i) boxes_[i] = items[i].box_ws;
    const Layout layout = top_.nodes.layout;
    TopTree tree = build_top_tree(boxes_, node_width(layout), max_top_depth(layout));
    item_count_ = items.size();
    order_ = std::move(tree.order);
    parts_ = std::move(tree.parts);
    nodes_.resize(tree.nodes.size());
    std::ranges::transform(tree.nodes, nodes_.begin(), to_shared);
    top_.nodes.words.resize(nodes_.size() * node_bytes(layout) / sizeof(uint32_t));
    top_.items.resize(order_.size());
}

// Parts side by side, then what is above them; sums in that order, so that they do not show the threads.
void MovingTop::fit(std::span<const TopItem> items) {
    std::vector<double> sums(parts_.size());
    parallel_for(parts_.size(), 1, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) sums[p] = fit_nodes(items, parts_[p], p + 1 < parts_.size() ? parts_[p + 1] : static_cast<uint32_t>(nodes_.size()));
    });
    const double above = fit_nodes(items, 0, parts_.empty() ? static_cast<uint32_t>(nodes_.size()) : parts_.front());
    cost_.root = double(joined(nodes_.front()).half_area());
    cost_.sum = std::accumulate(sums.begin(), sums.end(), above + double(node_cost(node_width(top_.nodes.layout))) * cost_.root);
}

// Nodes [begin, end) from the last up, and the items in their leaves; returns the cost of all their children, infinite if one of the
// items has no box.
double MovingTop::fit_nodes(std::span<const TopItem> items, uint32_t begin, uint32_t end) {
    const uint32_t width = node_width(top_.nodes.layout);
    double inner = 0, leaves = 0;
    for (uint32_t n = end; n-- > begin;) {
        shared::BvhNode& node = nodes_[n];
        for (uint32_t c = 0; c < width; ++c) {
            const uint32_t child = node.child[c];
            if (child == shared::kBvhEmpty) continue;
            Box box;
            if ((child & shared::kBvhLeaf) != 0) {
                const uint32_t leaf = child & shared::kBvhItemMask;
                const TopItem& item = items[order_[leaf]];
                top_.items[leaf] = item.item;
                box = item.box_ws;
                leaves += box.empty() ? std::numeric_limits<double>::infinity() : double(box.half_area());
            } else {
                box = joined(nodes_[child]);
                inner += double(box.half_area());
            }
            node.min_x[c] = box.min.x, node.max_x[c] = box.max.x;
            node.min_y[c] = box.min.y, node.max_y[c] = box.max.y;
            node.min_z[c] = box.min.z, node.max_z[c] = box.max.z;
        }
        top_.nodes.write(n, node);
    }
    return double(node_cost(width)) * inner + leaves;
}

}  // namespace parhelion::bvh
