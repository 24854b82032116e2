#include "bvh/collapse.h"

#include <algorithm>
#include <array>

#include "base/parallel.h"

namespace parhelion::bvh {

namespace {

using shared::kBvhItemMask;
using shared::kBvhLeaf;

constexpr uint32_t kMaxWidth = 4;
constexpr uint32_t kAlone = 1u << 12;  // subtrees up to this size are written by one thread

bool is_reference(uint32_t child) { return (child & kBvhLeaf) != 0; }

// The best that can be made of a binary node as a forest of at most j + 1 wide trees (j: 0 to width - 2).
struct Plan {
    std::array<float, kMaxWidth - 1> cost;
    uint32_t references;                     // below it
    std::array<uint8_t, kMaxWidth - 1> height;  // levels of wide nodes, of the highest tree
    // How many trees the left child gets of j + 1; 0: it is a forest of j trees. choice[0]: of the children of one wide node, 0: a leaf.
    std::array<uint8_t, kMaxWidth - 1> choice;
    uint8_t binary_height;                   // above ranges that fit into a leaf
};

class Planner {
public:
    Planner(const BinaryTree& tree, uint32_t width, uint32_t max_leaf, float cost_of_node) : tree_(tree), width_(width), max_leaf_(max_leaf), node_cost_(cost_of_node) {
        plans = std::make_unique_for_overwrite<Plan[]>(tree.slots);
        const float root = tree.box_of(tree.root).half_area();
        scale_ = root > 0.0f ? 1.0f / root : 0.0f;
        if (!(scale_ < 3e38f)) scale_ = 0.0f;
    }

    void make() {
        parallel_for(tree_.subtrees.size(), 1, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) plan_below(tree_.subtrees[i]);
        });
        for (size_t i = tree_.top.size(); i-- > 0;) plan(tree_.top[i]);
    }

    std::unique_ptr<Plan[]> plans;

private:
    // As deep as the binary tree is high, which is bounded.
    void plan_below(uint32_t child) {
        if (is_reference(child)) return;
        plan_below(tree_.nodes[child].left);
        plan_below(tree_.nodes[child].right);
        plan(child);
    }

    float area(uint32_t child) const { return tree_.box_of(child).half_area() * scale_; }
    float cost(uint32_t child, float reference_area, uint32_t trees) const { return is_reference(child) ? reference_area : plans[child].cost[trees - 1]; }
    uint8_t height(uint32_t child, uint32_t trees) const { return is_reference(child) ? 0 : plans[child].height[trees - 1]; }
    uint32_t references(uint32_t child) const { return is_reference(child) ? 1 : plans[child].references; }
    uint8_t binary_height(uint32_t child) const { return is_reference(child) ? 0 : plans[child].binary_height; }

    void plan(uint32_t index) {
        const uint32_t left = tree_.nodes[index].left, right = tree_.nodes[index].right;
        const float own_area = area(index), left_area = is_reference(left) ? area(left) : 0.0f, right_area = is_reference(right) ? area(right) : 0.0f;
        Plan& plan = plans[index];
        plan.references = references(left) + references(right);
        const bool fits = plan.references <= max_leaf_;
        plan.binary_height = fits ? 0 : static_cast<uint8_t>(1 + std::max(binary_height(left), binary_height(right)));
        struct Best {
            float cost = 3.4e38f;
            uint8_t left_trees = 1, height = 0;
        };
        const auto divide = [&](uint32_t trees) {
            Best best;
            for (uint32_t k = 1; k < trees; ++k) {
                const float sum = cost(left, left_area, k) + cost(right, right_area, trees - k);
                if (sum < best.cost) best = {sum, static_cast<uint8_t>(k), std::max(height(left, k), height(right, trees - k))};
            }
            return best;
        };
        const Best inner = divide(width_);
        const float inner_cost = node_cost_ * own_area + inner.cost, leaf_cost = own_area * float(plan.references);
        if (fits && leaf_cost <= inner_cost) plan.cost[0] = leaf_cost, plan.choice[0] = 0, plan.height[0] = 0;
        else plan.cost[0] = inner_cost, plan.choice[0] = inner.left_trees, plan.height[0] = static_cast<uint8_t>(1 + inner.height);
        for (uint32_t trees = 2; trees < width_; ++trees) {
            const Best best = divide(trees);
            const uint32_t j = trees - 1;
            if (best.cost < plan.cost[j - 1]) plan.cost[j] = best.cost, plan.choice[j] = best.left_trees, plan.height[j] = best.height;
            else plan.cost[j] = plan.cost[j - 1], plan.choice[j] = 0, plan.height[j] = plan.height[j - 1];
        }
    }

    const BinaryTree& tree_;
    const uint32_t width_, max_leaf_;
    const float node_cost_;
    float scale_;
};

// Writes wide nodes below some binary nodes.
class Writer {
public:
    Writer(const BinaryTree& tree, const Plan* plans, uint32_t width, uint32_t max_leaf) : tree_(tree), plans_(plans), width_(width), max_leaf_(max_leaf) { out.width = width; }

    struct Task {
        uint32_t binary, wide, room;  // room: levels of nodes from here on
    };

    // Subtrees of at most `leave` references are not written but left in `left_over`.
    void write(Task first, uint32_t leave) {
        std::vector<Task> tasks{first};
        while (!tasks.empty()) {
            const Task task = tasks.back();
            tasks.pop_back();
            if (plans_[task.binary].references <= leave) left_over.push_back(task);
            else write_node(task, tasks);
        }
    }

    void write_leaf(uint32_t wide, uint32_t slot, uint32_t binary) {
        out.nodes[wide].box[slot] = tree_.box_of(binary);
        out.nodes[wide].child[slot] = kBvhLeaf | static_cast<uint32_t>(out.order.size());
        const size_t first = out.order.size();
        add_references(binary);
        // Two parts of a triangle in the same leaf are one.
        std::sort(out.order.begin() + static_cast<std::ptrdiff_t>(first), out.order.end());
        out.order.erase(std::unique(out.order.begin() + static_cast<std::ptrdiff_t>(first), out.order.end()), out.order.end());
        for (size_t i = first; i < out.order.size(); ++i) out.rest.push_back(static_cast<uint8_t>(out.order.size() - 1 - i));
    }

    WideTree out;
    std::vector<Task> left_over;

private:
    struct Children {
        std::array<uint32_t, kMaxWidth> node;  // of the binary tree
        uint32_t count = 0;
    };

    void write_node(const Task& task, std::vector<Task>& tasks) {
        Children children;
        if (plans_[task.binary].height[0] <= task.room) take_planned(task.binary, children);
        else take_flat(task.binary, task.room - 1, children);
        for (uint32_t c = 0; c < children.count; ++c) {
            const uint32_t child = children.node[c];
            if (is_leaf(child, task.room - 1)) {
                write_leaf(task.wide, c, child);
                continue;
            }
            out.nodes[task.wide].box[c] = tree_.box_of(child);
            out.nodes[task.wide].child[c] = static_cast<uint32_t>(out.nodes.size());
            tasks.push_back({child, static_cast<uint32_t>(out.nodes.size()), task.room - 1});
            out.nodes.emplace_back();
        }
    }

    bool is_leaf(uint32_t child, uint32_t room) const {
        return is_reference(child) || (plans_[child].references <= max_leaf_ && (plans_[child].choice[0] == 0 || plans_[child].height[0] > room));
    }

    void take_planned(uint32_t binary, Children& children) const {
        const uint32_t left_trees = plans_[binary].choice[0];
        take_forest(tree_.nodes[binary].left, left_trees, children);
        take_forest(tree_.nodes[binary].right, width_ - left_trees, children);
    }

    void take_forest(uint32_t child, uint32_t trees, Children& children) const {
        if (!is_reference(child)) {
            while (trees > 1 && plans_[child].choice[trees - 1] == 0) --trees;
            if (trees > 1) {
                const uint32_t left_trees = plans_[child].choice[trees - 1];
                take_forest(tree_.nodes[child].left, left_trees, children);
                return take_forest(tree_.nodes[child].right, trees - left_trees, children);
            }
        }
        children.node[children.count++] = child;
    }

    // Where the plan is too deep: nodes too high for the `room` levels that may follow are opened first. Four children take two of
    // their levels along, so a binary tree of height width / 2 * room always fits. Else the one with the largest surface.
    void take_flat(uint32_t binary, uint32_t room, Children& children) const {
        children.node[children.count++] = binary;
        while (children.count < width_) {
            uint32_t best = kMaxWidth;
            bool best_forced = false;
            float best_area = 0;
            for (uint32_t c = 0; c < children.count; ++c) {
                const uint32_t child = children.node[c];
                if (is_reference(child) || plans_[child].references <= max_leaf_) continue;
                const bool forced = plans_[child].binary_height > width_ / 2 * room;
                const float area = tree_.nodes[child].box().half_area();
                if (best == kMaxWidth || forced > best_forced || (forced == best_forced && area > best_area)) best = c, best_forced = forced, best_area = area;
            }
            if (best == kMaxWidth) break;
            const BinaryNode& node = tree_.nodes[children.node[best]];
            children.node[best] = node.left;
            children.node[children.count++] = node.right;
        }
    }

    void add_references(uint32_t child) {
        if (is_reference(child)) return out.order.push_back(tree_.references[child & kBvhItemMask].index);
        add_references(tree_.nodes[child].left);
        add_references(tree_.nodes[child].right);
    }

    const BinaryTree& tree_;
    const Plan* plans_;
    const uint32_t width_, max_leaf_;
};

// Appends what was written below `task`: its node 0 takes the task's place.
void append(WideTree& tree, const Writer::Task& task, WideTree part) {
    const auto first_node = static_cast<uint32_t>(tree.nodes.size() - 1), first_item = static_cast<uint32_t>(tree.order.size());
    for (WideNode& node : part.nodes)
        for (uint32_t& child : node.child)
            if (child != shared::kBvhEmpty) child += (child & kBvhLeaf) != 0 ? first_item : first_node;
    tree.nodes[task.wide] = part.nodes.front();
    tree.nodes.insert(tree.nodes.end(), part.nodes.begin() + 1, part.nodes.end());
    tree.order.insert(tree.order.end(), part.order.begin(), part.order.end());
    tree.rest.insert(tree.rest.end(), part.rest.begin(), part.rest.end());
}

}  // namespace

WideTree collapse(BinaryTree tree, uint32_t width, uint32_t max_leaf, uint32_t max_depth, float cost_of_node) {
    WideTree none{.width = width, .nodes = std::vector<WideNode>(1), .order = {}, .rest = {}};
    if (tree.root == shared::kBvhEmpty) return none;
    Planner planner(tree, width, max_leaf, cost_of_node);
    planner.make();
    const Plan* plans = planner.plans.get();
    Writer top(tree, plans, width, max_leaf);
    top.out.nodes.resize(1);
    if (is_reference(tree.root) || (plans[tree.root].references <= max_leaf && plans[tree.root].choice[0] == 0)) {
        top.write_leaf(0, 0, tree.root);
        return std::move(top.out);
    }
    const uint32_t all = plans[tree.root].references;
    top.write({tree.root, 0, max_depth}, all <= kAlone ? 0 : std::max(kAlone, all / 128));
    std::vector<WideTree> parts(top.left_over.size());
    parallel_for(parts.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            Writer writer(tree, plans, width, max_leaf);
            const uint32_t references = plans[top.left_over[i].binary].references;
            writer.out.nodes.reserve(references / 2), writer.out.order.reserve(references), writer.out.rest.reserve(references);
            writer.out.nodes.resize(1);
            writer.write({top.left_over[i].binary, 0, top.left_over[i].room}, 0);
            parts[i] = std::move(writer.out);
        }
    });
    planner.plans.reset();
    tree = {};
    size_t nodes = top.out.nodes.size(), references = top.out.order.size();
    for (const WideTree& part : parts) nodes += part.nodes.size() - 1, references += part.order.size();
    top.out.nodes.reserve(nodes), top.out.order.reserve(references), top.out.rest.reserve(references);
    for (size_t i = 0; i < parts.size(); ++i) append(top.out, top.left_over[i], std::move(parts[i]));
    return std::move(top.out);
}

}  // namespace parhelion::bvh
