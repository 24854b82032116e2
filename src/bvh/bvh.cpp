#include "bvh/bvh.h"

#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "bvh/top_tree.h"

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
                triangles[first + t] = {.p0 = p0, .p1 = p1, .p2 = p2, .rest = 0, .geometry = g, .primitive = static_cast<uint32_t>(t)};
            }
        });
        first += geometry.triangles.size();
    }
}

// References that spatial splits may add: what keeps a triangle within 96 bytes, and the compact layout within 64.
float static_growth(Layout layout) { return layout == Layout::Four ? 0.3f : layout == Layout::Binary ? 0.15f : 0.0f; }

inline glm::dmat3 absolute(const glm::dmat3& m) { return {glm::abs(m[0]), glm::abs(m[1]), glm::abs(m[2])}; }

// In float; false for NaN.
bool is_finite(const glm::dmat3& m) {
    bool all = true;
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) all &= std::abs(m[c][r]) <= double(std::numeric_limits<float>::max());
    return all;
}

// World box of an instance: that of its root's children, which is tighter under rotation than that of the whole.
Box world_box(const shared::BvhNode& root, const glm::dmat3& linear, const glm::dmat3& inverse, const glm::dvec3& origin) {
    const glm::dmat3 turned = absolute(linear);
    glm::dvec3 low(1e300), high(-1e300), reach = glm::abs(origin);
    for (int c = 0; c < 4; ++c) {
        if (root.child[c] == shared::kBvhEmpty) continue;
        const glm::dvec3 min(root.min_x[c], root.min_y[c], root.min_z[c]), max(root.max_x[c], root.max_y[c], root.max_z[c]);
        const glm::dvec3 middle = linear * (0.5 * (min + max)) + origin, half = turned * (0.5 * (max - min));
        low = glm::min(low, middle - half), high = glm::max(high, middle + half);
    }
    Box box;
    if (low.x > high.x) return box;
    // A ray is rounded on its way into object space. Carried back, that is some units in the last place of the coordinates
    // involved, times the transform's condition. The traversal adds what the ray's own origin brings.
    reach = glm::max(reach, glm::max(glm::abs(low), glm::abs(high)));
    const glm::dvec3 margin = 1e-6 * (turned * (absolute(inverse) * reach));
    box.min = glm::vec3(low - margin), box.max = glm::vec3(high + margin);
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
    return make_top_item(bottoms.nodes.read(root), root, world_from_object, instance, mask, flags);
}

TopItem make_top_item(const shared::BvhNode& root_node, uint32_t root, const glm::mat4& world_from_object, uint32_t instance, uint32_t mask, uint32_t flags) {
    const glm::dmat3 linear{glm::dmat4(world_from_object)}, inverse = glm::inverse(linear);
    const glm::vec3 origin(world_from_object[3]);
    const auto row = [&](int r) { return glm::vec3(inverse[0][r], inverse[1][r], inverse[2][r]); };
    TopItem out{.item = {.row0 = row(0),
                         .instance = instance,
                         .row1 = row(1),
                         .root = root,
                         .row2 = row(2),
                         .mask = mask,
                         .origin_ws = origin,
                         .flags = flags},
                .box_ws = {}};
    if (is_finite(linear) && is_finite(inverse) && in_range(origin)) out.box_ws = world_box(root_node, linear, inverse, glm::dvec3(origin));
    return out;
}

Top build_top(std::span<const TopItem> items, Layout layout) {
    if (items.size() > size_t(1) << shared::kBvhTopLevels)
        throw Error(ErrorCode::Failed, fmt::format("the scene has {} instances; our own BVH holds 2^24", items.size()), "own BVH", "trace by pipeline or query");
    std::vector<Box> boxes(items.size());
    for (size_t i = 0; i < items.size(); ++i) boxes[i] = items[i].box_ws;
    const WideTree tree = build_top_tree(boxes, node_width(layout), max_top_depth(layout));
    Top top{.nodes = {.layout = layout, .words = {}}, .items = {}};
    top.nodes.append(tree, 0);
    top.items.reserve(tree.order.size());
    for (const uint32_t i : tree.order) top.items.push_back(items[i].item);
    return top;
}

}  // namespace parhelion::bvh
