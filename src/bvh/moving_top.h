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
    explicit MovingTop(Layout layout) { top_.nodes.layout = layout; }

    // The top level over these items, valid until the next call. The tree stays if as many items as before have boxes, in the same
    // places of the array, and it is not worn out. At most 2^24 items (the depth bound); throws Error beyond.
    const Top& update(std::span<const TopItem> items);

    const TopCost& cost() const { return cost_; }
    uint32_t refits() const { return refits_; }  // since the tree was built
    Top take() && { return std::move(top_); }

private:
    bool may_serve(std::span<const TopItem> items) const;
    void build(std::span<const TopItem> items);
    void fit(std::span<const TopItem> items);
    double fit_nodes(std::span<const TopItem> items, uint32_t begin, uint32_t end);

    std::vector<glm::uvec4> children_;  // by node, parents first
    std::vector<Bounds> bounds_;        // by node: all its children's
    std::vector<uint32_t> order_;       // by leaf: its item
    std::vector<uint32_t> parts_;       // TopTree's
    size_t item_count_ = 0;
    TopCost built_, cost_;
    uint32_t refits_ = 0;
    std::vector<Box> boxes_;
    Top top_;
};

}  // namespace parhelion::bvh
