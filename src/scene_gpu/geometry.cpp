// Meshes on the device: which ones, their arrays in shared buffers, and the table of geometries that refers to them.
#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

uint32_t pack_color(glm::vec4 color) {
    const glm::vec4 scaled = glm::clamp(color, glm::vec4(0.0f), glm::vec4(1.0f)) * 255.0f + 0.5f;
    return uint32_t(scaled.x) | uint32_t(scaled.y) << 8 | uint32_t(scaled.z) << 16 | uint32_t(scaled.w) << 24;
}

// Missing attributes: normals become zero (the surface then takes the triangle's own), colours white.
shared::VertexAttributes attributes_of(const Primitive& primitive, size_t i) {
    const auto at = [i](const auto& values, auto fallback) { return values.empty() ? fallback : values[i]; };
    return {.normal = at(primitive.normals, glm::vec3(0.0f)),
            .tangent = at(primitive.tangents, glm::vec4(0.0f)),
            .uv0 = at(primitive.uv0, glm::vec2(0.0f)),
            .uv1 = at(primitive.uv1, glm::vec2(0.0f)),
            .color = primitive.colors.empty() ? ~0u : pack_color(primitive.colors[i])};
}

RowSource attribute_rows(const BufferRange& to, const Primitive& primitive) {
    return {to.buffer, to.offset, sizeof(shared::VertexAttributes), primitive.positions.size(), [&primitive](std::byte* out, uint64_t first, uint64_t count) {
                for (uint64_t i = 0; i < count; ++i) {
                    const shared::VertexAttributes row = attributes_of(primitive, first + i);
                    std::memcpy(out + i * sizeof(row), &row, sizeof(row));
                }
            }};
}

uint64_t bytes_of(const Mesh& mesh) {
    uint64_t bytes = 0;
    for (const Primitive& p : mesh.primitives)
        bytes += uint64_t(p.positions.size()) * (sizeof(glm::vec3) + sizeof(shared::VertexAttributes)) + uint64_t(p.triangles.size()) * sizeof(glm::uvec3);
    return bytes;
}

// The rest of a range that begins with these rows.
template <class T>
BufferRange range_behind(const BufferRange& range, const std::vector<T>& rows) {
    const uint64_t bytes = rows.size() * sizeof(T);
    return {range.buffer, range.offset + bytes, range.bytes - bytes};
}

// By index of the handle: the meshes that some instance draws.
std::vector<bool> find_drawn(const Scene& scene) {
    std::vector<bool> drawn(scene.meshes().slot_count(), false);
    for (const auto& [handle, instance] : scene.instances()) {
        const uint32_t mesh = instance.drawn_mesh().index;
        if (!drawn[mesh] && can_be_seen(instance.place)) drawn[mesh] = true;
    }
    return drawn;
}

}  // namespace

std::vector<gpu::Buffer> SceneGpu::State::geometry_buffers() const {
    std::vector<gpu::Buffer> buffers = geometry_pool.buffers(), forms = form_pool.buffers();
    buffers.insert(buffers.end(), forms.begin(), forms.end());
    return buffers;
}

void SceneGpu::State::plan_meshes() {
    for (auto& [handle, mesh] : meshes) mesh.wanted = mesh.drawn = mesh.has_forms = mesh.has_made = false;
    wanted_meshes.clear();
    resident_meshes.clear();
    const std::vector<bool> drawn = find_drawn(*scene);
    uint64_t new_bytes = 0, new_form_bytes = 0, new_triangles = 0, new_nodes = 0;
    const auto want = [&](Handle<Mesh> handle, const Mesh& mesh) -> MeshOnDevice& {
        const auto [at, is_new] = meshes.try_emplace(handle);
        MeshOnDevice& on_device = at->second;
        on_device.wanted = true;
        if (!is_new) return on_device;
        on_device.rest = mesh.rest;
        on_device.made_here = mesh.deformation.has_value();
        on_device.bytes = bytes_of(mesh.deformation ? scene->get(mesh.rest) : mesh);
        on_device.triangle_count = mesh.triangle_count;
        const uint64_t traced = static_cast<uint64_t>(double(options.proxy_ratio) * double(mesh.triangle_count));  // about, as below
        if (uses_proxies()) on_device.bytes += traced * sizeof(glm::uvec3) + mesh.triangle_count * sizeof(uint32_t);
        (on_device.made_here ? new_form_bytes : new_bytes) += on_device.bytes + 64 * mesh.primitives.size();  // arrays are aligned
        new_triangles += traced;
        new_nodes += traced / (layout == bvh::Layout::Binary ? 2 : 5) + 1;  // about; more make the array grow
        return on_device;
    };
    for (const auto& [handle, mesh] : scene->meshes()) {
        if (!drawn[handle.index] || mesh.triangle_count == 0) continue;
        want(handle, mesh).drawn = true;
        wanted_meshes.push_back(handle);
        if (!mesh.rest) continue;
        MeshOnDevice& rest = want(mesh.rest, scene->get(mesh.rest));
        if (!rest.has_forms) resident_meshes.push_back(mesh.rest);
        rest.has_forms = true;
        rest.has_made |= mesh.deformation.has_value();
    }
    for (const Handle<Mesh> handle : wanted_meshes)
        if (!meshes.at(handle).has_forms) resident_meshes.push_back(handle);
    // What has never been seen may go at once.
    forget_meshes([](const MeshOnDevice& mesh) { return !mesh.wanted && mesh.drawn_at == 0; });
    if (new_bytes + new_form_bytes == 0) return;
    geometry_pool.expect(new_bytes);
    form_pool.expect(new_form_bytes);
    bottom_nodes.expect(new_nodes);
    bottom_triangles.expect(new_triangles);
}

// Room for what a geometry consists of.
PartOnDevice SceneGpu::State::take_part(const Primitive& p, const Proxy& proxy) {
    return {.positions = geometry_pool.take(p.positions.size() * sizeof(glm::vec3)),
            .indices = geometry_pool.take((p.triangles.size() + proxy.triangles.size()) * sizeof(glm::uvec3)),
            .attributes = geometry_pool.take(p.positions.size() * sizeof(shared::VertexAttributes)),
            .proxy_heights = proxy.heights.empty() ? BufferRange{} : geometry_pool.take(proxy.heights.size() * sizeof(uint32_t)),
            .vertex_count = static_cast<uint32_t>(p.positions.size()),
            .triangle_count = static_cast<uint32_t>(p.triangles.size()),
            .proxy_count = static_cast<uint32_t>(proxy.triangles.size())};
}

void SceneGpu::State::upload_meshes(Frame& frame, Slice& slice) {
    for (const Handle<Mesh> handle : resident_meshes) {
        MeshOnDevice& mesh = meshes.at(handle);
        if (mesh.uploaded || mesh.made_here || !needs_geometry(mesh)) continue;
        if (!slice.has_bytes() || (uses_proxies() && mesh.proxies.empty())) return;
        const Mesh& source = scene->get(handle);
        if (mesh.parts.empty()) {
            mesh.geometry_base = static_cast<uint32_t>(*geometry_rows.take(source.primitives.size()));
            for (size_t i = 0; i < source.primitives.size(); ++i) mesh.parts.push_back(take_part(source.primitives[i], uses_proxies() ? mesh.proxies[i] : Proxy{}));
        }
        std::vector<RowSource> rows;
        for (size_t i = 0; i < source.primitives.size(); ++i) {
            rows.push_back(array_rows(mesh.parts[i].positions, source.primitives[i].positions));
            rows.push_back(array_rows(mesh.parts[i].indices, source.primitives[i].triangles));
            rows.push_back(attribute_rows(mesh.parts[i].attributes, source.primitives[i]));
            if (mesh.parts[i].proxy_count > 0) {
                rows.push_back(array_rows(range_behind(mesh.parts[i].indices, source.primitives[i].triangles), mesh.proxies[i].triangles));
                rows.push_back(array_rows(mesh.parts[i].proxy_heights, mesh.proxies[i].heights));
            }
        }
        mesh.uploaded = upload_rows(frame, slice, rows, mesh.done_rows);
    }
}

// Rows of meshes that are gone but may still be seen in the previous frame stay as they are.
void SceneGpu::State::make_geometries() {
    std::vector<shared::Geometry> rows = geometries;
    stats.triangles = stats.traced_triangles = 0;
    features &= ~shared::kSceneProxies;
    for (const Handle<Mesh> handle : wanted_meshes) {
        const MeshOnDevice& mesh = meshes.at(handle);
        const Mesh& source = scene->get(handle);
        rows.resize(std::max<size_t>(rows.size(), mesh.geometry_base + mesh.parts.size()));
        for (size_t i = 0; i < mesh.parts.size(); ++i) {
            const PartOnDevice& part = mesh.parts[i];
            const uint32_t material = source.primitives[i].material.index;
            shared::Geometry& row = rows[mesh.geometry_base + i];
            row.positions = part.positions.address();
            row.indices = part.indices.address();
            row.attributes = part.attributes.address();
            row.proxy_heights = mesh.has_proxy(i) ? part.proxy_heights.address() : 0;
            if (mesh.has_proxy(i)) features |= shared::kSceneProxies;
            row.triangle_count = part.triangle_count;
            row.vertex_count = part.vertex_count;
            row.material = material;
            row.flags = materials[material].flags;
            const auto table = triangle_table_of_geometry.find(mesh.geometry_base + static_cast<uint32_t>(i));
            row.triangle_table = table == triangle_table_of_geometry.end() ? shared::kNone : table->second;
        }
        stats.triangles += mesh.triangle_count;
        stats.traced_triangles += mesh.traced_triangles();
    }
    stats.meshes = static_cast<uint32_t>(wanted_meshes.size());
    const bool same = rows.size() == geometries.size() && std::memcmp(rows.data(), geometries.data(), rows.size() * sizeof(shared::Geometry)) == 0;
    if (same && geometry_table) return;
    geometries = std::move(rows);
    geometry_table = make_table("geometries", std::span<const shared::Geometry>(geometries));
}

// All that a mesh takes of what the scene shares.
void SceneGpu::State::give_back(const MeshOnDevice& mesh) {
    BufferPool& pool = mesh.made_here ? form_pool : geometry_pool;
    for (const PartOnDevice& part : mesh.parts) {
        pool.give(part.positions);
        pool.give(part.attributes);
        pool.give(part.proxy_heights);
        if (!mesh.made_here) pool.give(part.indices);
    }
    for (const DeformersOnDevice& deformers : mesh.deformers) {
        deformer_pool.give(deformers.influences);
        for (const std::array<BufferRange, 3>& target : deformers.targets)
            for (const BufferRange& range : target) deformer_pool.give(range);
    }
    geometry_rows.give(mesh.geometry_base, mesh.parts.size());
    bottom_nodes.give(mesh.own_nodes, mesh.own_node_count);
    bottom_triangles.give(mesh.own_triangles, mesh.own_triangle_count);
    plan_nodes.give(mesh.plan.nodes, mesh.plan.node_count);
    plan_triangles.give(mesh.plan.triangles, mesh.plan.triangle_count);
}

void SceneGpu::State::forget_meshes(const std::function<bool(const MeshOnDevice&)>& choose) {
    for (auto at = meshes.begin(); at != meshes.end();) {
        if (!choose(at->second)) {
            ++at;
            continue;
        }
        give_back(at->second);
        at = meshes.erase(at);
    }
}

// What neither the present nor the previous top level shows any more.
void SceneGpu::State::forget_unwanted() {
    forget_meshes([&](const MeshOnDevice& mesh) { return !mesh.wanted && mesh.drawn_at + 1 < published; });
    std::erase_if(images, [](const auto& item) { return !item.second.wanted; });
    forget_retired();
}

}  // namespace parhelion
