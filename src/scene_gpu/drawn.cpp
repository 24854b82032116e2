// What raster passes draw: a row for every geometry of every instance, with its box, grouped by how its triangles are looked at.
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

constexpr uint32_t kNobody = 0xFFFFFFFFu;

// As the ways to trace treat it: a hit on an opaque instance is never asked about, and culled only if its whole mesh is.
uint32_t kind_of(uint32_t flags, InstanceOpacity opacity, bool culling, bool culled_as_a_whole) {
    using namespace shared;
    if (opacity == InstanceOpacity::Opaque) return culled_as_a_whole ? kRasterOneSided : kRasterTwoSided;
    if ((flags & kAlphaModeMask) != kAlphaOpaque) return kRasterAsked;
    return culling && (flags & (kMaterialDoubleSided | kMaterialTransmits)) == 0 ? kRasterOneSided : kRasterTwoSided;
}

}  // namespace

void SceneGpu::State::place_drawn(std::span<const uint32_t> drawn, std::span<MeshOnDevice* const> drawn_mesh) {
    std::array<std::vector<shared::DrawnGeometry>, shared::kRasterKindCount> kinds;
    for (size_t i = 0; i < drawn.size(); ++i) {
        const Instance& instance = scene->get(instance_handles[drawn[i]]);
        const Mesh& mesh = scene->get(instance.drawn_mesh());
        const bool culled_as_a_whole = instance.opacity == InstanceOpacity::Opaque && opacity_flags(*scene, mesh, options.culling).cull_by_flag;
        for (uint32_t g = 0; g < mesh.primitives.size(); ++g) {
            if (drawn_mesh[i]->parts[g].triangle_count == 0) continue;
            const uint32_t flags = geometries[drawn_mesh[i]->geometry_base + g].flags;
            const Bounds& box = mesh.primitives[g].bounds;
            kinds[kind_of(flags, instance.opacity, options.culling, culled_as_a_whole)].push_back({drawn[i], g, box.min, box.max});
        }
    }
    std::vector<shared::DrawnGeometry> rows;
    for (uint32_t kind = 0; kind < shared::kRasterKindCount; ++kind) {
        drawn_next.begin[kind] = static_cast<uint32_t>(rows.size());
        drawn_next.count[kind] = static_cast<uint32_t>(kinds[kind].size());
        rows.insert(rows.end(), kinds[kind].begin(), kinds[kind].end());
        while (rows.size() % shared::kRasterGroup != 0) rows.push_back({.instance = kNobody});
    }
    drawn_next.begin.back() = static_cast<uint32_t>(rows.size());
    drawn_next.table = make_table("drawn_geometries", std::move(rows));
}

}  // namespace parhelion
