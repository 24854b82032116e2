// Where things stand: instance rows and the top levels, made anew whenever something moved. Top levels alternate between two
// sets of storage, so that the previous frame's stays traceable.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <numeric>

#include "base/error.h"
#include "base/parallel.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

constexpr size_t kGrain = 1024;

shared::Affine to_affine(const glm::mat4& m) {
    return {{m[0][0], m[1][0], m[2][0], m[3][0]}, {m[0][1], m[1][1], m[2][1], m[3][1]}, {m[0][2], m[1][2], m[2][2], m[3][2]}};
}

shared::Affine inverse_affine(const glm::mat4& m) {
    const glm::dmat3 inverse = glm::inverse(glm::dmat3(glm::mat3(m)));
    const glm::dvec3 origin = inverse * -glm::dvec3(m[3]);
    const auto row = [&](int r) { return glm::vec4(inverse[0][r], inverse[1][r], inverse[2][r], origin[r]); };
    return {row(0), row(1), row(2)};
}

gpu::TlasInstance to_tlas(const shared::Instance& row, InstanceOpacity opacity, const MeshOnDevice& mesh, uint32_t index) {
    gpu::TlasInstance out{};
    const glm::vec4 rows[3] = {row.world_from_object.row0, row.world_from_object.row1, row.world_from_object.row2};
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) out.world_from_object[4 * r + c] = rows[r][c];
    out.custom_index_and_mask = index | row.mask << 24;
    // Vulkan and glTF agree on the front side (counter-clockwise, seen right-handed) and judge it in object space.
    uint32_t flags = mesh.cull_by_flag ? 0u : gpu::kInstanceDisableCulling;
    if (opacity == InstanceOpacity::Opaque) flags |= gpu::kInstanceForceOpaque;
    if (opacity == InstanceOpacity::Asked) flags |= gpu::kInstanceForceNoOpaque;
    out.sbt_offset_and_flags = flags << 24;
    out.blas_address = mesh.blas.address();
    return out;
}

// BvhTopItem::flags of a mesh.
uint32_t own_flags(const OpacityFlags& of_mesh) {
    uint32_t flags = of_mesh.cull_by_flag ? shared::kBvhCullBack : 0u;
    bool others = true;
    for (uint32_t g = 0; g < of_mesh.opaque.size(); ++g) {
        if (g < shared::kBvhOtherGeometries) flags |= uint32_t(of_mesh.opaque[g]) << g;
        else others &= of_mesh.opaque[g];
    }
    return flags | uint32_t(others) << shared::kBvhOtherGeometries;
}

uint32_t own_flags(uint32_t of_mesh, InstanceOpacity opacity) {
    if (opacity == InstanceOpacity::Opaque) return of_mesh | shared::kBvhOpaque;
    return opacity == InstanceOpacity::Asked ? of_mesh & ~shared::kBvhOpaque : of_mesh;
}

// Skin or weights can move its vertices, whether they do so now or not: where they were a frame ago is not said by transforms alone.
bool deforms(const Scene& scene, const Instance& instance) {
    const auto has_targets = [](const Primitive& p) { return !p.targets.empty(); };
    return instance.posed || instance.skin || std::ranges::any_of(scene.get(instance.mesh).primitives, has_targets);
}

}  // namespace

// An instance keeps its row while it is drawn. A row that it leaves keeps its contents for one frame, because the previous frame's
// top level still points at it, and is then given to another. Returns the rows in use, in order.
std::vector<uint32_t> SceneGpu::State::assign_instance_rows() {
    const SlotMap<Instance>& all = scene->instances();
    const std::vector<InstanceRow> rows_before = std::move(instance_rows);
    free_rows.insert(free_rows.end(), left_rows.begin(), left_rows.end());
    std::sort(free_rows.begin(), free_rows.end(), std::greater<>());
    left_rows.clear();
    instance_rows.assign(all.slot_count(), {});
    instance_handles.assign(instances.size(), {});
    std::vector<Handle<Instance>> new_ones;
    for (const auto& [handle, instance] : all) {
        if (!can_be_seen(instance.place) || scene->get(instance.drawn_mesh()).triangle_count == 0) continue;
        const InstanceRow old = handle.index < rows_before.size() ? rows_before[handle.index] : InstanceRow{};
        if (old.generation != handle.generation) {
            new_ones.push_back(handle);
            continue;
        }
        instance_rows[handle.index] = old;
        instance_handles[old.row] = handle;
    }
    for (const Handle<Instance> handle : new_ones) {
        auto row = static_cast<uint32_t>(instance_handles.size());
        if (free_rows.empty()) instance_handles.emplace_back();
        else row = free_rows.back(), free_rows.pop_back();
        instance_rows[handle.index] = {handle.generation, row};
        instance_handles[row] = handle;
    }
    for (const InstanceRow& old : rows_before)
        if (old.generation != 0 && !instance_handles[old.row]) left_rows.push_back(old.row);
    translate_instances(new_ones);
    instances.resize(instance_handles.size());
    std::vector<uint32_t> drawn;
    drawn.reserve(all.size());
    for (uint32_t row = 0; row < instance_handles.size(); ++row)
        if (instance_handles[row]) drawn.push_back(row);
    return drawn;
}

// Makes the way back from this frame's rows to the previous one's: every row is what it was, but for those that have just come or gone.
// Where only bottom levels have gone elsewhere the previous frame is still the same.
void SceneGpu::State::translate_instances(std::span<const Handle<Instance>> new_ones) {
    if (!anything_stale) return;
    instances_before = static_cast<uint32_t>(instances.size());
    instance_translation = {};
    for (const uint32_t row : left_rows) {
        instances[row].world_from_object_before = instances[row].world_from_object;
        instances[row].geometry_base_before = instances[row].geometry_base;
    }
    row_meshes.resize(instance_handles.size());
    for (const Handle<Instance> handle : new_ones) row_meshes[instance_rows[handle.index].row] = {};
    const auto is_old = [&](Handle<Instance> handle) { return instance_rows[handle.index].row < instances_before; };
    if (left_rows.empty() && std::ranges::none_of(new_ones, is_old)) return;
    std::vector<uint32_t> rows(instances_before);
    std::iota(rows.begin(), rows.end(), 0u);
    for (const uint32_t row : left_rows) rows[row] = shared::kNone;
    for (const Handle<Instance> handle : new_ones)
        if (is_old(handle)) rows[instance_rows[handle.index].row] = shared::kNone;
    instance_translation = make_table("instance_before_of_now", std::move(rows));
}

// The mesh that each of these rows draws.
std::vector<MeshOnDevice*> SceneGpu::State::note_drawn(std::span<const uint32_t> drawn) {
    std::vector<MeshOnDevice*> by_index(scene->meshes().slot_count(), nullptr), out;
    for (const Handle<Mesh> handle : wanted_meshes) by_index[handle.index] = &meshes.at(handle);
    out.reserve(drawn.size());
    stats.instanced_triangles = stats.instanced_traced_triangles = 0;
    for (const uint32_t row : drawn) {
        MeshOnDevice* mesh = by_index[scene->get(instance_handles[row]).drawn_mesh().index];
        mesh->drawn_at = published + 1;
        if (mesh->made_here) meshes.at(mesh->rest).drawn_at = published + 1;  // whose triangles it has
        stats.instanced_triangles += mesh->triangle_count;
        stats.instanced_traced_triangles += mesh->traced_triangles();
        out.push_back(mesh);
    }
    return out;
}

// The geometries of what the row drew a frame ago, if that was a form of the same mesh: its vertices are those of now, elsewhere.
uint32_t SceneGpu::State::base_before(uint32_t row, const MeshOnDevice& mesh, Handle<Mesh> handle) const {
    const auto drawn = meshes.find(row_meshes[row]);
    if (drawn == meshes.end()) return mesh.geometry_base;
    const Handle<Mesh> rest_before = drawn->second.rest ? drawn->second.rest : drawn->first, rest = mesh.rest ? mesh.rest : handle;
    return rest_before == rest ? drawn->second.geometry_base : mesh.geometry_base;
}

void SceneGpu::State::place_instances() {
    const std::vector<uint32_t> drawn = assign_instance_rows();
    if (instances.size() > 0xFFFFFFu)
        throw Error(ErrorCode::Failed, fmt::format("the scene has {} instances, a top level holds {}", instances.size(), 0xFFFFFF), scene->source().name, "join meshes");
    const std::vector<MeshOnDevice*> drawn_mesh = note_drawn(drawn);
    stats.instances = static_cast<uint32_t>(drawn.size());
    stats.instance_rows = static_cast<uint32_t>(instances.size());
    uint32_t geometries_before = 0;
    for (size_t i = 0; i < drawn.size(); ++i) {
        instances[drawn[i]].emitter_base = geometries_before;
        geometries_before += static_cast<uint32_t>(drawn_mesh[i]->parts.size());
    }
    geometry_emitter_rows.assign(geometries_before, shared::kNone);
    parallel_for(drawn.size(), kGrain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            shared::Instance& row = instances[drawn[i]];
            const Instance& instance = scene->get(instance_handles[drawn[i]]);
            const Placement& place = instance.place;
            row.world_from_object = to_affine(place.world_from_object);
            row.object_from_world = inverse_affine(place.world_from_object);
            row.world_from_object_before = to_affine(place.world_from_object_before);
            row.geometry_base = drawn_mesh[i]->geometry_base;
            row.geometry_count = static_cast<uint32_t>(drawn_mesh[i]->parts.size());
            if (anything_stale) row.geometry_base_before = base_before(drawn[i], *drawn_mesh[i], instance.drawn_mesh());
            row.flags = (mirrors(place.world_from_object) ? shared::kInstanceFlipsFacing : 0u) | (deforms(*scene, instance) ? shared::kInstanceDeforms : 0u);
            row.mask = instance.ray_mask;
        }
    });
    if (anything_stale)
        for (const uint32_t row : drawn) row_meshes[row] = scene->get(instance_handles[row]).drawn_mesh();
    instance_table = make_table("instances", std::span<const shared::Instance>(instances));
    next = {};
    if (uses_hardware()) place_driver_top(drawn, drawn_mesh);
    if (options.own_bvh) place_own_top(drawn, drawn_mesh);
    if (options.raster) place_drawn(drawn, drawn_mesh);
}

void SceneGpu::State::place_driver_top(std::span<const uint32_t> drawn, std::span<MeshOnDevice* const> drawn_mesh) {
    std::vector<gpu::TlasInstance> rows(drawn.size());
    parallel_for(drawn.size(), kGrain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) rows[i] = to_tlas(instances[drawn[i]], scene->get(instance_handles[drawn[i]]).opacity, *drawn_mesh[i], drawn[i]);
    });
    tlas_count = static_cast<uint32_t>(rows.size());
    tlas_instances = make_table("tlas_instances", std::move(rows));
    // A mesh of many instances is kept once.
    for (const Handle<Mesh> handle : wanted_meshes)
        if (const MeshOnDevice& mesh = meshes.at(handle); mesh.drawn_at == published + 1) next.kept.push_back(mesh.blas);
    std::ranges::sort(next.kept, {}, &gpu::AccelStruct::id);
}

void SceneGpu::State::place_own_top(std::span<const uint32_t> drawn, std::span<MeshOnDevice* const> drawn_mesh) {
    stats.node_layout = bvh::layout_name(layout);
    stats.own_bottom_bytes = 0;
    for (const Handle<Mesh> handle : wanted_meshes) {
        MeshOnDevice& mesh = meshes.at(handle);
        if (materials_stale || !mesh.own_flags) mesh.own_flags = own_flags(opacity_flags(*scene, scene->get(handle), options.culling));
        stats.own_bottom_bytes += mesh.own_node_count * bvh::node_bytes(layout) + mesh.own_triangle_count * sizeof(shared::BvhTriangle);
    }
    for (const Handle<Mesh> handle : resident_meshes)
        stats.own_bottom_bytes += meshes.at(handle).plan.node_count * sizeof(shared::RefitNode) + meshes.at(handle).plan.triangle_count * sizeof(shared::RefitTriangle);
    const auto start = std::chrono::steady_clock::now();
    own_top.begin(drawn.size());
    std::atomic<bool> plain = true;
    parallel_for(drawn.size(), kGrain, [&](size_t begin, size_t end) {
        bool all_plain = true;
        for (size_t i = begin; i < end; ++i) {
            const MeshOnDevice& mesh = *drawn_mesh[i];
            const Instance& instance = scene->get(instance_handles[drawn[i]]);
            const shared::Affine& inverse = instances[drawn[i]].object_from_world;
            const uint32_t flags = own_flags(*mesh.own_flags, instance.opacity);
            all_plain &= (flags & shared::kBvhOpaque) == shared::kBvhOpaque;
            own_top.set(i, bvh::make_top_item(mesh.own_root, static_cast<uint32_t>(mesh.own_nodes), instance.place.world_from_object,
                                              {glm::vec3(inverse.row0), glm::vec3(inverse.row1), glm::vec3(inverse.row2)}, drawn[i], instance.ray_mask, flags));
        }
        if (!all_plain) plain = false;
    });
    own_top.finish();
    next.plain = plain;
    stats.own_top_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    stats.own_top_refits = own_top.refits();
    stats.own_top_bytes = own_top.nodes().bytes() + own_top.items().size_bytes();
    next.nodes = make_table("top_nodes", std::span<const uint32_t>(own_top.nodes().words));
    next.items = make_table("top_items", own_top.items());
}

}  // namespace parhelion
