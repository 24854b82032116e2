// Geometry in shared buffers, and the bottom levels of both kinds of acceleration structure.
#include <algorithm>
#include <chrono>

#include "base/error.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

uint32_t pack_color(glm::vec4 color) {
    const glm::vec4 scaled = glm::clamp(color, glm::vec4(0.0f), glm::vec4(1.0f)) * 255.0f + 0.5f;
    return uint32_t(scaled.x) | uint32_t(scaled.y) << 8 | uint32_t(scaled.z) << 16 | uint32_t(scaled.w) << 24;
}

// Missing attributes: normals become zero (the surface then takes the triangle's own), colours white.
void append_attributes(const Primitive& primitive, std::vector<shared::VertexAttributes>& out) {
    const auto at = [](const auto& values, size_t i, auto fallback) { return values.empty() ? fallback : values[i]; };
    for (size_t i = 0; i < primitive.positions.size(); ++i)
        out.push_back({.normal = at(primitive.normals, i, glm::vec3(0.0f)),
                       .tangent = at(primitive.tangents, i, glm::vec4(0.0f)),
                       .uv0 = at(primitive.uv0, i, glm::vec2(0.0f)),
                       .uv1 = at(primitive.uv1, i, glm::vec2(0.0f)),
                       .color = primitive.colors.empty() ? ~0u : pack_color(primitive.colors[i])});
}

}  // namespace

void SceneGpu::State::upload_geometry(Frame& frame) {
    std::vector<glm::vec3> all_positions;
    std::vector<glm::uvec3> all_indices;
    std::vector<shared::VertexAttributes> all_attributes;
    std::vector<uint64_t> first_vertex, first_triangle;
    geometries.clear();
    meshes.clear();
    bottoms = {};
    stats.triangles = 0;
    const auto start = std::chrono::steady_clock::now();
    for (const auto& [handle, mesh] : scene->meshes()) {
        MeshOnDevice& on_device = meshes[handle];
        on_device.geometry_base = static_cast<uint32_t>(geometries.size());
        on_device.geometry_count = static_cast<uint32_t>(mesh.primitives.size());
        std::vector<bvh::BottomGeometry> own;
        for (const Primitive& primitive : mesh.primitives) {
            const uint32_t row = material_rows.at(primitive.material);
            geometries.push_back({.triangle_count = static_cast<uint32_t>(primitive.triangles.size()),
                                  .vertex_count = static_cast<uint32_t>(primitive.positions.size()),
                                  .material = row,
                                  .flags = materials[row].flags,
                                  .triangle_table = shared::kNone});
            first_vertex.push_back(all_positions.size());
            first_triangle.push_back(all_indices.size());
            all_positions.insert(all_positions.end(), primitive.positions.begin(), primitive.positions.end());
            all_indices.insert(all_indices.end(), primitive.triangles.begin(), primitive.triangles.end());
            append_attributes(primitive, all_attributes);
            own.push_back({primitive.positions, primitive.triangles});
        }
        stats.triangles += mesh.triangle_count;
        if (options.own_bvh) on_device.own_root = bvh::add_bottom(bottoms, own);
    }
    stats.own_build_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    stats.meshes = static_cast<uint32_t>(meshes.size());

    positions = make_buffer(frame, "positions", all_positions);
    indices = make_buffer(frame, "indices", all_indices);
    attributes = make_buffer(frame, "attributes", all_attributes);
    for (size_t g = 0; g < geometries.size(); ++g) {
        geometries[g].positions = positions.address() + first_vertex[g] * sizeof(glm::vec3);
        geometries[g].indices = indices.address() + first_triangle[g] * sizeof(glm::uvec3);
        geometries[g].attributes = attributes.address() + first_vertex[g] * sizeof(shared::VertexAttributes);
    }
    upload_triangle_tables(frame);
    geometry_table = make_buffer(frame, "geometries", geometries);
    if (options.own_bvh) {
        bottom_nodes = make_buffer(frame, "bottom_nodes", bottoms.nodes);
        bottom_triangles = make_buffer(frame, "bottom_triangles", bottoms.triangles);
    }
    if (!uses_hardware()) return;
    for (auto& [handle, mesh] : meshes) {
        // The driver culls by a flag of the whole instance. A mesh that mixes single- and double-sided geometries is not culled by
        // it; any-hit does it there, so its single-sided geometries are not opaque to the driver.
        const auto first = geometries.begin() + mesh.geometry_base, last = first + mesh.geometry_count;
        const auto is_double_sided = [](const shared::Geometry& g) { return (g.flags & shared::kMaterialDoubleSided) != 0; };
        mesh.cull_by_flag = options.culling && std::none_of(first, last, is_double_sided);
        const bool any_hit_culls = options.culling && !mesh.cull_by_flag;
        std::vector<gpu::BlasGeometry> driver;
        for (auto g = first; g != last; ++g)
            driver.push_back({.positions = g->positions,
                              .vertex_count = g->vertex_count,
                              .indices = g->indices,
                              .triangle_count = g->triangle_count,
                              .opaque = (g->flags & shared::kAlphaModeMask) == shared::kAlphaOpaque && !(any_hit_culls && !is_double_sided(*g))});
        mesh.blas = gpu::AccelStruct::bottom(device, "accel/bottom", driver);
        frame.build_blas(mesh.blas, driver, {positions, indices});
    }
}

}  // namespace parhelion
