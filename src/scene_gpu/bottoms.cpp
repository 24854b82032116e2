// The bottom levels of both kinds of acceleration structure: built mesh by mesh once the geometry is there, or refitted; the driver's
// then compacted.
#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>

#include "base/error.h"
#include "base/parallel.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

bool never_culled(const Material& material) { return material.double_sided || (material.transmission > 0.0f && !material.unlit); }

}  // namespace

OpacityFlags opacity_flags(const Scene& scene, const Mesh& mesh, bool culling) {
    const auto material = [&](const Primitive& p) -> const Material& { return scene.get(p.material); };
    OpacityFlags flags;
    flags.cull_by_flag = culling && std::ranges::none_of(mesh.primitives, [&](const Primitive& p) { return never_culled(material(p)); });
    const bool any_hit_culls = culling && !flags.cull_by_flag;
    for (const Primitive& p : mesh.primitives) flags.opaque.push_back(material(p).alpha_mode == AlphaMode::Opaque && !(any_hit_culls && !never_culled(material(p))));
    return flags;
}

// ---- ours ----

std::vector<bvh::BottomGeometry> bottom_geometries(const Mesh& mesh) {
    std::vector<bvh::BottomGeometry> out;
    for (const Primitive& p : mesh.primitives) out.push_back({p.positions, p.triangles});
    return out;
}

std::vector<bvh::BottomGeometry> bottom_geometries(const Mesh& mesh, const MeshOnDevice& on_device) {
    std::vector<bvh::BottomGeometry> out = bottom_geometries(mesh);
    for (size_t i = 0; i < out.size(); ++i)
        if (on_device.has_proxy(i)) out[i] = {mesh.primitives[i].positions, on_device.proxies[i].triangles, static_cast<uint32_t>(mesh.primitives[i].triangles.size())};
    return out;
}

// A tree is built with numbers of its own; where it is copied to, they become those of the shared arrays.
RowSource SceneGpu::State::own_node_rows(const MeshOnDevice& mesh) const {
    const auto first_node = static_cast<uint32_t>(mesh.own_nodes), first_triangle = static_cast<uint32_t>(mesh.own_triangles);
    return {bottom_nodes.buffer(), mesh.own_nodes * bvh::node_bytes(layout), bvh::node_bytes(layout), mesh.own_node_count,
            [&tree = *mesh.own_host, first_node, first_triangle](std::byte* to, uint64_t first, uint64_t count) { tree.nodes.copy(first, count, first_node, first_triangle, to); }};
}

RowSource SceneGpu::State::own_triangle_rows(const MeshOnDevice& mesh) const {
    return {bottom_triangles.buffer(), mesh.own_triangles * sizeof(shared::BvhTriangle), sizeof(shared::BvhTriangle), mesh.own_triangle_count,
            [&tree = *mesh.own_host](std::byte* to, uint64_t first, uint64_t count) { std::memcpy(to, tree.triangles.data() + first, count * sizeof(shared::BvhTriangle)); }};
}

// Room for a mesh's tree in the shared arrays.
void SceneGpu::State::take_own_rows(Frame& frame, MeshOnDevice& mesh, uint64_t nodes, uint64_t triangles) {
    mesh.own_node_count = nodes;
    mesh.own_triangle_count = triangles;
    mesh.own_nodes = bottom_nodes.take(frame, nodes);
    mesh.own_triangles = bottom_triangles.take(frame, triangles);
    if (mesh.own_nodes + nodes >= shared::kBvhItemMask || mesh.own_triangles + triangles >= shared::kBvhItemMask)
        throw Error(ErrorCode::Failed, "the scene has more than 2^31 triangles", "own BVH", "trace by pipeline or query");
}

// The next meshes' trees, as many as the slice has triangles for: a large one by all threads, then the others side by side, since one
// of some thousand triangles is no work for many.
std::vector<SceneGpu::State::OwnTree> SceneGpu::State::build_own_trees(Slice& slice) {
    std::vector<OwnTree> trees;
    uint64_t triangles = 0;
    for (const Handle<Mesh> handle : wanted_meshes) {
        const MeshOnDevice& mesh = meshes.at(handle);
        if (mesh.own_ready || mesh.rest) continue;
        if (uses_proxies() && mesh.parts.empty()) break;
        if (!slice.has_triangles() || !slice.has_bytes()) break;
        slice.take_triangles(mesh.triangle_count);
        triangles += mesh.triangle_count;
        trees.push_back({handle, mesh.triangle_count, std::make_unique<bvh::Bottoms>()});
    }
    const auto build = [&](const OwnTree& tree) {
        tree.host->nodes.layout = layout;
        bvh::add_bottom(*tree.host, bottom_geometries(scene->get(tree.mesh), meshes.at(tree.mesh)));
    };
    std::vector<const OwnTree*> small;
    for (const OwnTree& tree : trees) {
        if (tree.triangles * hardware_threads() < triangles) small.push_back(&tree);
        else build(tree);
    }
    std::ranges::stable_sort(small, std::greater(), &OwnTree::triangles);
    parallel_for(small.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) build(*small[i]);
    });
    return trees;
}

// One slice's trees at a time are on the host. Deformed forms have theirs from their mesh at rest (refit.cpp).
void SceneGpu::State::build_own_bottoms(Frame& frame, Slice& slice) {
    if (!options.own_bvh) return;
    for (;;) {
        for (const Handle<Mesh> handle : wanted_meshes) {
            MeshOnDevice& mesh = meshes.at(handle);
            if (!mesh.own_host) continue;
            const RowSource rows[] = {own_node_rows(mesh), own_triangle_rows(mesh)};
            if (!upload_rows(frame, slice, rows, mesh.own_done_rows)) return;
            mesh.own_host.reset();
            mesh.own_ready = true;
        }
        const auto start = std::chrono::steady_clock::now();
        std::vector<OwnTree> trees = build_own_trees(slice);
        stats.own_build_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (trees.empty()) return;
        for (OwnTree& tree : trees) {
            MeshOnDevice& mesh = meshes.at(tree.mesh);
            take_own_rows(frame, mesh, tree.host->nodes.size(), tree.host->triangles.size());
            mesh.own_root = bvh::RootBoxes(tree.host->nodes.read(tree.host->roots.front()));
            mesh.own_host = std::move(tree.host);
        }
    }
}

// ---- the driver's ----

namespace {

gpu::BlasBuild make_build(const MeshOnDevice& mesh, const OpacityFlags& flags) {
    gpu::BlasBuild build;
    for (size_t i = 0; i < mesh.parts.size(); ++i)
        build.geometries.push_back({.positions = mesh.parts[i].positions.address(),
                                    .vertex_count = mesh.parts[i].vertex_count,
                                    .indices = mesh.parts[i].indices.address() + (mesh.has_proxy(i) ? mesh.parts[i].triangle_count * sizeof(glm::uvec3) : 0),
                                    .triangle_count = mesh.has_proxy(i) ? mesh.parts[i].proxy_count : mesh.parts[i].triangle_count,
                                    .opaque = flags.opaque[i]});
    return build;
}

// Vulkan lets a refit change positions only, so a form that winds some triangles the other way (mirroring joints) is built.
bool same_triangles(const Mesh& form, const Mesh& rest) {
    return form.deformation || std::ranges::equal(form.primitives, rest.primitives, [](const Primitive& x, const Primitive& y) { return x.triangles == y.triangles; });
}

}  // namespace

// What is deformed is refitted from its mesh at rest, where that can be; the others are built, those at rest so that they can be refitted.
void SceneGpu::State::build_driver_bottoms(Frame& frame, Slice& slice) {
    if (!uses_hardware()) return;
    std::vector<gpu::BlasBuild> builds, refits;
    Measurement measurement;
    uint64_t scratch = 0;
    for (const Handle<Mesh> handle : resident_meshes) {
        MeshOnDevice& mesh = meshes.at(handle);
        if (!mesh.uploaded) continue;
        const Mesh& source = scene->get(handle);
        OpacityFlags flags = opacity_flags(*scene, source, options.culling);
        if (mesh.blas && mesh.opaque == flags.opaque && (!mesh.has_forms || mesh.blas.deforming())) {
            mesh.cull_by_flag = flags.cull_by_flag;
            continue;
        }
        mesh.blas = mesh.refit_base = {};
        if (!slice.has_triangles() || scratch > 4 * options.slice_bytes) continue;
        gpu::BlasBuild build = make_build(mesh, flags);
        bool is_base = false;  // others will be refitted from it
        if (mesh.rest && same_triangles(source, scene->get(mesh.rest))) {
            const MeshOnDevice& rest = meshes.at(mesh.rest);
            if (!rest.blas) continue;
            is_base = rest.rebuild_driver && rest.opaque == flags.opaque;
            if (rest.opaque == flags.opaque && !is_base) build.refit_from = rest.refit_base ? rest.refit_base : rest.blas;
        }
        const bool deforming = mesh.has_forms || is_base || build.refit_from;
        build.blas = mesh.blas = gpu::AccelStruct::bottom(device, "accel/bottom", build.geometries, deforming ? gpu::BlasClass::Deforming : gpu::BlasClass::Static);
        mesh.opaque = std::move(flags.opaque);
        mesh.cull_by_flag = flags.cull_by_flag;
        mesh.built_bytes = mesh.blas.bytes();
        if (is_base) rebase_refits(meshes.at(mesh.rest), mesh);
        scratch += mesh.blas.scratch_bytes();
        slice.take_triangles(mesh.triangle_count);
        if (!deforming) {
            measurement.built.push_back(mesh.blas);
            measurement.meshes.push_back(handle);
        }
        (build.refit_from ? refits : builds).push_back(std::move(build));
    }
    if (!builds.empty()) frame.build_blas(std::move(builds), geometry_buffers());
    if (!refits.empty()) frame.build_blas(std::move(refits), geometry_buffers());
    if (!options.compact || measurement.meshes.empty()) return;
    measurement.sizes = gpu::AccelSizes(device, static_cast<uint32_t>(measurement.built.size()));
    frame.measure_blas(measurement.built, measurement.sizes);
    measurements.push_back(std::move(measurement));
}

void SceneGpu::State::rebase_refits(MeshOnDevice& rest, const MeshOnDevice& form) {
    rest.refit_base = form.blas;
    rest.rebuild_driver = false;
    note_rebuilt(rest);
}

// The frame that asked for the sizes is done when it no longer holds what they are written to.
void SceneGpu::State::compact_bottoms(Frame& frame) {
    std::erase_if(measurements, [&](const Measurement& measurement) {
        if (measurement.sizes.data().use_count() > 1) return false;
        const std::vector<uint64_t> bytes = measurement.sizes.read();
        for (size_t i = 0; i < bytes.size(); ++i) {
            const auto mesh = meshes.find(measurement.meshes[i]);
            const gpu::AccelStruct& built = measurement.built[i];
            if (mesh == meshes.end() || mesh->second.blas.id() != built.id() || bytes[i] == 0 || bytes[i] >= built.bytes()) continue;
            mesh->second.blas = gpu::AccelStruct::compacted(device, "accel/bottom", bytes[i]);
            frame.compact_blas(built, mesh->second.blas);
            moved_by_compaction |= mesh->second.drawn_at != 0;
        }
        return true;
    });
    stats.bottom_bytes_built = stats.bottom_bytes = 0;
    for (const Handle<Mesh> handle : resident_meshes) {
        const MeshOnDevice& mesh = meshes.at(handle);
        if (!mesh.blas) continue;
        stats.bottom_bytes_built += mesh.built_bytes;
        stats.bottom_bytes += mesh.blas.bytes();
    }
}

}  // namespace parhelion
