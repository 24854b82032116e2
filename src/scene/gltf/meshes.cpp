#include "scene/gltf/meshes.h"

#include <cmath>
#include <numeric>

#include "scene/gltf/accessors.h"
#include "scene/gltf/draco.h"
#include "scene/gltf/quantization.h"
#include "scene/gltf/skins.h"
#include "scene/gltf/variants.h"
#include "scene/median_order.h"
#include "scene/tangents.h"

namespace parhelion {

namespace {

enum class Topology { Points, Lines, LineLoop, LineStrip, Triangles, Strip, Fan };

std::optional<uint32_t> material_of(const JsonRef& primitive) {
    const std::optional<JsonRef> material = primitive.find("material");
    if (!material) return std::nullopt;
    return material->as_index_of("materials");
}

// Triangles of a list, strip or fan over `count` corners; corner(i) is a vertex number. Those that name a vertex twice (strips
// are joined that way) have no area and are dropped. Orders as in glTF 2.0, 3.7.2.1.
template <class Corner>
std::vector<glm::uvec3> assemble(Topology mode, uint64_t count, Corner&& corner) {
    std::vector<glm::uvec3> out;
    const auto add = [&](uint64_t a, uint64_t b, uint64_t c) {
        const glm::uvec3 t(corner(a), corner(b), corner(c));
        if (t.x != t.y && t.y != t.z && t.z != t.x) out.push_back(t);
    };
    if (mode == Topology::Triangles) {
        out.reserve(count / 3);
        for (uint64_t i = 0; i + 2 < count; i += 3) add(i, i + 1, i + 2);
    } else {
        out.reserve(count > 2 ? count - 2 : 0);
        for (uint64_t i = 0; i + 2 < count; ++i)
            if (mode == Topology::Strip)
                add(i, i + 1 + i % 2, i + 2 - i % 2);
            else
                add(i + 1, i + 2, 0);
    }
    return out;
}

template <class V>
void require_count(const JsonRef& attribute, const std::vector<V>& values, size_t vertex_count) {
    if (values.size() != vertex_count)
        attribute.fail(fmt::format("has {} elements, but there are {} positions", values.size(), vertex_count));
}

void check_reach(const JsonRef& use, const std::vector<glm::vec3>& positions) {
    for (size_t i = 0; i < positions.size(); ++i)
        for (int axis = 0; axis < 3; ++axis)
            if (!(std::abs(positions[i][axis]) <= kLargestCoordinate))
                use.fail(fmt::format("position {} is beyond {:g} metres", i, kLargestCoordinate), "the file is damaged: export it again");
}

void read_normals(GltfDocument& document, const JsonRef& attributes, Primitive& out) {
    const std::optional<JsonRef> use = attributes.find("NORMAL");
    if (!use) return;
    warn_of_layout(document, *use, "NORMAL");
    out.normals = read_vectors<3>(document, *use);
    require_count(*use, out.normals, out.positions.size());
    size_t zero_count = 0;
    for (glm::vec3& n : out.normals) {
        const double length = glm::length(glm::dvec3(n));
        if (is_unit(length)) continue;
        n = length > 0.0 ? glm::vec3(glm::dvec3(n) / length) : glm::vec3(0.0f);
        if (!(length > 0.0)) ++zero_count;
    }
    if (zero_count != 0) document.warn(*use, fmt::format("{} normals have no length", zero_count));
}

void read_tangents(GltfDocument& document, const JsonRef& attributes, Primitive& out) {
    const std::optional<JsonRef> use = attributes.find("TANGENT");
    if (!use || out.normals.empty()) return;  // glTF 2.0, 3.7.2.1: without normals, tangents are ignored
    warn_of_layout(document, *use, "TANGENT");
    out.tangents = read_vectors<4>(document, *use);
    require_count(*use, out.tangents, out.positions.size());
    for (glm::vec4& t : out.tangents) {
        const double length = glm::length(glm::dvec3(t));
        if (is_unit(length) && std::abs(t.w) == 1.0f) continue;
        t = glm::vec4(length > 0.0 ? glm::vec3(glm::dvec3(t) / length) : glm::vec3(0.0f), t.w < 0.0f ? -1.0f : 1.0f);
    }
}

void read_uvs(GltfDocument& document, const JsonRef& attributes, std::string_view name, std::vector<glm::vec2>& uvs, size_t vertex_count) {
    const std::optional<JsonRef> use = attributes.find(name);
    if (!use) return;
    warn_of_layout(document, *use, name);
    uvs = read_vectors<2>(document, *use);
    require_count(*use, uvs, vertex_count);
}

void read_attributes(GltfDocument& document, const JsonRef& attributes, Primitive& out) {
    read_normals(document, attributes, out);
    read_tangents(document, attributes, out);
    read_uvs(document, attributes, "TEXCOORD_0", out.uv0, out.positions.size());
    read_uvs(document, attributes, "TEXCOORD_1", out.uv1, out.positions.size());
    if (const std::optional<JsonRef> colors = attributes.find("COLOR_0")) {
        warn_of_layout(document, *colors, "COLOR_0");
        out.colors = read_colors(document, *colors);
        require_count(*colors, out.colors, out.positions.size());
    }
}

// What the file leaves out and the normal map needs. A mesh without normals stays without, where nothing asks for them: its
// triangles are flat as they are.
void finish_attributes(GltfDocument& document, const JsonRef& json, Primitive& primitive, uint32_t normal_uv_set) {
    const bool flat = primitive.normals.empty();
    if (flat) {
        document.files().charge(primitive.triangles.size() * 3 * (72 + deformation_bytes(primitive)), json.where());
        unshare_with_flat_normals(primitive);
    }
    if (!primitive.tangents.empty()) return;
    if ((normal_uv_set == 0 ? primitive.uv0 : primitive.uv1).empty()) {
        document.warn(json, fmt::format("has a normal map, but no TEXCOORD_{} for it", normal_uv_set));
        return;
    }
    document.files().charge(primitive.triangles.size() * (64 + deformation_bytes(primitive)), json.where());
    generate_tangents(primitive, normal_uv_set);
    if (flat && deforms(primitive)) primitive.normals.clear();  // what deforms stays flat (glTF 2.0, 3.7.2.2)
}

// Its materials, and what the normal map of any of them needs (the one that is shown is asked first).
void dress(GltfDocument& document, const JsonRef& json, const MaterialHandles& materials, const MeshOptions& options, Primitive& primitive) {
    std::optional<uint32_t> shown = material_of(json);
    const std::vector<std::optional<uint32_t>> by_variant = materials_by_variant(document, json, options.variant_count);
    for (const std::optional<uint32_t>& material : by_variant)
        primitive.variant_materials.push_back(material ? materials.at(material) : Handle<Material>{});
    if (options.variant && !by_variant.empty() && by_variant[*options.variant]) shown = by_variant[*options.variant];
    primitive.material = materials.at(shown);

    uint32_t normal_uv_set = 0;
    bool normal_mapped = has_normal_map(document, shown, normal_uv_set);
    for (const uint32_t material : mapped_materials(json)) normal_mapped = normal_mapped || has_normal_map(document, material, normal_uv_set);
    if (normal_mapped) finish_attributes(document, json, primitive, normal_uv_set);
}

bool read_triangles(GltfDocument& document, const JsonRef& json, Primitive& out) {
    const uint64_t number = json.uint("mode", 4, 6);
    const Topology mode = static_cast<Topology>(number);
    if (number < 4) {
        document.warn(json, "points and lines are not drawn");
        return false;
    }
    const size_t vertex_count = out.positions.size();
    uint64_t corner_count = vertex_count;
    const std::optional<JsonRef> indices_ref = json.find("indices");
    const std::vector<uint32_t> indices = indices_ref ? read_indices(document, *indices_ref, vertex_count) : std::vector<uint32_t>{};
    if (indices_ref) corner_count = indices.size();
    if (corner_count < 3 || (mode == Topology::Triangles && corner_count % 3 != 0))
        document.warn(json, fmt::format("{} corners do not make whole triangles", corner_count));
    // With what order_triangles_by_median needs for a moment.
    constexpr uint64_t kBytesPerTriangle = 2 * sizeof(glm::uvec3) + 16;
    document.files().charge((mode == Topology::Triangles ? corner_count / 3 : corner_count) * kBytesPerTriangle, json.where());
    out.triangles = indices_ref ? assemble(mode, corner_count, [&](uint64_t i) { return indices[i]; })
                                : assemble(mode, corner_count, [](uint64_t i) { return static_cast<uint32_t>(i); });
    return !out.triangles.empty();
}

// Positions and triangles. Compressed accessors are at hand from here to the next primitive.
bool read_geometry(GltfDocument& document, const JsonRef& json, const JsonRef& positions, Primitive& out) {
    std::optional<DracoGeometry> compressed;
    if (const std::optional<JsonRef> draco = json.extension("KHR_draco_mesh_compression"))
        compressed = decode_draco(document, json, *draco);
    document.set_decoded(compressed ? std::move(compressed->accessors) : GltfDocument::DecodedAccessors{});
    warn_of_layout(document, positions, "POSITION");
    out.positions = read_vectors<3>(document, positions);
    check_reach(positions, out.positions);
    if (!compressed) return read_triangles(document, json, out);
    out.triangles = std::move(compressed->triangles);
    return !out.triangles.empty();
}

}  // namespace

std::set<std::optional<uint32_t>> materials_of(const JsonRef& mesh) {
    std::set<std::optional<uint32_t>> out;
    const JsonRef primitives = mesh.at("primitives");
    for (size_t i = 0; i < primitives.size(); ++i) {
        out.insert(material_of(primitives[i]));
        for (const uint32_t material : mapped_materials(primitives[i])) out.insert(material);
    }
    return out;
}

Mesh read_mesh(GltfDocument& document, const JsonRef& json, const MaterialHandles& materials, const MeshOptions& options) {
    Mesh mesh;
    mesh.name = json.string("name");
    const JsonRef primitives = json.at("primitives");
    if (primitives.size() == 0) primitives.fail("is empty");
    for (size_t i = 0; i < primitives.size(); ++i) {
        const JsonRef primitive_json = primitives[i];
        const JsonRef attributes = primitive_json.at("attributes");
        const std::optional<JsonRef> positions = attributes.find("POSITION");
        if (!positions) {
            document.warn(primitive_json, "has no POSITION and is left out");
            continue;
        }
        Primitive primitive;
        if (!read_geometry(document, primitive_json, *positions, primitive)) continue;
        read_attributes(document, attributes, primitive);
        read_influences(document, attributes, primitive);
        read_targets(document, primitive_json, primitive);
        dress(document, primitive_json, materials, options, primitive);
        if (options.median_order) order_triangles_by_median(primitive);
        mesh.primitives.push_back(std::move(primitive));
    }
    read_target_list(document, json, mesh);
    document.set_decoded({});
    return mesh;
}

}  // namespace parhelion
