// The parts of the builder: cutting triangles, the optimal collapse, what spatial splits bring, memory.
#include <algorithm>
#include <fstream>
#include <sstream>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include <gtest/gtest.h>

#include "bvh/collapse.h"
#include "bvh/split.h"
#include "support/bvh_scene.h"

namespace parhelion::bvh::testing::bvh_tree_test {
namespace {

std::vector<shared::BvhTriangle> triangles_of(const TestGeometry& geometry) {
    std::vector<shared::BvhTriangle> out;
    for (uint32_t t = 0; t < geometry.triangles.size(); ++t) {
        const glm::uvec3 i = geometry.triangles[t];
        out.push_back({.p0 = geometry.positions[i.x], .p1 = geometry.positions[i.y], .p2 = geometry.positions[i.z], .rest = 0, .geometry = 0, .primitive = t});
    }
    return out;
}

// A closed room with bumpy spheres.
TestGeometry make_room(Random& random) {
    TestGeometry room = make_box(glm::vec3(-10.0f), glm::vec3(10.0f));
    for (int i = 0; i < 10; ++i) {
        TestGeometry sphere = make_icosphere(3, random.range(0.5f, 2.0f));
        for (glm::vec3& p : sphere.positions) p *= 1.0f + 0.1f * std::sin(9.0f * p.x) * std::sin(7.0f * p.y);
        const glm::vec3 middle = random.in_cube(8.0f);
        for (glm::vec3& p : sphere.positions) p += middle;
        append(room, sphere);
    }
    return room;
}

struct Built {
    WideTree tree;
    TreeStatistics statistics;
};
Built build(const TestGeometry& geometry, uint32_t width, float growth) {
    Built out{.tree = build_wide_tree(triangles_of(geometry), {.width = width, .max_leaf = 4, .max_depth = 72 / width, .growth = growth}), .statistics = {}};
    out.statistics = measure(out.tree);
    return out;
}

// Where an edge meets the plane, in more digits than the builder has, must lie within both parts: outward rounding leaves room.
TEST(BvhCut, the_parts_of_a_triangle_contain_where_its_edges_cross_the_plane) {
    Random random(1);
    int crossings = 0;
    for (int i = 0; i < 20000; ++i) {
        const float scale = std::pow(10.0f, random.range(-4.0f, 6.0f)), offset = i % 3 == 0 ? 1e6f : i % 3 == 1 ? scale : 0.0f;
        const glm::vec3 p[3] = {random.in_cube(scale) + offset, random.in_cube(scale) + offset, random.in_cube(scale) + offset};
        Box box;
        for (const glm::vec3& corner : p) box.add(corner);
        const int axis = i % 3;
        const float plane = box.min[axis] + random.unit() * (box.max[axis] - box.min[axis]);
        const Parts parts = cut({.p0 = p[0], .p1 = p[1], .p2 = p[2], .rest = 0, .geometry = 0, .primitive = 0}, box, axis, plane);
        ASSERT_TRUE(parts.left.empty() || parts.left.max[axis] <= plane);
        ASSERT_TRUE(parts.right.empty() || parts.right.min[axis] >= plane);
        const auto in = [](const Box& b, const long double (&q)[3]) {
            return !b.empty() && q[0] >= b.min.x && q[1] >= b.min.y && q[2] >= b.min.z && q[0] <= b.max.x && q[1] <= b.max.y && q[2] <= b.max.z;
        };
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 a = p[k], b = p[(k + 1) % 3];
            const long double corner[3] = {a.x, a.y, a.z};
            ASSERT_TRUE(in(a[axis] <= plane ? parts.left : parts.right, corner));
            if (!(std::min(a[axis], b[axis]) < plane && plane < std::max(a[axis], b[axis]))) continue;
            ++crossings;
            const long double t = (static_cast<long double>(plane) - a[axis]) / (static_cast<long double>(b[axis]) - a[axis]);
            long double q[3];
            for (int c = 0; c < 3; ++c) q[c] = c == axis ? plane : a[c] + t * (static_cast<long double>(b[c]) - a[c]);
            ASSERT_TRUE(in(parts.left, q) && in(parts.right, q)) << "triangle " << i << ", edge " << k;
            for (int c = 0; c < 3; ++c) {  // and not much beyond
                const float reach = 1e-6f * std::max(std::abs(a[c]), std::abs(b[c])) + 1e-6f * (box.max[c] - box.min[c]);
                ASSERT_LE(parts.left.max[c], box.max[c]);
                if (c != axis && (a[axis] < plane) == (p[(k + 2) % 3][axis] < plane)) continue;
                ASSERT_LE(std::min(parts.left.min[c], parts.right.min[c]), float(q[c]) + reach);
            }
        }
    }
    EXPECT_GT(crossings, 30000);
}

// ---- the collapse ----

// A binary tree of any shape: each node splits its references where chance wants it.
BinaryTree random_tree(Random& random, uint32_t count) {
    BinaryTree tree{.references = std::make_unique<Reference[]>(count), .nodes = std::make_unique<BinaryNode[]>(count), .slots = count, .root = 0, .top = {}, .subtrees = {}};
    for (uint32_t i = 0; i < count; ++i) {
        const glm::vec3 low = random.in_cube(1.0f);
        tree.references[i] = {low, i, low + random.unit() * (random.in_cube(0.5f) + 0.5f), 0};
    }
    const auto make = [&](auto&& self, uint32_t first, uint32_t size) -> uint32_t {
        if (size == 1) return shared::kBvhLeaf | first;
        const uint32_t half = 1 + random.below(size - 1), index = first + half;
        BinaryNode& node = tree.nodes[index];
        node.left = self(self, first, half), node.right = self(self, index, size - half);
        Box box = tree.box_of(node.left);
        box.add(tree.box_of(node.right));
        node.min = box.min, node.max = box.max;
        return index;
    };
    tree.root = make(make, 0, count);
    tree.subtrees = {tree.root};
    return tree;
}

uint32_t references_below(const BinaryTree& tree, uint32_t child) {
    return (child & shared::kBvhLeaf) != 0 ? 1 : references_below(tree, tree.nodes[child].left) + references_below(tree, tree.nodes[child].right);
}

// The least cost by trying everything: every set of up to `width` disjoint subtrees that replace a node as its children.
double least_cost(const BinaryTree& tree, uint32_t child, uint32_t width, bool is_root);
void try_children(const BinaryTree& tree, std::vector<uint32_t> closed, std::vector<uint32_t> open, uint32_t width, double& best) {
    if (closed.size() + open.size() > width) return;
    if (open.empty()) {
        double sum = 0;
        for (const uint32_t child : closed) sum += least_cost(tree, child, width, false);
        best = std::min(best, sum);
        return;
    }
    const uint32_t child = open.back();
    open.pop_back();
    std::vector<uint32_t> with = closed;
    with.push_back(child);
    try_children(tree, with, open, width, best);
    if ((child & shared::kBvhLeaf) != 0) return;
    open.push_back(tree.nodes[child].left), open.push_back(tree.nodes[child].right);
    try_children(tree, closed, open, width, best);
}
double least_cost(const BinaryTree& tree, uint32_t child, uint32_t width, bool is_root) {
    const double area = tree.box_of(child).half_area();
    const uint32_t size = references_below(tree, child);
    double best = size <= 4 ? area * size + (is_root ? area * double(node_cost(width)) : 0.0) : 1e300;
    if (size == 1) return best;
    double inner = 1e300;
    try_children(tree, {}, {tree.nodes[child].left, tree.nodes[child].right}, width, inner);
    return std::min(best, double(node_cost(width)) * area + inner);
}

TEST(BvhCollapse, no_other_collapse_of_a_binary_tree_costs_less) {
    Random random(2);
    int inner = 0;
    for (int i = 0; i < 150; ++i)
        for (const uint32_t width : {2u, 4u}) {
            BinaryTree tree = random_tree(random, 5 + random.below(8));
            const double expected = least_cost(tree, tree.root, width, true) / double(tree.box_of(tree.root).half_area());
            const TreeStatistics statistics = measure(collapse(std::move(tree), width, 4, 30, node_cost(width)));
            ASSERT_NEAR(statistics.cost, expected, 1e-5 * expected) << "tree " << i << ", width " << width;
            inner += statistics.nodes > 1;
        }
    EXPECT_GT(inner, 200) << "the trees are too small to test anything";
}

// ---- what the builder reaches ----

TEST(BvhTree, spatial_splits_pay_where_triangles_are_long_and_never_harm_much) {
    Random random(3);
    const TestGeometry hall = make_hall(random), room = make_room(random);
    for (const uint32_t width : {2u, 4u}) {
        EXPECT_LT(build(hall, width, 0.3f).statistics.cost, 0.8 * build(hall, width, 0.0f).statistics.cost);
        EXPECT_LT(build(room, width, 0.3f).statistics.cost, 1.1 * build(room, width, 0.0f).statistics.cost);
    }
}

TEST(BvhTree, the_number_of_references_stays_within_its_budget) {
    Random random(4);
    const TestGeometry hall = make_hall(random);
    size_t before = 0;
    for (const float growth : {0.0f, 0.02f, 0.1f, 0.3f, 1.0f}) {
        const size_t references = build(hall, 4, growth).statistics.references;
        EXPECT_LE(double(references), double(hall.triangles.size()) * (1.0 + growth));
        EXPECT_GE(references, before);
        before = references;
    }
    EXPECT_EQ(build(hall, 4, 0.0f).statistics.references, hall.triangles.size());
    EXPECT_GT(double(before), 1.05 * double(hall.triangles.size()));
}

// Identical triangles can only be halved; then, and with one giant among many small ones, a tree is still near balance.
TEST(BvhTree, triangles_that_cannot_be_told_apart_make_a_balanced_tree) {
    Random random(5);
    TestGeometry same, giant = make_soup(random, 4000, 1.0f, 0.01f);
    for (int i = 0; i < 4096; ++i) same.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    giant.add({-1e4f, -1e4f, 0}, {1e4f, -1e4f, 1}, {0, 1e4f, -1});
    for (const float growth : {0.0f, 0.3f}) {
        EXPECT_LE(build(same, 2, growth).statistics.depth, 12u);
        EXPECT_LE(build(same, 4, growth).statistics.depth, 7u);
        EXPECT_LE(build(giant, 4, growth).statistics.depth, 12u);
    }
}

#ifdef __GLIBC__
// Kilobytes, of a line of /proc/self/status.
double memory(const std::string& name) {
    std::ifstream file("/proc/self/status");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with(name + ":")) return std::stod(line.substr(name.size() + 1));
    return 0;
}

// What the process held at most while a mesh was built, the mesh itself aside.
TEST(BvhTree, building_takes_at_most_250_bytes_a_triangle) {
    Random random(6);
    const TestGeometry soup = make_soup(random, 300000, 10.0f, 0.4f);
    mallopt(M_MMAP_THRESHOLD, 1 << 17);             // arrays go back to the system when they are freed, whatever ran before
    double bytes = 1e9;
    for (int attempt = 0; attempt < 3; ++attempt) {  // the least: what threads keep in arenas of their own comes and goes
        malloc_trim(0);                              // what earlier tests have freed would not count
        std::ofstream("/proc/self/clear_refs") << 5;  // the peak starts anew
        const double before = memory("VmRSS");
        ASSERT_LE(memory("VmHWM"), before + 2048) << "the system does not let a process measure its peak";
        Bottoms bottoms;
        add_bottom(bottoms, std::vector<BottomGeometry>{{soup.positions, soup.triangles}});
        EXPECT_GT(bottoms.triangles.size(), soup.triangles.size());
        bytes = std::min(bytes, 1024.0 * (memory("VmHWM") - before) / double(soup.triangles.size()));
    }
    RecordProperty("bytes_a_triangle", std::to_string(bytes));
    EXPECT_LE(bytes, 250.0);
    EXPECT_GE(bytes, 100.0) << "less than what is returned";
}
#endif

}  // namespace
}  // namespace parhelion::bvh::testing::bvh_tree_test
