// The top level of a scene that moves: whatever tree it keeps, it holds every item, hits are those of a tree that was built for them,
// and it is built anew when it is worn out.
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/parallel.h"
#include "bvh/moving_top.h"
#include "bvh/top_tree.h"
#include "support/bvh_scene.h"

namespace parhelion::bvh::testing::bvh_moving_top_test {
namespace {

using shared::kBvhEmpty;
using shared::kBvhItemMask;
using shared::kBvhLeaf;

class BvhMovingTop : public EachLayout {};
INSTANTIATE_TEST_SUITE_P(Nodes, BvhMovingTop, ::testing::ValuesIn(kLayouts), layout_of);

// Turned and scaled things in a square, each on a way of its own.
class Crowd {
public:
    Crowd(uint32_t count, float half_square) : random_(7), half_(half_square) {
        for (uint32_t i = 0; i < count; ++i) {
            glm::mat4 m(1.0f);
            for (int c = 0; c < 3; ++c) m[c] = glm::vec4(random_.in_cube(1.0f), 0.0f);
            m[3] = glm::vec4(random_.range(-half_, half_), random_.range(0, 3), random_.range(-half_, half_), 1.0f);
            places.push_back(m);
            ways_.push_back(random_.direction());
        }
    }
    void move(float step) {
        for (size_t i = 0; i < places.size(); ++i) places[i][3] += glm::vec4(step * ways_[i], 0.0f);
    }
    void shuffle() {
        for (glm::mat4& m : places) m[3] = glm::vec4(random_.range(-half_, half_), random_.range(0, 3), random_.range(-half_, half_), 1.0f);
    }
    std::vector<TopItem> items(const Bottoms& bottoms) const {
        std::vector<TopItem> out;
        for (uint32_t i = 0; i < places.size(); ++i) out.push_back(make_top_item(bottoms, 0, places[i], i));
        return out;
    }
    std::vector<glm::mat4> places;

private:
    Random random_;
    float half_;
    std::vector<glm::vec3> ways_;
};

Bottoms one_mesh() {
    Bottoms bottoms{.nodes = {.layout = TestScene::layout, .words = {}}, .triangles = {}, .roots = {}};
    const TestGeometry mesh = make_icosphere(1, 1.0f);
    const BottomGeometry geometry{mesh.positions, mesh.triangles};
    add_bottom(bottoms, {&geometry, 1});
    return bottoms;
}

void update(MovingTop& top, std::span<const TopItem> items) {
    top.begin(items.size());
    for (size_t i = 0; i < items.size(); ++i) top.set(i, items[i]);
    top.finish();
}

Top copy(const MovingTop& top) { return {top.nodes(), {top.items().begin(), top.items().end()}}; }

// Every item that has a box is in one leaf, as it is now, and its box within all boxes on the way to it; no node is too deep.
void check(const MovingTop& top, std::span<const TopItem> items) {
    struct Task {
        uint32_t node, depth;
        Box box;
    };
    std::vector<Task> stack{{0, 1, {glm::vec3(-3e38f), glm::vec3(3e38f)}}};
    std::set<uint32_t> seen;
    size_t nodes = 0;
    while (!stack.empty()) {
        const Task task = stack.back();
        stack.pop_back();
        ++nodes;
        ASSERT_LE(task.depth, max_top_depth(top.nodes().layout));
        const shared::BvhNode node = top.nodes().read(task.node);
        for (int c = 0; c < 4; ++c) {
            const uint32_t child = node.child[c];
            if (child == kBvhEmpty) continue;
            // Quantised boxes need not lie within those above them: what they have in common counts.
            const Box box{glm::max(task.box.min, glm::vec3(node.min_x[c], node.min_y[c], node.min_z[c])), glm::min(task.box.max, glm::vec3(node.max_x[c], node.max_y[c], node.max_z[c]))};
            if ((child & kBvhLeaf) == 0) {
                stack.push_back({child, task.depth + 1, box});
                continue;
            }
            const shared::BvhTopItem& item = top.items()[child & kBvhItemMask];
            ASSERT_LT(item.instance, items.size());
            const TopItem& given = items[item.instance];
            ASSERT_TRUE(seen.insert(item.instance).second);
            ASSERT_EQ(std::memcmp(&item, &given.item, sizeof(item)), 0) << "an item of another frame";
            ASSERT_TRUE(glm::all(glm::lessThanEqual(box.min, given.box_ws.min)) && glm::all(glm::greaterThanEqual(box.max, given.box_ws.max))) << item.instance;
        }
    }
    ASSERT_EQ(nodes, top.nodes().size());
    size_t there = 0;
    for (const TopItem& item : items) there += !item.box_ws.empty();
    ASSERT_EQ(seen.size(), there);
    ASSERT_EQ(top.items().size(), there);
}

TEST_P(BvhMovingTop, every_item_stays_within_the_boxes_above_it_while_all_move) {
    const Bottoms bottoms = one_mesh();
    for (const uint32_t count : {1u, 2u, 5u, 300u, 3000u}) {
        Crowd crowd(count, 40.0f);
        MovingTop top(GetParam());
        uint32_t refitted = 0;
        for (int frame = 0; frame < 12; ++frame) {
            SCOPED_TRACE(fmt::format("{} items, frame {}", count, frame));
            const std::vector<TopItem> items = crowd.items(bottoms);
            update(top, items);
            ASSERT_NO_FATAL_FAILURE(check(top, items));
            refitted += top.refits() > 0;
            crowd.move(0.02f);
        }
        EXPECT_GE(refitted, 6u) << count;
    }
}

TEST_P(BvhMovingTop, hits_are_those_of_a_new_tree_through_a_hundred_frames_of_large_motion) {
    const Bottoms bottoms = one_mesh();
    Crowd crowd(400, 20.0f);
    MovingTop top(GetParam());
    Random random(9);
    uint32_t built = 0, hits = 0;
    for (int frame = 0; frame < 100; ++frame) {
        const std::vector<TopItem> items = crowd.items(bottoms);
        update(top, items);
        built += top.refits() == 0;
        const Top kept = copy(top), fresh = build_top(items, GetParam());
        for (int i = 0; i < 30; ++i) {
            const glm::vec3 from = random.in_cube(30.0f), to = glm::vec3(crowd.places[random.below(400)][3]) + random.in_cube(1.0f);
            const shared::TraversalRay ray = make_ray(from, to - from);
            shared::TraversalHit a{}, b{};
            const bool hit = trace_closest_host(bottoms, kept, ray, a), expected = trace_closest_host(bottoms, fresh, ray, b);
            ASSERT_EQ(hit, expected) << frame;
            ASSERT_EQ(trace_any_host(bottoms, kept, ray), expected);
            if (!hit) continue;
            ++hits;
            ASSERT_EQ(std::memcmp(&a, &b, sizeof(a)), 0) << frame;
        }
        crowd.move(0.15f);  // 15 m in all: nothing stays beside what it was beside
    }
    EXPECT_GT(hits, 1500u);
    EXPECT_GE(built, 5u) << "trees should wear out";
    EXPECT_LE(built, 60u) << "and not with every step";
}

TEST_P(BvhMovingTop, the_expected_cost_is_that_of_its_tree) {
    const Bottoms bottoms = one_mesh();
    Crowd crowd(3000, 40.0f);
    MovingTop top(GetParam());
    const std::vector<TopItem> items = crowd.items(bottoms);
    update(top, items);
    std::vector<Box> boxes;
    for (const TopItem& item : items) boxes.push_back(item.box_ws);
    const double expected = measure(build_top_tree(boxes, node_width(GetParam()), max_top_depth(GetParam()))).cost;
    EXPECT_NEAR(top.cost().relative(), expected, 1e-5 * expected);
    // Sums do not show how far it is from the tree's making: the same boxes cost the same.
    const TopCost built = top.cost();
    update(top, items);
    EXPECT_EQ(top.refits(), 1u);
    EXPECT_EQ(top.cost().sum, built.sum);
}

TEST(BvhMovingTopRule, a_tree_is_worn_out_by_what_its_boxes_cost_and_by_refits) {
    const TopCost built{.sum = 100.0, .root = 10.0};
    const auto worn = [&](double sum, double root, uint32_t refits = 1) { return worn_out(built, {.sum = sum, .root = root}, refits); };
    EXPECT_FALSE(worn(100.0, 10.0));
    EXPECT_FALSE(worn(100.0 * kMostWear * 0.999, 10.0));
    EXPECT_TRUE(worn(100.0 * kMostWear * 1.001, 10.0));
    EXPECT_TRUE(worn(130.0, 20.0)) << "apart: the whole grows with it";
    EXPECT_TRUE(worn(65.0, 5.0)) << "mixed while it shrinks";
    EXPECT_FALSE(worn(50.0, 5.0));
    EXPECT_FALSE(worn(100.0, 10.0, kMostRefits));
    EXPECT_TRUE(worn(100.0, 10.0, kMostRefits + 1));
    EXPECT_TRUE(worn(std::numeric_limits<double>::infinity(), 10.0));
    EXPECT_FALSE(worn_out({}, {}, 1)) << "points at one place";
}

TEST(BvhMovingTopRule, the_tree_is_as_good_as_a_new_one_but_for_the_bound) {
    const Bottoms bottoms = one_mesh();
    Crowd crowd(2000, 30.0f);
    MovingTop top(Layout::Four);
    const auto measured = [&](const std::vector<TopItem>& items) {
        MovingTop fresh(Layout::Four);
        update(fresh, items);
        return fresh.cost().sum;
    };
    double worst = 0;
    for (int frame = 0; frame < 60; ++frame) {
        if (frame == 30) crowd.shuffle();
        const std::vector<TopItem> items = crowd.items(bottoms);
        update(top, items);
        EXPECT_TRUE(frame != 30 || top.refits() == 0) << "nothing is where it was";
        worst = std::max(worst, top.cost().sum / measured(items));
        crowd.move(0.05f);
    }
    EXPECT_GT(worst, 1.02);  // it is kept
    EXPECT_LT(worst, 1.3);
    // Without motion only the number of refits counts.
    const std::vector<TopItem> items = crowd.items(bottoms);
    update(top, items);
    uint32_t frames = 0;
    while (top.refits() > 0 && frames <= 2 * kMostRefits) update(top, items), ++frames;
    EXPECT_LE(frames, kMostRefits + 1);
    frames = 0;
    do update(top, items), ++frames;
    while (top.refits() > 0 && frames <= 2 * kMostRefits);
    EXPECT_EQ(frames, kMostRefits + 1);
}

TEST_P(BvhMovingTop, what_comes_and_goes_gets_a_new_tree) {
    const Bottoms bottoms = one_mesh();
    Crowd crowd(200, 20.0f);
    std::vector<TopItem> items = crowd.items(bottoms);
    const TopItem first = items[0];
    MovingTop top(GetParam());
    const auto expect = [&](const char* what, bool is_built) {
        SCOPED_TRACE(what);
        update(top, items);
        EXPECT_EQ(top.refits() == 0, is_built);
        check(top, items);
    };
    expect("the first", true);
    expect("the same", false);
    items[0].box_ws = {};
    expect("one less to hit", true);
    expect("the same again", false);
    items[0] = first, items[1].box_ws = {};
    expect("another instead", true);
    items[1] = items[0], items[1].item.instance = 1;
    expect("one more to hit", true);
    std::swap(items[2].box_ws, items[3].box_ws);
    expect("two change places", false);
    items.pop_back();
    expect("one less", true);
    items.clear();
    expect("none", true);
    expect("still none", false);
}

TEST(BvhMovingTopRule, the_number_of_threads_does_not_show) {
    const Bottoms bottoms = one_mesh();
    const auto run = [&] {
        Crowd crowd(6000, 60.0f);
        MovingTop top(Layout::Compact);
        std::vector<uint32_t> words;
        for (int frame = 0; frame < 8; ++frame) {
            update(top, crowd.items(bottoms));
            words.insert(words.end(), top.nodes().words.begin(), top.nodes().words.end());
            words.push_back(top.refits());
            words.push_back(static_cast<uint32_t>(std::hash<double>()(top.cost().sum)));
            crowd.move(0.1f);
        }
        return words;
    };
    const std::vector<uint32_t> many = run();
    std::vector<uint32_t> one;
    // Within a loop others run on the thread that calls them.
    parallel_for(2, 1, [&](size_t begin, size_t) {
        if (begin == 0) one = run();
    });
    EXPECT_TRUE(many == one);
}

}  // namespace
}  // namespace parhelion::bvh::testing::bvh_moving_top_test
