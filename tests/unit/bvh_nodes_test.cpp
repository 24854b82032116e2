// Layouts of nodes (shaders/lib/bvh_nodes.glsl): what is read contains what was written, however awkward its coordinates.
#include <bit>
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "bvh/nodes.h"
#include "lib/bvh_nodes.glsl"
#include "support/bvh_scene.h"

namespace parhelion::bvh::testing::bvh_nodes_test {
namespace {

using shared::kBvhEmpty;

// Of any size and place: from points to boxes of the whole range, and boxes of some units in the last place.
float any_coordinate(Random& random, int kind) {
    const float sign = random.below(2) == 0 ? 1.0f : -1.0f;
    switch (kind) {
        case 0: return random.range(-1.0f, 1.0f);
        case 1: return sign * std::ldexp(random.range(0.5f, 1.0f), static_cast<int>(random.below(180)) - 120);
        case 2: return 1e6f + random.range(0.0f, 2.0f);
        case 3: return std::bit_cast<float>(std::bit_cast<uint32_t>(12345.678f) + random.below(600));
        case 4: return static_cast<float>(random.below(256)) * 0.125f;  // where quotients are whole
        default: return sign * random.range(0.0f, 1e18f);
    }
}

TEST(BvhNodes, quantised_boxes_contain_the_given_ones_to_the_last_bit) {
    Random random(11);
    for (int i = 0; i < 60000; ++i) {
        glm::vec4 low, high;
        glm::uvec4 child;
        const int kind = i % 6;
        for (int c = 0; c < 4; ++c) {
            const float a = any_coordinate(random, kind), b = random.below(8) == 0 ? a : any_coordinate(random, kind);
            low[c] = std::min(a, b), high[c] = std::max(a, b);
            child[c] = random.below(5) == 0 ? kBvhEmpty : random.below(1000);
        }
        if (i % 2 == 0) {
            // Child 0 spans the whole; the others begin and end next to planes, where a quotient rounds to the wrong side.
            for (int c = 1; c < 4; ++c) low[0] = std::min(low[0], low[c]), high[0] = std::max(high[0], high[c]);
            child[0] = 0;
            const shared::QuantisedAxis whole = shared::quantise_axis(low, high, child);
            for (int c = 1; c < 4; ++c) {
                const auto near_plane = [&](float toward) {
                    const float plane = shared::quantised_plane(whole.origin, whole.scale, static_cast<float>(random.below(256)));
                    return std::clamp(std::nextafter(plane, toward), low[0], high[0]);
                };
                const float a = near_plane(-3e38f), b = near_plane(3e38f);
                low[c] = std::min(a, b), high[c] = std::max(a, b);
            }
        }
        const shared::QuantisedAxis axis = shared::quantise_axis(low, high, child);
        for (int c = 0; c < 4; ++c)
            if (child[c] == kBvhEmpty) low[c] = 3e38f, high[c] = -3e38f;
        const shared::QuantisedAxis on_host = quantise_axis(low, high);
        ASSERT_TRUE(on_host.origin == axis.origin && on_host.scale == axis.scale && on_host.low == axis.low && on_host.high == axis.high) << i;
        ASSERT_EQ(std::bit_cast<uint32_t>(axis.scale) & 0xFFu, 0u) << "a product with 8 bits would be rounded";
        ASSERT_GT(axis.scale, 0.0f);
        for (int c = 0; c < 4; ++c) {
            const float from = static_cast<float>(axis.low >> (8 * c) & 0xFFu), to = static_cast<float>(axis.high >> (8 * c) & 0xFFu);
            if (child[c] == kBvhEmpty) {
                ASSERT_TRUE(from == 255.0f && to == 0.0f);
                continue;
            }
            // Both ways to compute a plane, as devices may choose.
            for (const float plane : {axis.origin + from * axis.scale, std::fma(from, axis.scale, axis.origin)}) ASSERT_LE(plane, low[c]) << i;
            for (const float plane : {axis.origin + to * axis.scale, std::fma(to, axis.scale, axis.origin)}) ASSERT_GE(plane, high[c]) << i;
            // And not by more than a step, a step being at most a 255th of the whole (but for roundings).
            ASSERT_TRUE(from == 255.0f || shared::quantised_plane(axis.origin, axis.scale, from + 1.0f) >= low[c]);
            ASSERT_TRUE(to == 0.0f || shared::quantised_plane(axis.origin, axis.scale, to - 1.0f) <= high[c]);
        }
    }
}

TEST(BvhNodes, every_layout_gives_back_children_and_boxes) {
    Random random(12);
    for (const Layout layout : kLayouts) {
        WideTree tree{.width = node_width(layout), .nodes = std::vector<WideNode>(500), .order = {}, .rest = {}};
        for (uint32_t n = 0; n < tree.nodes.size(); ++n)
            for (uint32_t c = 0; c < tree.width; ++c) {
                if (random.below(4) == 0) continue;
                const glm::vec3 p = random.in_cube(10.0f);
                tree.nodes[n].box[c].add(p), tree.nodes[n].box[c].add(p + random.in_cube(1.0f));
                tree.nodes[n].child[c] = n % 2 == 0 ? shared::kBvhLeaf | (7 * n + c) : n + c;
            }
        Nodes nodes{.layout = layout, .words = {}};
        nodes.append(tree, 0);
        nodes.append(tree, 10000);
        ASSERT_EQ(nodes.size(), 1000u);
        std::vector<uint32_t> moved(nodes.words.size() / 2);
        nodes.copy(0, 500, 500, 10000, reinterpret_cast<std::byte*>(moved.data()));
        EXPECT_EQ(std::memcmp(moved.data(), nodes.words.data() + moved.size(), moved.size() * sizeof(uint32_t)), 0) << "what copy() moves lies as if appended there";
        for (uint32_t n = 0; n < 1000; ++n) {
            const WideNode& given = tree.nodes[n % 500];
            const shared::BvhNode read = nodes.read(n);
            for (int c = 0; c < 4; ++c) {
                const uint32_t child = given.child[c];
                const bool leaf = (child & shared::kBvhLeaf) != 0;
                ASSERT_EQ(read.child[c], child == kBvhEmpty || n < 500 ? child : child + (leaf ? 10000 : 500));
                if (child == kBvhEmpty) continue;
                const Box box{{read.min_x[c], read.min_y[c], read.min_z[c]}, {read.max_x[c], read.max_y[c], read.max_z[c]}};
                ASSERT_TRUE(glm::all(glm::lessThanEqual(box.min, given.box[c].min)) && glm::all(glm::greaterThanEqual(box.max, given.box[c].max)));
                ASSERT_TRUE(layout == Layout::Compact || (box.min == given.box[c].min && box.max == given.box[c].max));
            }
        }
    }
}

TEST(BvhNodes, rows_beyond_four_gigabytes_are_found) {
    EXPECT_EQ(shared::row_address(0x7F0000000010ull, 30'000'000u, 112u), 0x7F0000000010ull + 3'360'000'000ull);
    EXPECT_EQ(shared::row_address(16, 0x7FFFFFFDu, 112u), 16 + 0x7FFFFFFDull * 112);
    EXPECT_EQ(shared::row_address(16, 0x7FFFFFFDu, 48u), 16 + 0x7FFFFFFDull * 48);
}

// The traversal's stack: the end, the siblings left behind in a top level, the way back to it, those left behind in a bottom level.
TEST(BvhNodes, the_stack_holds_what_the_deepest_trees_leave_on_it) {
    for (const Layout layout : kLayouts) {
        const uint32_t siblings = node_width(layout) - 1;
        EXPECT_LE(1 + siblings * max_top_depth(layout) + 1 + siblings * max_bottom_depth(layout), shared::kBvhStackSize);
        EXPECT_EQ(std::pow(double(node_width(layout)), max_top_depth(layout)), double(1u << shared::kBvhTopLevels));
    }
}

}  // namespace
}  // namespace parhelion::bvh::testing::bvh_nodes_test
