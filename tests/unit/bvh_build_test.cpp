// The builder of our own BVH: what every tree must be, whatever it is given.
#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <set>

#ifdef __linux__
#include <sched.h>
#endif

#include <gtest/gtest.h>

#include "base/error.h"
#include "support/bvh_scene.h"

namespace parhelion::bvh::testing::bvh_build_test {
namespace {

using shared::BvhNode;
using shared::kBvhEmpty;
using shared::kBvhItemMask;
using shared::kBvhLeaf;

class BvhBuild : public ::testing::TestWithParam<Layout> {};
INSTANTIATE_TEST_SUITE_P(Nodes, BvhBuild, ::testing::ValuesIn(kLayouts), layout_of);

Box child_box(const BvhNode& node, int c) {
    return {{node.min_x[c], node.min_y[c], node.min_z[c]}, {node.max_x[c], node.max_y[c], node.max_z[c]}};
}
bool contains(const Box& outer, const Box& inner) {
    return glm::all(glm::lessThanEqual(outer.min, inner.min)) && glm::all(glm::greaterThanEqual(outer.max, inner.max));
}
Box common(const Box& a, const Box& b) { return {glm::max(a.min, b.min), glm::min(a.max, b.max)}; }

// Visits the children below `root`: visit(child, depth of its node, what the boxes on the way to it have in common). Quantised boxes
// need not lie within those above them; what is in a leaf must lie within all.
template <class Visit>
void walk(const Nodes& nodes, uint32_t root, Visit&& visit) {
    struct Task {
        uint32_t index, depth;
        Box box;
    };
    std::vector<Task> stack{{root, 1u, {glm::vec3(-3e38f), glm::vec3(3e38f)}}};
    while (!stack.empty()) {
        const Task task = stack.back();
        stack.pop_back();
        const BvhNode node = nodes.read(task.index);
        for (int c = 0; c < 4; ++c) {
            if (node.child[c] == kBvhEmpty) continue;
            const Box box = common(task.box, child_box(node, c));
            visit(node.child[c], task.depth, box);
            if ((node.child[c] & kBvhLeaf) == 0) stack.push_back({node.child[c], task.depth + 1, box});
        }
    }
}

// The same of a tree that has not got a layout yet: visit(box, child, depth).
template <class Visit>
void walk(const WideTree& tree, Visit&& visit) {
    std::vector<std::pair<uint32_t, uint32_t>> stack{{0u, 1u}};
    while (!stack.empty()) {
        const auto [index, depth] = stack.back();
        stack.pop_back();
        for (uint32_t c = 0; c < 4; ++c) {
            const uint32_t child = tree.nodes.at(index).child[c];
            if (child == kBvhEmpty) continue;
            ASSERT_LT(c, tree.width);
            visit(tree.nodes[index].box[c], child, depth);
            if ((child & kBvhLeaf) == 0) stack.push_back({child, depth + 1});
        }
    }
}

uint32_t depth_of(const WideTree& tree) {
    uint32_t deepest = 0;
    walk(tree, [&](const Box&, uint32_t, uint32_t depth) { deepest = std::max(deepest, depth); });
    return deepest;
}

bool contains(const Box& box, glm::dvec3 p) {
    const glm::dvec3 slack = 1e-12 * glm::abs(p);  // p is rounded itself
    return glm::all(glm::lessThanEqual(glm::dvec3(box.min), p + slack)) && glm::all(glm::greaterThanEqual(glm::dvec3(box.max), p - slack));
}

bool usable(const TestGeometry& geometry, glm::uvec3 index) {
    for (int k = 0; k < 3; ++k)
        if (!glm::all(glm::lessThanEqual(glm::abs(geometry.positions[index[k]]), glm::vec3(1e18f)))) return false;
    return true;
}

// Whether all of a triangle is in some of the boxes: its corners, and points within and on its edges.
bool covered(const glm::vec3 (&p)[3], const std::vector<Box>& boxes, Random& random) {
    for (int i = 0; i < 24; ++i) {
        double u = random.unit(), v = random.unit();
        if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
        if (i < 9) u = i % 3 == 0 ? 1.0 : i % 3 == 1 ? 0.0 : u * (i >= 6), v = i % 3 == 1 ? 1.0 : 0.0;
        else if (i < 15) v = i % 2 == 0 ? 0.0 : 1.0 - u;
        const glm::dvec3 point = (1.0 - u - v) * glm::dvec3(p[0]) + u * glm::dvec3(p[1]) + v * glm::dvec3(p[2]);
        if (std::none_of(boxes.begin(), boxes.end(), [&](const Box& box) { return contains(box, point); })) return false;
    }
    return true;
}

// Coverage, containment, leaf sizes, depth and number of references of one mesh.
void check_bottom(const Bottoms& bottoms, uint32_t mesh, const TestMesh& source) {
    std::map<std::pair<uint32_t, uint32_t>, std::vector<Box>> seen;
    std::set<uint32_t> nodes_seen{bottoms.roots.at(mesh)};
    size_t references = 0, usable_triangles = 0;
    walk(bottoms.nodes, bottoms.roots.at(mesh), [&](uint32_t child, uint32_t depth, const Box& box) {
        ASSERT_LE(depth, max_bottom_depth(bottoms.nodes.layout));
        if ((child & kBvhLeaf) == 0) {
            ASSERT_TRUE(nodes_seen.insert(child).second) << "node " << child << " has two parents";
            return;
        }
        std::set<std::pair<uint32_t, uint32_t>> leaf;
        uint32_t i = child & kBvhItemMask;
        for (uint32_t rest = 1; rest != 0; ++i) {
            const shared::BvhTriangle& t = bottoms.triangles.at(i);
            rest = t.rest;
            ASSERT_TRUE(leaf.insert({t.geometry, t.primitive}).second) << "twice in one leaf";
            const TestGeometry& geometry = source.at(t.geometry);
            const glm::uvec3 index3 = geometry.triangles.at(t.primitive);
            ASSERT_TRUE(t.p0 == geometry.positions[index3.x] && t.p1 == geometry.positions[index3.y] && t.p2 == geometry.positions[index3.z]);
            seen[{t.geometry, t.primitive}].push_back(box);
        }
        ASSERT_LE(leaf.size(), shared::kBvhMaxLeaf);
        references += leaf.size();
    });
    Random random(1);
    for (uint32_t g = 0; g < source.size(); ++g)
        for (uint32_t t = 0; t < source[g].triangles.size(); ++t) {
            const glm::uvec3 index = source[g].triangles[t];
            const auto at = seen.find({g, t});
            ASSERT_EQ(at != seen.end(), usable(source[g], index)) << "triangle " << t << " of geometry " << g;
            if (at == seen.end()) continue;
            ++usable_triangles;
            const glm::vec3 p[3] = {source[g].positions[index.x], source[g].positions[index.y], source[g].positions[index.z]};
            if (at->second.size() > 1) {
                ASSERT_TRUE(covered(p, at->second, random)) << "triangle " << t << " of geometry " << g << " in " << at->second.size() << " leaves";
                continue;
            }
            Box triangle;
            for (const glm::vec3& corner : p) triangle.add(corner);
            ASSERT_TRUE(contains(at->second.front(), triangle));
        }
    EXPECT_LE(double(references), 1.3 * double(usable_triangles));
}

uint32_t add(Bottoms& bottoms, const TestMesh& mesh) {
    std::vector<BottomGeometry> geometries;
    for (const TestGeometry& geometry : mesh) geometries.push_back({geometry.positions, geometry.triangles});
    return add_bottom(bottoms, geometries);
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

TEST_P(BvhBuild, every_triangle_is_in_some_leaf_and_boxes_contain_what_is_below) {
    Random random(1);
    Bottoms bottoms{.nodes = {.layout = GetParam(), .words = {}}, .triangles = {}, .roots = {}};
    std::vector<TestMesh> meshes;
    for (const uint32_t count : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 17u, 100u, 1000u, 20000u, 40000u})
        meshes.push_back({make_soup(random, count / 3, 10.0f, 1.0f), {}, make_soup(random, count - count / 3, 3.0f, 0.2f)});
    meshes.push_back({make_icosphere(5, 2.0f)});
    for (const TestMesh& mesh : meshes) add(bottoms, mesh);
    ASSERT_EQ(bottoms.roots.size(), meshes.size());
    for (uint32_t m = 0; m < meshes.size(); ++m) {
        SCOPED_TRACE(m);
        check_bottom(bottoms, m, meshes[m]);
    }
    const double triangle_bytes = double(bottoms.nodes.bytes()) / double(bottoms.triangles.size()) + double(sizeof(shared::BvhTriangle));
    EXPECT_LE(triangle_bytes, GetParam() == Layout::Compact ? 64.0 : 96.0);
}

// Long, thin and large triangles, which spatial splits cut: everything of each is in some leaf that lists it, at every scale.
TEST_P(BvhBuild, the_parts_of_a_static_mesh_cover_every_triangle) {
    Random random(8);
    std::vector<TestMesh> meshes;
    for (const auto& [scale, offset] : {std::pair(1.0f, 0.0f), std::pair(1e-4f, 0.0f), std::pair(1.0f, 1e6f), std::pair(1e6f, 1e6f)}) {
        TestGeometry mixed = make_hall(random);
        for (int i = 0; i < 4; ++i) mixed.add(random.in_cube(30.0f), random.in_cube(30.0f), random.in_cube(30.0f));
        for (glm::vec3& p : mixed.positions) p = p * scale + offset;
        meshes.push_back({mixed});
    }
    Bottoms bottoms{.nodes = {.layout = GetParam(), .words = {}}, .triangles = {}, .roots = {}};
    size_t triangles = 0;
    for (uint32_t m = 0; m < meshes.size(); ++m) {
        SCOPED_TRACE(m);
        add(bottoms, meshes[m]);
        check_bottom(bottoms, m, meshes[m]);
        triangles += meshes[m][0].triangles.size();
    }
    const double expected = GetParam() == Layout::Compact ? 0.99 : 1.05;
    EXPECT_GT(double(bottoms.triangles.size()), expected * double(triangles)) << "the input is too tame for spatial splits";
}

TEST_P(BvhBuild, degenerate_meshes_still_make_proper_trees) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    Random random(2);
    std::vector<TestMesh> meshes;
    meshes.push_back({});
    meshes.push_back({{}, {}});
    TestGeometry same, point, line, shared_center, wild = make_soup(random, 50, 1.0f, 0.1f), huge, far = make_soup(random, 500, 1.0f, 0.1f);
    for (int i = 0; i < 1000; ++i) {
        same.add({1, 2, 3}, {2, 2, 3}, {1, 3, 3});
        point.add({5, 5, 5}, {5, 5, 5}, {5, 5, 5});
        line.add({float(i), 0, 0}, {float(i) + 1, 0, 0}, {float(i) + 0.5f, 0, 0});
        const float s = float(i + 1);
        shared_center.add({-s, -s, 0}, {s, s, 0}, {s, -s, 0});
        huge.add(random.in_cube(9e17f), random.in_cube(9e17f), random.in_cube(9e17f));
    }
    wild.add({nan, 0, 0}, {1, 0, 0}, {0, 1, 0});
    wild.add({0, infinity, 0}, {1, 0, 0}, {0, 1, 0});
    wild.add({0, 0, 0}, {1, 0, -3e38f}, {0, 1, 0});
    for (glm::vec3& p : far.positions) p += glm::vec3(1e6f, -1e6f, 1e6f);
    for (TestGeometry* g : {&same, &point, &line, &shared_center, &wild, &huge, &far}) meshes.push_back({*g});
    Bottoms bottoms{.nodes = {.layout = GetParam(), .words = {}}, .triangles = {}, .roots = {}};
    for (const TestMesh& mesh : meshes) add(bottoms, mesh);
    for (uint32_t m = 0; m < meshes.size(); ++m) {
        SCOPED_TRACE(m);
        check_bottom(bottoms, m, meshes[m]);
    }
    TestGeometry broken{{{0, 0, 0}}, {{0, 0, 1}}};
    EXPECT_THROW(add(bottoms, {broken}), std::exception);
}

// What the plan of a refit is made from.
TEST(BvhTree, every_box_is_in_one_leaf_and_boxes_contain_what_is_below) {
    Random random(9);
    for (const size_t count : {0u, 1u, 2u, 3u, 4u, 5u, 6u, 17u, 100u, 1000u, 60000u})
        for (const uint32_t width : {2u, 4u}) {
            std::vector<Box> boxes(count);
            for (size_t i = 0; i < count; ++i) {
                if (i % 7 == 3) continue;  // stays empty
                boxes[i].add(i % 5 == 0 ? glm::vec3(1.0f) : random.in_cube(10.0f));
                if (i % 3 != 0) boxes[i].add(boxes[i].min + random.unit() * (random.in_cube(1.0f) + 1.0f));
            }
            const WideTree tree = build_wide_tree(boxes, width, 4, 72 / width);
            std::vector<int> seen(count);
            walk(tree, [&](const Box& box, uint32_t child, uint32_t) {
                if ((child & kBvhLeaf) == 0) {
                    for (uint32_t c = 0; c < width; ++c) ASSERT_TRUE(tree.nodes[child].child[c] == kBvhEmpty || contains(box, tree.nodes[child].box[c]));
                    return;
                }
                for (uint32_t i = child & kBvhItemMask, rest = 1, size = 1; rest != 0; ++i, ++size) {
                    rest = tree.rest.at(i);
                    ASSERT_LE(size, 4u);
                    ++seen[tree.order.at(i)];
                    ASSERT_TRUE(contains(box, boxes[tree.order[i]]));
                }
            });
            for (size_t i = 0; i < count; ++i) ASSERT_EQ(seen[i], boxes[i].empty() ? 0 : 1) << "box " << i << " of " << count;
        }
}

// Boxes that halve in size towards the origin make the surface area heuristic cut off one a level.
TEST(BvhTree, no_input_makes_a_tree_deeper_than_the_bound) {
    std::vector<Box> boxes;
    for (int i = 0; i < 120; ++i)
        for (int copy = 0; copy < 7; ++copy) {
            Box box;
            box.add(glm::vec3(std::ldexp(1.0f, i - 60)));
            box.add(glm::vec3(std::ldexp(1.5f, i - 60)));
            boxes.push_back(box);
        }
    uint32_t deepest = 0;
    for (uint32_t depth = 4; depth <= 18; ++depth) {
        const WideTree tree = build_wide_tree(boxes, 4, 4, depth), binary = build_wide_tree(boxes, 2, 4, 2 * depth);
        EXPECT_LE(depth_of(tree), depth);
        EXPECT_LE(depth_of(binary), 2 * depth);
        EXPECT_EQ(tree.order.size(), boxes.size());
        EXPECT_EQ(binary.order.size(), boxes.size());
        deepest = std::max(deepest, depth_of(tree));
    }
    EXPECT_GT(deepest, 12u) << "the input is too tame to test the bound";
    // Filled to the brim: nothing but halving fits.
    for (uint32_t depth = 1; depth <= 5; ++depth)
        for (const uint32_t leaf : {1u, 4u}) {
            const size_t brim = size_t(leaf) << (2 * depth);
            if (brim > boxes.size()) boxes.resize(brim, boxes.back());
            EXPECT_EQ(depth_of(build_wide_tree(std::span(boxes).first(brim), 4, leaf, depth)), depth);
            EXPECT_EQ(depth_of(build_wide_tree(std::span(boxes).first(brim), 2, leaf, 2 * depth)), 2 * depth);
            boxes.resize(brim + 1, boxes.back());
            EXPECT_ANY_THROW(build_wide_tree(boxes, 4, leaf, depth));
            EXPECT_ANY_THROW(build_wide_tree(boxes, 2, leaf, 2 * depth));
        }
}

TEST(BvhTree, the_surface_area_heuristic_beats_halving) {
    Random random(3);
    const TestGeometry dense = make_soup(random, 8192, 0.1f, 0.01f), sparse = make_soup(random, 8192, 10.0f, 0.1f);
    std::vector<Box> boxes;
    for (const TestGeometry* geometry : {&dense, &sparse})
        for (size_t i = 0; i < geometry->positions.size(); i += 3) {
            Box box;
            for (size_t k = 0; k < 3; ++k) box.add(geometry->positions[i + k]);
            boxes.push_back(box);
        }
    // Expected box and triangle tests of a ray, but for a common factor. At depth 6 only halving fits.
    const auto cost = [&](uint32_t depth) {
        const WideTree tree = build_wide_tree(boxes, 4, 4, depth);
        double sum = 0;
        walk(tree, [&](const Box& box, uint32_t child, uint32_t) {
            sum += double(box.half_area()) * ((child & kBvhLeaf) != 0 ? tree.rest[child & kBvhItemMask] + 1.0 : 1.0);
        });
        return sum;
    };
    EXPECT_LT(cost(18), 0.75 * cost(6));
}

TEST(BvhTree, the_number_of_threads_does_not_show) {
    Random random(4);
    // More than two chunks in the first ranges, so that they are split by all threads.
    const TestMesh mesh{make_soup(random, 90000, 10.0f, 0.3f)};
    Bottoms many, again, one;
    add(many, mesh);
    add(again, mesh);
#ifdef __linux__
    cpu_set_t before, single;
    ASSERT_EQ(sched_getaffinity(0, sizeof(before), &before), 0);
    CPU_ZERO(&single);
    for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
        if (CPU_ISSET(cpu, &before)) {
            CPU_SET(cpu, &single);
            break;
        }
    ASSERT_EQ(sched_setaffinity(0, sizeof(single), &single), 0);
    add(one, mesh);
    sched_setaffinity(0, sizeof(before), &before);
#else
    add(one, mesh);
#endif
    EXPECT_TRUE(same_bytes(many.nodes.words, again.nodes.words) && same_bytes(many.triangles, again.triangles));
    EXPECT_TRUE(same_bytes(many.nodes.words, one.nodes.words) && same_bytes(many.triangles, one.triangles));
}

TEST_P(BvhBuild, the_top_level_holds_every_instance_that_can_be_hit) {
    Random random(5);
    Bottoms bottoms{.nodes = {.layout = GetParam(), .words = {}}, .triangles = {}, .roots = {}};
    const uint32_t empty = add(bottoms, {}), sphere = add(bottoms, {make_icosphere(1, 1.0f)});
    std::vector<TopItem> items;
    glm::mat4 flat(1.0f), broken(1.0f);
    flat[1] = glm::vec4(0.0f);
    broken[3].x = std::numeric_limits<float>::quiet_NaN();
    for (uint32_t i = 0; i < 1000; ++i) {
        glm::mat4 place(1.0f);
        place[3] = glm::vec4(random.in_cube(50.0f), 1.0f);
        const bool hittable = i % 10 != 0;
        items.push_back(make_top_item(bottoms, i % 30 == 0 ? empty : sphere, hittable ? place : i % 20 == 0 ? flat : i % 30 == 0 ? place : broken, i));
        EXPECT_EQ(items.back().box_ws.empty(), !hittable) << i;
    }
    const Top top = build_top(items, GetParam());
    EXPECT_EQ(top.items.size(), 900u);
    std::set<uint32_t> seen;
    walk(top.nodes, 0, [&](uint32_t child, uint32_t depth, const Box& box) {
        EXPECT_LE(depth, max_top_depth(GetParam()));
        if ((child & kBvhLeaf) == 0) return;
        const uint32_t instance = top.items.at(child & kBvhItemMask).instance;
        EXPECT_TRUE(seen.insert(instance).second);
        EXPECT_TRUE(contains(box, items[instance].box_ws));
    });
    EXPECT_EQ(seen.size(), 900u);
    const Top nothing = build_top({}, GetParam());
    ASSERT_EQ(nothing.nodes.size(), 1u);
    for (int c = 0; c < 4; ++c) EXPECT_EQ(nothing.nodes.read(0).child[c], kBvhEmpty);
}

TEST_P(BvhBuild, an_instance_lies_within_its_world_box) {
    Random random(6);
    Bottoms bottoms{.nodes = {.layout = GetParam(), .words = {}}, .triangles = {}, .roots = {}};
    const TestGeometry soup = make_soup(random, 300, 2.0f, 0.5f);
    add(bottoms, {soup});
    for (int i = 0; i < 200; ++i) {
        glm::mat4 m(1.0f);
        for (int c = 0; c < 3; ++c) m[c] = glm::vec4(random.in_cube(std::pow(10.0f, random.range(-3.0f, 3.0f))), 0.0f);
        m[3] = glm::vec4(random.in_cube(i % 2 == 0 ? 10.0f : 1e6f), 1.0f);
        const Box box = make_top_item(bottoms, 0, m, 0).box_ws;
        glm::dvec3 size(0.0);
        for (const glm::vec3& p : soup.positions) {
            const glm::dvec4 w = glm::dmat4(m) * glm::dvec4(p, 1.0);
            ASSERT_TRUE(glm::all(glm::lessThanEqual(glm::dvec3(box.min), glm::dvec3(w))));
            ASSERT_TRUE(glm::all(glm::greaterThanEqual(glm::dvec3(box.max), glm::dvec3(w))));
            size = glm::max(size, glm::abs(glm::dvec3(w)));
        }
        // And the box is not wildly larger than the corners of its mesh's box.
        EXPECT_LE(box.max.x - box.min.x, 1.2 * (std::abs(m[0].x) + std::abs(m[1].x) + std::abs(m[2].x)) * 5.0 + 1e-2 * size.x);
    }
}

}  // namespace
}  // namespace parhelion::bvh::testing::bvh_build_test
