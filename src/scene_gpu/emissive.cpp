// The lower level of the light table: of each emissive geometry its triangles, by the light that they give off in object space. It
// depends on the mesh and on the emission's colour and texture; neither motion nor brightness remakes it. A deformed form has its own, by the
// areas that its triangles have now, made on the host of its emissive geometries alone.
#include <algorithm>
#include <map>

#include "sampling/alias_table.h"
#include "scene/deform.h"
#include "scene/shown_texture.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

std::shared_ptr<const EmissiveTable> make_emissive_table(const Primitive& primitive, std::vector<float> shown) {
    auto table = std::make_shared<EmissiveTable>();
    std::vector<double> weights(primitive.triangles.size());
    for (size_t i = 0; i < weights.size(); ++i) {
        const glm::uvec3& t = primitive.triangles[i];
        const glm::dvec3 a(primitive.positions[t.x]), b(primitive.positions[t.y]), c(primitive.positions[t.z]);
        weights[i] = 0.5 * glm::length(glm::cross(b - a, c - a)) * (shown.empty() ? 1.0 : double(shown[i]));
        table->flux += weights[i];
    }
    if (!(table->flux > 0)) return nullptr;
    table->rows = make_alias_rows(weights);
    table->shown = std::move(shown);
    return table;
}

}  // namespace

std::vector<shared::AliasEntry> make_alias_rows(std::span<const double> weights) {
    const std::vector<double> equal(weights.size(), 1.0);
    const bool nothing = std::all_of(weights.begin(), weights.end(), [](double w) { return w <= 0; });
    const sampling::AliasTable table(nothing ? std::span<const double>(equal) : weights, "light table");
    std::vector<shared::AliasEntry> rows(weights.size());
    for (size_t i = 0; i < rows.size(); ++i) rows[i] = {table.entries()[i].probability, table.entries()[i].alias, table.pmf()[i]};
    return rows;
}

bool EmissivePart::same_look(const EmissivePart& other) const {
    if (rest != other.rest || primitive != other.primitive || texture != other.texture) return false;
    const glm::vec3 away = glm::abs(tint - other.tint);  // the same colour in another brightness differs by rounding
    return !texture || (ref.uv_set == other.ref.uv_set && ref.row0 == other.ref.row0 && ref.row1 == other.ref.row1 && std::max({away.x, away.y, away.z}) < 1e-5f);
}

std::vector<EmissivePart> SceneGpu::State::find_emissive_parts() const {
    std::vector<EmissivePart> parts;
    for (const Handle<Mesh> handle : wanted_meshes) {
        const Mesh& mesh = scene->get(handle);
        for (uint32_t g = 0; g < mesh.primitives.size(); ++g) {
            const Material& material = scene->get(mesh.primitives[g].material);
            if (meshes.at(handle).parts[g].triangle_count == 0 || material.emission == glm::vec3(0.0f) || material.unlit) continue;
            EmissivePart& part = parts.emplace_back(EmissivePart{.mesh = handle, .rest = mesh.rest ? mesh.rest : handle, .primitive = g, .texture = material.emissive_texture.texture});
            if (!part.texture) continue;
            part.ref = materials[mesh.primitives[g].material.index].emissive_texture;
            part.tint = material.emission / std::max({material.emission.x, material.emission.y, material.emission.z});
        }
    }
    return parts;
}

void SceneGpu::State::make_triangle_tables() {
    std::vector<EmissivePart> parts = find_emissive_parts();
    if (triangle_alias && std::ranges::equal(parts, emissive_parts, [](const EmissivePart& a, const EmissivePart& b) { return a.mesh == b.mesh && a.same_look(b); })) return;

    std::map<std::pair<uint64_t, uint32_t>, const EmissivePart*> known;
    const auto key = [](const EmissivePart& part) { return std::pair(uint64_t(part.mesh.generation) << 32 | part.mesh.index, part.primitive); };
    for (const EmissivePart& part : emissive_parts) known[key(part)] = &part;
    std::vector<EmissivePart*> missing;
    for (EmissivePart& part : parts) {
        const auto found = known.find(key(part));
        if (found != known.end() && part.same_look(*found->second)) {
            part.table = found->second->table;
            continue;
        }
        // A form shows what others of its mesh show, on triangles of other sizes.
        const auto alike = std::ranges::find_if(emissive_parts, [&](const EmissivePart& other) { return other.table && part.same_look(other); });
        if (alike == emissive_parts.end()) {
            missing.push_back(&part);
            continue;
        }
        Primitive storage;
        part.table = make_emissive_table(drawn_shape(*scene, scene->get(part.mesh), part.primitive, storage), alike->table->shown);
    }
    // Material by material, so that one unpacked texture at a time is held.
    const auto material_of = [&](const EmissivePart* part) { return scene->get(part->mesh).primitives[part->primitive].material; };
    std::ranges::stable_sort(missing, {}, [&](const EmissivePart* part) { return material_of(part).index; });
    std::unique_ptr<ShownTexture> texture;
    Handle<Material> texture_of;
    for (EmissivePart* part : missing) {
        Primitive storage;
        const Primitive& primitive = drawn_shape(*scene, scene->get(part->mesh), part->primitive, storage);
        std::vector<float> shown;
        if (part->texture) {
            const Texture& source = scene->get(part->texture);
            if (!texture || texture_of != primitive.material) {
                texture.reset();
                texture = std::make_unique<ShownTexture>(scene->get(source.image), source, part->tint);
                texture_of = primitive.material;
            }
            shown = texture->means(primitive, scene->get(primitive.material).emissive_texture);
        }
        part->table = make_emissive_table(primitive, std::move(shown));
    }
    emissive_parts = std::move(parts);

    triangle_table_of_geometry.clear();
    emissive_table_of_geometry.clear();
    std::vector<shared::AliasEntry> rows;
    for (const EmissivePart& part : emissive_parts) {
        if (!part.table) continue;
        const uint32_t geometry = meshes.at(part.mesh).geometry_base + part.primitive;
        triangle_table_of_geometry[geometry] = static_cast<uint32_t>(rows.size());
        emissive_table_of_geometry[geometry] = part.table;
        rows.insert(rows.end(), part.table->rows.begin(), part.table->rows.end());
    }
    stats.emissive_triangles = rows.size();
    triangle_alias = make_table("triangle_alias", std::move(rows));
}

}  // namespace parhelion
