// Where things stand: instance rows and the top levels, made anew whenever something moved. Top levels alternate between two
// sets of storage, so that the previous frame's stays traceable.
#include <algorithm>
#include <functional>

#include <glm/gtc/matrix_inverse.hpp>

#include "base/error.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

shared::Affine to_affine(const glm::mat4& m) {
    return {{m[0][0], m[1][0], m[2][0], m[3][0]}, {m[0][1], m[1][1], m[2][1], m[3][1]}, {m[0][2], m[1][2], m[2][2], m[3][2]}};
}

gpu::TlasInstance to_tlas(const shared::Instance& row, const MeshOnDevice& mesh, uint32_t index) {
    gpu::TlasInstance out{};
    const glm::vec4 rows[3] = {row.world_from_object.row0, row.world_from_object.row1, row.world_from_object.row2};
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) out.world_from_object[4 * r + c] = rows[r][c];
    out.custom_index_and_mask = index | row.mask << 24;
    // Vulkan and glTF agree on the front side (counter-clockwise, seen right-handed) and judge it in object space.
    const uint32_t flags = mesh.cull_by_flag ? 0u : gpu::kInstanceDisableCulling;
    out.sbt_offset_and_flags = flags << 24;
    out.blas_address = mesh.blas.address();
    return out;
}

// Skin or weights can move its vertices, whether they do so now or not: where they were a frame ago is not said by transforms alone.
bool deforms(const Scene& scene, const Instance& instance) {
    const auto has_targets = [](const Primitive& p) { return !p.targets.empty(); };
    return instance.posed || instance.skin || std::ranges::any_of(scene.get(instance.mesh).primitives, has_targets);
}

}  // namespace

// An instance keeps its row while it is drawn. A row that it leaves keeps its contents for one frame, because the previous frame's
// top level still points at it, and is then given to another.
void SceneGpu::State::assign_instance_rows() {
    const std::unordered_map<Handle<Instance>, uint32_t> rows_before = std::move(instance_rows);
    free_rows.insert(free_rows.end(), left_rows.begin(), left_rows.end());
    std::sort(free_rows.begin(), free_rows.end(), std::greater<>());
    left_rows.clear();
    instance_rows.clear();
    for (const auto& [handle, instance] : scene->instances()) {
        if (!drawable(instance.place.world_from_object) || scene->get(instance.drawn_mesh()).triangle_count == 0) continue;
        const auto kept = rows_before.find(handle);
        uint32_t row = static_cast<uint32_t>(instances.size());
        if (kept != rows_before.end()) {
            row = kept->second;
        } else if (!free_rows.empty()) {
            row = free_rows.back();
            free_rows.pop_back();
        }
        if (row == instances.size()) instances.emplace_back();
        instance_rows[handle] = row;
    }
    instance_handles.assign(instances.size(), {});
    for (const auto& [handle, row] : instance_rows) instance_handles[row] = handle;
    for (const auto& [handle, row] : rows_before)
        if (!instance_handles[row]) left_rows.push_back(row);
}

void SceneGpu::State::place_instances() {
    assign_instance_rows();
    geometry_emitter_rows.clear();
    std::vector<gpu::TlasInstance> driver;
    std::vector<bvh::TopItem> own;
    next = {};
    stats.instanced_triangles = 0;
    for (uint32_t index = 0; index < instances.size(); ++index) {
        if (!instance_handles[index]) continue;
        const Instance& instance = scene->get(instance_handles[index]);
        const glm::mat4& world = instance.place.world_from_object;
        MeshOnDevice& on_device = meshes.at(instance.drawn_mesh());
        on_device.drawn_at = published + 1;
        const auto geometry_count = static_cast<uint32_t>(on_device.parts.size());
        const glm::mat4 inverse(glm::inverse(glm::dmat4(world)));
        instances[index] = {.world_from_object = to_affine(world),
                            .object_from_world = to_affine(inverse),
                            .world_from_object_before = to_affine(instance.place.world_from_object_before),
                            .geometry_base = on_device.geometry_base,
                            .geometry_count = geometry_count,
                            .emitter_base = static_cast<uint32_t>(geometry_emitter_rows.size()),
                            .flags = (mirrors(world) ? shared::kInstanceFlipsFacing : 0u) | (deforms(*scene, instance) ? shared::kInstanceDeforms : 0u),
                            .mask = 0xFFu};
        geometry_emitter_rows.resize(geometry_emitter_rows.size() + geometry_count, shared::kNone);
        stats.instanced_triangles += on_device.triangle_count;
        if (uses_hardware()) {
            driver.push_back(to_tlas(instances[index], on_device, index));
            next.kept.push_back(on_device.blas);
        }
        if (options.own_bvh) own.push_back(bvh::make_top_item(on_device.own_root, static_cast<uint32_t>(on_device.own_nodes), world, index));
    }
    stats.instances = static_cast<uint32_t>(instance_rows.size());
    if (instances.size() > 0xFFFFFFu)
        throw Error(ErrorCode::Failed, fmt::format("the scene has {} instances, a top level holds {}", instances.size(), 0xFFFFFF), scene->source().name, "join meshes");
    instance_table = make_table("instances", std::span<const shared::Instance>(instances));
    if (uses_hardware()) {
        tlas_count = static_cast<uint32_t>(driver.size());
        tlas_instances = make_table("tlas_instances", std::move(driver));
        // A mesh of many instances is kept once.
        std::ranges::sort(next.kept, {}, &gpu::AccelStruct::id);
        next.kept.erase(std::ranges::unique(next.kept, {}, &gpu::AccelStruct::id).begin(), next.kept.end());
    }
    if (options.own_bvh) {
        stats.node_layout = bvh::layout_name(layout);
        stats.own_bottom_bytes = 0;
        for (const Handle<Mesh> handle : wanted_meshes)
            stats.own_bottom_bytes += meshes.at(handle).own_node_count * bvh::node_bytes(layout) + meshes.at(handle).own_triangle_count * sizeof(shared::BvhTriangle);
        for (const Handle<Mesh> handle : resident_meshes)
            stats.own_bottom_bytes += meshes.at(handle).plan.node_count * sizeof(shared::RefitNode) + meshes.at(handle).plan.triangle_count * sizeof(shared::RefitTriangle);
        bvh::Top top = bvh::build_top(own, layout);
        stats.own_top_bytes = top.nodes.bytes() + top.items.size() * sizeof(shared::BvhTopItem);
        next.nodes = make_table("top_nodes", std::move(top.nodes.words));
        next.items = make_table("top_items", std::move(top.items));
    }
}

}  // namespace parhelion
