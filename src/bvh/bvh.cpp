#include "bvh/bvh.h"

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "bvh/four.h"
#include "bvh/moving_top.h"

namespace parhelion::bvh {

static_assert(sizeof(shared::BvhTriangle) == 48 && sizeof(shared::BvhTopItem) == 64);

namespace {

constexpr size_t kGrain = 1u << 15;

void read_triangles(std::span<const BottomGeometry> geometries, std::vector<shared::BvhTriangle>& triangles) {
    size_t first = 0;
    for (uint32_t g = 0; g < geometries.size(); ++g) {
        const BottomGeometry& geometry = geometries[g];
        parallel_for(geometry.triangles.size(), kGrain, [&](size_t begin, size_t end) {
            for (size_t t = begin; t < end; ++t) {
                const glm::uvec3 index = geometry.triangles[t];
                PARHELION_CHECK(std::max(index.x, std::max(index.y, index.z)) < geometry.positions.size(), "triangle {} has an index beyond {} vertices", t,
                                geometry.positions.size());
                const glm::vec3 p0 = geometry.positions[index.x], p1 = geometry.positions[index.y], p2 = geometry.positions[index.z];
                triangles[first + t] = {.p0 = p0, .p1 = p1, .p2 = p2, .rest = 0, .geometry = g, .primitive = static_cast<uint32_t>(t)};
            }
        });
        first += geometry.triangles.size();
    }
}

// References that spatial splits may add: what keeps a triangle within 96 bytes, and the compact layout within 64.
float static_growth(Layout layout) { return layout == Layout::Four ? 0.3f : layout == Layout::Binary ? 0.15f : 0.0f; }

// False for NaN.
bool is_finite(const glm::vec3& v) {
    constexpr float most = std::numeric_limits<float>::max();
    return std::abs(v.x) <= most && std::abs(v.y) <= most && std::abs(v.z) <= most;
}

// World box of an instance: that of its root's children, which is tighter under rotation than that of the whole. All four at once;
// those that are not there stand where the first one does.
Box world_box(const shared::BvhNode& root, const glm::mat4& place, const glm::vec3 (&inverse)[3]) {
    uint32_t first = 0;
    while (first < 4 && root.child[first] == shared::kBvhEmpty) ++first;
    if (first == 4) return {};
    Four middle[3], half[3];
    const glm::vec4* const planes[3][2] = {{&root.min_x, &root.max_x}, {&root.min_y, &root.max_y}, {&root.min_z, &root.max_z}};
    for (int axis = 0; axis < 3; ++axis) {
        Four min, max;
        for (int c = 0; c < 4; ++c) {
            const int from = root.child[c] == shared::kBvhEmpty ? static_cast<int>(first) : c;
            min.v[c] = (*planes[axis][0])[from], max.v[c] = (*planes[axis][1])[from];
        }
        middle[axis] = all_four(0.5f) * (min + max), half[axis] = all_four(0.5f) * (max - min);
    }
    glm::vec3 low, high, reach;
    for (int r = 0; r < 3; ++r) {
        const Four at = all_four(place[0][r]) * middle[0] + all_four(place[1][r]) * middle[1] + all_four(place[2][r]) * middle[2] + all_four(place[3][r]);
        const Four around = all_four(std::abs(place[0][r])) * half[0] + all_four(std::abs(place[1][r])) * half[1] + all_four(std::abs(place[2][r])) * half[2];
        low[r] = lowest(at - around), high[r] = highest(at + around);
        reach[r] = std::max(std::abs(place[3][r]), std::max(std::abs(low[r]), std::abs(high[r])));
    }
    // A ray is rounded on its way into object space. Carried back, that is 16 units in the last place of the coordinates involved, times
    // the transform's condition. What is computed above is off by at most 12 of them: it takes a coordinate of the object at most twice
    // as far as `reach` is carried there. The traversal adds what the ray's own origin brings.
    const glm::vec3 carried(glm::dot(glm::abs(inverse[0]), reach), glm::dot(glm::abs(inverse[1]), reach), glm::dot(glm::abs(inverse[2]), reach));
    const glm::vec3 margin = 2e-6f * (carried.x * glm::abs(glm::vec3(place[0])) + carried.y * glm::abs(glm::vec3(place[1])) + carried.z * glm::abs(glm::vec3(place[2])));
    const Box box{low - margin, high + margin};
    return in_range(box.min) && in_range(box.max) ? box : Box{};
}

}  // namespace

uint32_t add_bottom(Bottoms& bottoms, std::span<const BottomGeometry> geometries, MeshClass mesh_class) {
    size_t count = 0;
    for (const BottomGeometry& geometry : geometries) count += geometry.triangles.size();
    const Layout layout = bottoms.nodes.layout;
    const float growth = mesh_class == MeshClass::Static ? static_growth(layout) : 0.0f;
    const double most = double(count) * (1.0 + growth);
    if (double(bottoms.triangles.size()) + most >= shared::kBvhItemMask || double(bottoms.nodes.size()) + most >= shared::kBvhItemMask)  // two numbers are taken
        throw Error(ErrorCode::Failed, "the scene has more than 2^31 triangles", "own BVH", "trace by pipeline or query");
    std::vector<shared::BvhTriangle> triangles(count);
    read_triangles(geometries, triangles);
    WideTree tree = build_wide_tree(triangles, {.width = node_width(layout),
                                                .max_leaf = shared::kBvhMaxLeaf,
                                                .max_depth = max_bottom_depth(layout),
                                                .growth = growth,
                                                .node_cost = layout == Layout::Compact ? 4.0f : 0.0f});

    const size_t first_triangle = bottoms.triangles.size();
    bottoms.roots.push_back(static_cast<uint32_t>(bottoms.nodes.size()));
    bottoms.nodes.append(tree, static_cast<uint32_t>(first_triangle));
    tree.nodes = std::vector<WideNode>();  // frees what is as large as what it has become; {} would not
    bottoms.triangles.resize(first_triangle + tree.order.size());
    parallel_for(tree.order.size(), kGrain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            bottoms.triangles[first_triangle + i] = triangles[tree.order[i]];
            bottoms.triangles[first_triangle + i].rest = tree.rest[i];
        }
    });
    return static_cast<uint32_t>(bottoms.roots.size() - 1);
}

TopItem make_top_item(const Bottoms& bottoms, uint32_t mesh, const glm::mat4& world_from_object, uint32_t instance, uint32_t mask, uint32_t flags) {
    const uint32_t root = bottoms.roots.at(mesh);
    return make_top_item(bottoms.nodes.read(root), root, world_from_object, instance, mask, flags);
}

TopItem make_top_item(const shared::BvhNode& root_node, uint32_t root, const glm::mat4& world_from_object, uint32_t instance, uint32_t mask, uint32_t flags) {
    const glm::dmat3 inverse = glm::inverse(glm::dmat3(glm::mat3(world_from_object)));
    const glm::vec3 rows[3] = {{inverse[0][0], inverse[1][0], inverse[2][0]}, {inverse[0][1], inverse[1][1], inverse[2][1]}, {inverse[0][2], inverse[1][2], inverse[2][2]}};
    return make_top_item(root_node, root, world_from_object, rows, instance, mask, flags);
}

TopItem make_top_item(const shared::BvhNode& root_node, uint32_t root, const glm::mat4& world_from_object, const glm::vec3 (&inverse_rows)[3], uint32_t instance, uint32_t mask, uint32_t flags) {
    const glm::vec3 origin(world_from_object[3]);
    TopItem out{.item = {.row0 = inverse_rows[0],
                         .instance = instance,
                         .row1 = inverse_rows[1],
                         .root = root,
                         .row2 = inverse_rows[2],
                         .mask = mask,
                         .origin_ws = origin,
                         .flags = flags},
                .box_ws = {}};
    bool usable = in_range(origin);
    for (int i = 0; i < 3; ++i) usable &= is_finite(glm::vec3(world_from_object[i])) && is_finite(inverse_rows[i]);
    if (usable) out.box_ws = world_box(root_node, world_from_object, inverse_rows);
    return out;
}

Top build_top(std::span<const TopItem> items, Layout layout) {
    MovingTop top(layout);
    top.update(items);
    return std::move(top).take();
}

}  // namespace parhelion::bvh
