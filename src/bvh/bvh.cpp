#include "bvh/bvh.h"

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "bvh/bounds.h"
#include "bvh/moving_top.h"

namespace parhelion::bvh {

static_assert(sizeof(shared::BvhTriangle) == 48 && sizeof(shared::BvhTopItem) == 64);

namespace {

constexpr size_t kGrain = 1u << 15;

void read_triangles(std::span<const BottomGeometry> geometries, shared::BvhTriangle* triangles) {
    size_t first = 0;
    for (uint32_t g = 0; g < geometries.size(); ++g) {
        const BottomGeometry& geometry = geometries[g];
        parallel_for(geometry.triangles.size(), kGrain, [&](size_t begin, size_t end) {
            for (size_t t = begin; t < end; ++t) {
                const glm::uvec3 index = geometry.triangles[t];
                PARHELION_CHECK(std::max(index.x, std::max(index.y, index.z)) < geometry.positions.size(), "triangle {} has an index beyond {} vertices", t,
                                geometry.positions.size());
                const glm::vec3 p0 = geometry.positions[index.x], p1 = geometry.positions[index.y], p2 = geometry.positions[index.z];
                triangles[first + t] = {.p0 = p0, .p1 = p1, .p2 = p2, .rest = 0, .geometry = g, .primitive = geometry.first_primitive + static_cast<uint32_t>(t)};
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

Four column(const glm::mat4& m, int c) { return {{m[c].x, m[c].y, m[c].z, m[c].w}}; }
Four absolute(const Four& a) {
    Four out;
    for (int i = 0; i < 4; ++i) out.v[i] = std::abs(a.v[i]);
    return out;
}

Box world_box(const RootBoxes& root, const glm::mat4& place, const glm::vec3 (&inverse)[3]) {
    if (root.count == 0) return {};
    const Four x = column(place, 0), y = column(place, 1), z = column(place, 2), origin = column(place, 3);
    const Four wide_x = absolute(x), wide_y = absolute(y), wide_z = absolute(z);
    Four low = all_four(3e38f), high = all_four(-3e38f);
    for (uint32_t c = 0; c < root.count; ++c) {
        const glm::vec3 middle = root.middle[c], half = root.half[c];
        const Four at = x * all_four(middle.x) + y * all_four(middle.y) + z * all_four(middle.z) + origin;
        const Four around = wide_x * all_four(half.x) + wide_y * all_four(half.y) + wide_z * all_four(half.z);
        low = lower(low, at - around), high = higher(high, at + around);
    }
    // A ray is rounded on its way into object space. Carried back, that is 16 units in the last place of the coordinates involved, times
    // the transform's condition. What is computed above is off by at most 12 of them: it takes a coordinate of the object at most twice
    // as far as `reach` is carried there. The traversal adds what the ray's own origin brings.
    const Four reach = higher(absolute(origin), higher(absolute(low), absolute(high)));
    const auto carried = [&](int r) { return all_four(2e-6f * (std::abs(inverse[r].x) * reach.v[0] + std::abs(inverse[r].y) * reach.v[1] + std::abs(inverse[r].z) * reach.v[2])); };
    const Four margin = wide_x * carried(0) + wide_y * carried(1) + wide_z * carried(2);
    const Four from = low - margin, to = high + margin;
    const Box box{{from.v[0], from.v[1], from.v[2]}, {to.v[0], to.v[1], to.v[2]}};
    return in_range(box.min) && in_range(box.max) ? box : Box{};
}

}  // namespace

uint32_t add_bottom(Bottoms& bottoms, std::span<const BottomGeometry> geometries) {
    size_t count = 0;
    for (const BottomGeometry& geometry : geometries) count += geometry.triangles.size();
    const Layout layout = bottoms.nodes.layout;
    const float growth = static_growth(layout);
    const double most = double(count) * (1.0 + growth);
    if (double(bottoms.triangles.size()) + most >= shared::kBvhItemMask || double(bottoms.nodes.size()) + most >= shared::kBvhItemMask)  // two numbers are taken
        throw Error(ErrorCode::Failed, "the scene has more than 2^31 triangles", "own BVH", "trace by pipeline or query");
    auto triangles = std::make_unique_for_overwrite<shared::BvhTriangle[]>(count);  // by the threads that fill it
    read_triangles(geometries, triangles.get());
    WideTree tree = build_wide_tree(std::span<const shared::BvhTriangle>(triangles.get(), count), {.width = node_width(layout),
                                                .max_leaf = shared::kBvhMaxLeaf,
                                                .max_depth = max_bottom_depth(layout),
                                                .growth = growth,
                                                .node_cost = bottom_node_cost(layout)});

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
    return make_top_item(RootBoxes(bottoms.nodes.read(root)), root, world_from_object, instance, mask, flags);
}

RootBoxes::RootBoxes(const shared::BvhNode& root) {
    for (int c = 0; c < 4; ++c) {
        if (root.child[c] == shared::kBvhEmpty) continue;
        const glm::vec3 min(root.min_x[c], root.min_y[c], root.min_z[c]), max(root.max_x[c], root.max_y[c], root.max_z[c]);
        middle[count] = 0.5f * (min + max);
        half[count++] = 0.5f * (max - min);
    }
}

TopItem make_top_item(const RootBoxes& root_boxes, uint32_t root, const glm::mat4& world_from_object, uint32_t instance, uint32_t mask, uint32_t flags) {
    const glm::dmat3 inverse = glm::inverse(glm::dmat3(glm::mat3(world_from_object)));
    const glm::vec3 rows[3] = {{inverse[0][0], inverse[1][0], inverse[2][0]}, {inverse[0][1], inverse[1][1], inverse[2][1]}, {inverse[0][2], inverse[1][2], inverse[2][2]}};
    return make_top_item(root_boxes, root, world_from_object, rows, instance, mask, flags);
}

TopItem make_top_item(const RootBoxes& root_boxes, uint32_t root, const glm::mat4& world_from_object, const glm::vec3 (&inverse_rows)[3], uint32_t instance, uint32_t mask, uint32_t flags) {
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
    if (usable) out.box_ws = world_box(root_boxes, world_from_object, inverse_rows);
    return out;
}

Top build_top(std::span<const TopItem> items, Layout layout) {
    MovingTop top(layout);
    top.begin(items.size());
    for (size_t i = 0; i < items.size(); ++i) top.set(i, items[i]);
    top.finish();
    return {top.nodes(), {top.items().begin(), top.items().end()}};
}

}  // namespace parhelion::bvh
