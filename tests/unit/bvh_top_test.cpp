// The tree over instances, which is made anew every frame: whole, bounded, the same for any number of threads, and nearly as good as
// the one that takes its time.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <set>

#ifdef __linux__
#include <sched.h>
#endif

#include <gtest/gtest.h>

#include "bvh/top_tree.h"
#include "support/bvh_scene.h"

namespace parhelion::bvh::testing::bvh_top_test {
namespace {

using shared::kBvhEmpty;
using shared::kBvhItemMask;
using shared::kBvhLeaf;

Box box_of(glm::vec3 middle, glm::vec3 half) {
    Box box;
    box.add(middle - half), box.add(middle + half);
    return box;
}

// Trees of one to three metres on 200 m x 200 m.
std::vector<Box> forest(uint32_t count) {
    Random random(11);
    std::vector<Box> boxes;
    for (uint32_t i = 0; i < count; ++i) {
        const float size = random.range(0.5f, 1.5f);
        boxes.push_back(box_of({random.range(0, 200), 2 * size, random.range(0, 200)}, size * glm::vec3(1, 2, 1)));
    }
    return boxes;
}

// Things of a few centimetres to a metre in a room of 10 m, and some walls.
std::vector<Box> room(uint32_t count) {
    Random random(12);
    std::vector<Box> boxes;
    for (uint32_t i = 0; i < count; ++i) {
        const float u = random.unit(), size = 0.02f + 0.2f * u * u;
        boxes.push_back(box_of({random.range(0, 10), 3 * random.unit() * random.unit(), random.range(0, 10)}, size * glm::vec3(0.3f + random.unit(), 0.3f + random.unit(), 0.3f + random.unit())));
    }
    for (uint32_t i = 0; i < 20; ++i) boxes.push_back(box_of(random.in_cube(5.0f) + 5.0f, i % 2 == 0 ? glm::vec3(5, 3, 0.1f) : glm::vec3(0.1f, 3, 5)));
    return boxes;
}

// Every box in one leaf, within all boxes above it; returns the levels.
uint32_t check(const WideTree& tree, std::span<const Box> boxes) {
    struct Task {
        uint32_t node, depth;
        Box box;
    };
    std::vector<Task> stack{{0, 1, {glm::vec3(-3e38f), glm::vec3(3e38f)}}};
    std::set<uint32_t> nodes, items;
    uint32_t depth = 0;
    while (!stack.empty()) {
        const Task task = stack.back();
        stack.pop_back();
        EXPECT_TRUE(nodes.insert(task.node).second) << "a node with two parents";
        depth = std::max(depth, task.depth);
        for (uint32_t c = 0; c < 4; ++c) {
            const uint32_t child = tree.nodes.at(task.node).child[c];
            if (child == kBvhEmpty) continue;
            EXPECT_LT(c, tree.width);
            const Box& box = tree.nodes[task.node].box[c];
            EXPECT_TRUE(glm::all(glm::lessThanEqual(task.box.min, box.min)) && glm::all(glm::greaterThanEqual(task.box.max, box.max)));
            if ((child & kBvhLeaf) == 0) {
                stack.push_back({child, task.depth + 1, box});
                continue;
            }
            const uint32_t position = child & kBvhItemMask, item = tree.order.at(position);
            EXPECT_TRUE(items.insert(item).second);
            EXPECT_EQ(tree.rest.at(position), 0);
            EXPECT_TRUE(box.min == boxes[item].min && box.max == boxes[item].max);
        }
    }
    size_t there = 0;
    for (const Box& box : boxes) there += !box.empty();
    EXPECT_EQ(items.size(), there);
    EXPECT_EQ(tree.order.size(), there);
    EXPECT_EQ(nodes.size(), tree.nodes.size());
    return depth;
}

// Expected tests of a ray that meets the whole, but for a common factor.
double cost(const WideTree& tree) {
    double sum = 0;
    for (const WideNode& node : tree.nodes)
        for (uint32_t c = 0; c < tree.width; ++c)
            if (node.child[c] != kBvhEmpty) sum += double(node.box[c].half_area());
    return sum;
}

TEST(BvhTop, every_box_is_in_one_leaf_and_within_the_boxes_above_it) {
    for (const uint32_t width : {2u, 4u}) {
        for (const uint32_t count : {0u, 1u, 2u, 3u, 4u, 5u, 8u, 9u, 17u, 100u, 1024u, 1025u, 5000u}) {
            SCOPED_TRACE(count);
            std::vector<Box> boxes = forest(count);
            for (uint32_t i = 0; i < count; i += 7) boxes[i] = {};  // nothing to hit
            EXPECT_LE(check(build_top_tree(boxes, width, 48 / width), boxes), 48 / width);
        }
    }
    // All at one place, in a row, beyond measure.
    for (const uint32_t width : {2u, 4u})
        for (const float step : {0.0f, 1.0f, 3e14f}) {
            std::vector<Box> boxes;
            for (uint32_t i = 0; i < 3000; ++i) boxes.push_back(box_of({step * float(i), 0, 0}, glm::vec3(0.5f)));
            check(build_top_tree(boxes, width, 24), boxes);
        }
}

TEST(BvhTop, no_input_makes_a_tree_deeper_than_the_bound) {
    std::vector<Box> boxes;
    for (int i = 0; i < 120; ++i) boxes.push_back(box_of(glm::vec3(std::ldexp(1.25f, i - 60)), glm::vec3(std::ldexp(0.25f, i - 60))));
    uint32_t deepest = 0;
    for (uint32_t depth = 4; depth <= 12; ++depth) {
        deepest = std::max(deepest, check(build_top_tree(boxes, 4, depth), boxes));
        EXPECT_LE(check(build_top_tree(boxes, 4, depth), boxes), depth);
        EXPECT_LE(check(build_top_tree(boxes, 2, 2 * depth), boxes), 2 * depth);
    }
    EXPECT_GT(deepest, 8u) << "the input is too tame to test the bound";
    // Filled to the brim: nothing but halving fits.
    for (uint32_t depth = 1; depth <= 6; ++depth) {
        const std::vector<Box> full = forest(1u << (2 * depth)), over = forest((1u << (2 * depth)) + 1);
        EXPECT_EQ(check(build_top_tree(full, 4, depth), full), depth);
        EXPECT_EQ(check(build_top_tree(full, 2, 2 * depth), full), 2 * depth);
        EXPECT_ANY_THROW(build_top_tree(over, 4, depth));
        EXPECT_ANY_THROW(build_top_tree(over, 2, 2 * depth));
    }
}

// Three axes and as many bins for small ranges as for large ones would be a few percent better, and three times as slow.
TEST(BvhTop, is_nearly_as_good_as_the_tree_that_takes_its_time) {
    for (const auto& [name, boxes] : {std::pair("forest", forest(10'000)), std::pair("room", room(10'000))})
        for (const uint32_t width : {2u, 4u}) {
            const double fast = cost(build_top_tree(boxes, width, 48 / width)), slow = cost(build_wide_tree(boxes, width, 1, 48 / width));
            std::printf("%s, %u children: %.3f of the other's expected tests\n", name, width, fast / slow);
            EXPECT_LT(fast, 1.15 * slow) << name << ' ' << width;
        }
}

TEST(BvhTop, the_number_of_threads_does_not_show) {
    const std::vector<Box> boxes = room(20'000);
    const WideTree many = build_top_tree(boxes, 4, 12);
#ifdef __linux__
    cpu_set_t before, single;
    ASSERT_EQ(sched_getaffinity(0, sizeof(before), &before), 0);
    CPU_ZERO(&single);
    for (int cpu = 0; cpu < CPU_SETSIZE && CPU_COUNT(&single) == 0; ++cpu)
        if (CPU_ISSET(cpu, &before)) CPU_SET(cpu, &single);
    ASSERT_EQ(sched_setaffinity(0, sizeof(single), &single), 0);
#endif
    const WideTree one = build_top_tree(boxes, 4, 12);
#ifdef __linux__
    sched_setaffinity(0, sizeof(before), &before);
#endif
    EXPECT_EQ(many.order, one.order);
    ASSERT_EQ(many.nodes.size(), one.nodes.size());
    EXPECT_EQ(std::memcmp(many.nodes.data(), one.nodes.data(), one.nodes.size() * sizeof(WideNode)), 0);
}

// Geometry g is a triangle over x = 2 g that shows its front upwards.
TEST(BvhTop, hits_on_opaque_geometries_are_not_asked_about) {
    constexpr uint32_t kGeometries = 40;
    TestMesh mesh(kGeometries);
    for (uint32_t g = 0; g < kGeometries; ++g) {
        const float x = 2.0f * static_cast<float>(g);
        mesh[g].add({x - 0.5f, 0, 0.5f}, {x + 0.5f, 0, 0.5f}, {x, 0, -0.5f});
    }
    const TestScene scene({mesh}, {{}});
    constexpr uint32_t kOdd = 0x2AAAAAAAu, kOthers = 1u << shared::kBvhOtherGeometries;
    for (const uint32_t flags : {0u, kOdd, kOdd | kOthers, shared::kBvhOpaque, kOdd | shared::kBvhCullBack, shared::kBvhOpaque | shared::kBvhCullBack}) {
        const Top top = build_top(std::vector{make_top_item(scene.bottoms, 0, glm::mat4(1.0f), 0, 0xFFu, flags)}, scene.top.nodes.layout);
        for (uint32_t g = 0; g < kGeometries; ++g)
            for (const bool from_above : {true, false}) {
                const bool opaque = g < shared::kBvhOtherGeometries ? (flags >> g & 1) != 0 : (flags & kOthers) != 0;
                const float side = from_above ? 1.0f : -1.0f;
                bool asked = false;
                const AcceptHit accept = [&](uint32_t, uint32_t geometry, uint32_t, glm::vec2, bool front) {
                    asked = true;
                    EXPECT_EQ(geometry, g);
                    EXPECT_EQ(front, from_above);
                    return from_above;
                };
                shared::TraversalHit hit{};
                const shared::TraversalRay ray = make_ray({2.0f * static_cast<float>(g), side, 0}, {0, -side, 0});
                const bool expected = from_above || (opaque && (flags & shared::kBvhCullBack) == 0);
                EXPECT_EQ(trace_closest_host(scene.bottoms, top, ray, hit, accept), expected) << flags << ' ' << g;
                EXPECT_EQ(asked, !opaque) << flags << ' ' << g;
                EXPECT_EQ(trace_any_host(scene.bottoms, top, ray, accept), expected) << flags << ' ' << g;
            }
    }
}

}  // namespace
}  // namespace parhelion::bvh::testing::bvh_top_test
