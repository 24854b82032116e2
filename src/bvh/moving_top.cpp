// Boxes of a tree that stays while what is in it moves: Wald, Boulos and Shirley 2007, "Ray tracing deformable scenes using dynamic
// bounding volume hierarchies"; when to build anew: Lauterbach et al. 2006, "RT-DEFORM", by expected cost instead of volumes.
#include "bvh/moving_top.h"

#include <algorithm>
#include <numeric>

#include "base/error.h"
#include "base/parallel.h"
#include "bvh/collapse.h"
#include "bvh/top_tree.h"

namespace parhelion::bvh {

namespace {
constexpr size_t kInstanceGrain = 1024;
}

bool worn_out(const TopCost& built, const TopCost& now, uint32_t refits) {
    return refits > kMostRefits || now.sum > kMostWear * built.sum || now.relative() > kMostWear * built.relative();
}

void MovingTop::begin(size_t count) {
    if (count > size_t(1) << shared::kBvhTopLevels)
        throw Error(ErrorCode::Failed, fmt::format("the scene has {} instances; our own BVH holds 2^24", count), "own BVH", "trace by pipeline or query");
    if (count != given_.size()) children_.clear();
    given_.resize(count);
    given_bounds_.resize(count);
}

void MovingTop::finish() {
    if (!children_.empty() && all_boxes_are_in_leaves()) {
        ++refits_;
        fit();
        if (!worn_out(built_, cost_, refits_)) return;
    }
    build();
    fit();
    built_ = cost_;
    refits_ = 0;
}

// There are as many boxes as leaves. If one in a leaf is gone and another has come, the tree's cost says so.
bool MovingTop::all_boxes_are_in_leaves() const {
    return size_t(std::ranges::count_if(given_bounds_, [](const Bounds& b) { return b.low.v[0] <= b.high.v[0]; })) == order_.size();
}

void MovingTop::build() {
    std::vector<Box> boxes(given_bounds_.size());
    std::ranges::transform(given_bounds_, boxes.begin(), to_box);
    TopTree tree = build_top_tree(boxes, node_width(nodes_.layout), max_top_depth(nodes_.layout));
    order_ = std::move(tree.order);
    parts_ = std::move(tree.parts);
    items_.resize(order_.size());
    bounds_.resize(order_.size() + tree.nodes.size());
    children_.resize(tree.nodes.size());
    std::ranges::transform(tree.nodes, children_.begin(), [](const WideNode& node) { return glm::uvec4(node.child[0], node.child[1], node.child[2], node.child[3]); });
    nodes_.words.resize(children_.size() * node_bytes(nodes_.layout) / sizeof(uint32_t));
}

// Leaves, parts side by side, then what is above these; sums in that order, so that they do not show the threads.
void MovingTop::fit() {
    parallel_for(order_.size(), kInstanceGrain, [&](size_t begin, size_t end) {
        for (size_t leaf = begin; leaf < end; ++leaf) items_[leaf] = given_[order_[leaf]], bounds_[leaf] = given_bounds_[order_[leaf]];
    });
    const auto node_count = static_cast<uint32_t>(children_.size());
    std::vector<double> sums(parts_.size());
    parallel_for(parts_.size(), 1, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p) sums[p] = fit_nodes(parts_[p], p + 1 < parts_.size() ? parts_[p + 1] : node_count);
    });
    const double above = fit_nodes(0, parts_.empty() ? node_count : parts_.front());
    cost_.root = order_.empty() ? 0 : double(bounds_[order_.size()].half_area());
    cost_.sum = std::accumulate(sums.begin(), sums.end(), above + double(node_cost(node_width(nodes_.layout))) * cost_.root);
}

// Nodes [begin, end) from the last up; returns the cost of all their children: infinite if one is a leaf whose item has no box.
double MovingTop::fit_nodes(uint32_t begin, uint32_t end) {
    const uint32_t width = node_width(nodes_.layout);
    const auto first_node = static_cast<uint32_t>(order_.size());
    const float cost[2] = {node_cost(width), 1.0f};
    double sum = 0;
    for (uint32_t n = end; n-- > begin;) {
        const glm::uvec4& children = children_[n];
        Bounds boxes[4], all;
        for (uint32_t c = 0; c < width && children[c] != shared::kBvhEmpty; ++c) {
            const bool leaf = (children[c] & shared::kBvhLeaf) != 0;
            boxes[c] = bounds_[leaf ? children[c] & shared::kBvhItemMask : first_node + children[c]];
            sum += double(cost[leaf] * boxes[c].half_area());
            all.add(boxes[c]);
        }
        bounds_[first_node + n] = all;
        nodes_.write(n, {.min_x = lows(boxes, 0), .max_x = highs(boxes, 0), .min_y = lows(boxes, 1), .max_y = highs(boxes, 1), .min_z = lows(boxes, 2), .max_z = highs(boxes, 2), .child = children});
    }
    return sum;
}

}  // namespace parhelion::bvh
