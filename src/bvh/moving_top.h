#pragma once
// The top level of a scene whose instances move. From frame to frame the tree stays and gets new boxes, from its leaves up, as long as
// they are as good as a new tree's would be, about; then a new one is built. Which of both happens depends on the boxes alone, never
// on time, and no hit depends on it (docs/architecture.md): a tree only says what a ray need not look at.
#include "bvh/bounds.h"
#include "bvh/bvh.h"

namespace parhelion::bvh {

// What a ray is expected to cost: node_cost() times the half surfaces of all nodes, plus those of the leaves; square metres.
struct TopCost {
    double sum = 0;
    double root = 0;  // half surface of the whole
    double relative() const { return root > 0 ? sum / root : 0; }
};

// A tree is worn out when its boxes cost more than kMostWear times what they did when it was built, as they are (what moves apart) or
// relative to the whole (what mixes while it shrinks); and after kMostRefits refits, because neither sees what gathers far from a
// straggler.
inline constexpr double kMostWear = 1.2;
inline constexpr uint32_t kMostRefits = 64;
bool worn_out(const TopCost& built, const TopCost& now, uint32_t refits);

class MovingTop {
public:
    explicit MovingTop(Layout layout) { nodes_.layout = layout; }

    // A frame: begin() says how many items there are, set() every one of them (several threads may, each others), finish() makes the
    // top level, which is valid until the next begin(). The tree stays if it has as many items as before, the same of them have boxes,
    // and it is not worn out. At most 2^24 items (the depth bound); throws Error beyond.
    void begin(size_t count);
    void set(size_t i, const TopItem& item) {
        given_[i] = item.item;
        given_bounds_[i] = to_bounds(item.box_ws);
    }
    void finish();

    const Nodes& nodes() const { return nodes_; }
    std::span<const shared::BvhTopItem> items() const { return items_; }  // by leaf
    const TopCost& cost() const { return cost_; }
    uint32_t refits() const { return refits_; }  // since the tree was built

private:
    bool all_boxes_are_in_leaves() const;
    void build();
    void fit();
    double fit_nodes(uint32_t begin, uint32_t end);

    std::vector<shared::BvhTopItem> given_;  // in the caller's order
    std::vector<Bounds> given_bounds_;
    std::vector<uint32_t> order_;            // by leaf: which of them
    std::vector<shared::BvhTopItem> items_;  // by leaf
    std::vector<Bounds> bounds_;             // by leaf; then by node: around all of its children
    std::vector<glm::uvec4> children_;       // by node, parents first
    std::vector<uint32_t> parts_;            // TopTree's
    TopCost built_, cost_;
    uint32_t refits_ = 0;
    Nodes nodes_;
};

}  // namespace parhelion::bvh
