// The light tables. Two levels: emitters (emissive geometry of an instance, punctual light, environment) by their share of the
// emitted flux, and per emissive geometry its triangles by area in object space. Motion remakes only the top.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "base/error.h"
#include "sampling/alias_table.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;

float luminance(glm::vec3 c) { return glm::dot(c, glm::vec3(0.2126f, 0.7152f, 0.0722f)); }

// Rows for the device, appended to `out`. All-zero weights become equal ones: a table must return something.
void append_alias_rows(std::span<const double> weights, std::vector<shared::AliasEntry>& out) {
    const std::vector<double> equal(weights.size(), 1.0);
    const bool nothing = std::all_of(weights.begin(), weights.end(), [](double w) { return w <= 0; });
    const sampling::AliasTable table(nothing ? std::span<const double>(equal) : weights);
    for (size_t i = 0; i < weights.size(); ++i) out.push_back({table.entries()[i].probability, table.entries()[i].alias, table.pmf()[i]});
}

// Exact for angles as small as the sun's.
float one_minus_cos(float angle) {
    const double sine = std::sin(0.5 * double(angle));
    return static_cast<float>(2.0 * sine * sine);
}

glm::vec3 world_point(const glm::mat4& world, glm::vec3 p) { return glm::vec3(world * glm::vec4(p, 1.0f)); }

double world_area(const Primitive& primitive, const glm::mat4& world) {
    double area = 0;
    for (const glm::uvec3& t : primitive.triangles) {
        const glm::vec3 a = world_point(world, primitive.positions[t.x]), b = world_point(world, primitive.positions[t.y]), c = world_point(world, primitive.positions[t.z]);
        area += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    return area;
}

// Mean of the bilinearly filtered luminance over each texel: the 3x3 kernel (1 6 1)/8 in both directions. Positive wherever the
// filtered radiance is, so no direction that shines has density zero.
std::vector<float> filtered_luminance(const Environment& e) {
    std::vector<float> out(e.radiance.size());
    const auto at = [&](int x, int y) {
        x = (x + int(e.width)) % int(e.width);
        y = std::clamp(y, 0, int(e.height) - 1);
        return luminance(e.radiance[size_t(y) * e.width + x]);
    };
    static constexpr float kWeights[3] = {0.125f, 0.75f, 0.125f};
    for (int y = 0; y < int(e.height); ++y)
        for (int x = 0; x < int(e.width); ++x) {
            float sum = 0;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx) sum += kWeights[dx + 1] * kWeights[dy + 1] * at(x + dx, y + dy);
            out[size_t(y) * e.width + x] = sum;
        }
    return out;
}

constexpr uint32_t kMaxTableWidth = 1024, kMaxTableHeight = 512;

}  // namespace

void SceneGpu::State::make_environment() {
    if (!environment_table_stale) return;
    const Environment& e = scene->environment();
    environment = {.scale = e.scale,
                   .texture = shared::kNone,
                   .rotation_sin = std::sin(e.rotation),
                   .rotation_cos = std::cos(e.rotation),
                   .table_width = 1,
                   .table_height = 1,
                   .emitter = shared::kNone};
    environment_flux = 1.0f;  // mean luminance of the map over the sphere
    std::vector<double> weights(1, 1.0);
    if (!e.radiance.empty()) {
        environment.table_width = std::min(e.width, kMaxTableWidth);
        environment.table_height = std::min(e.height, kMaxTableHeight);
        weights.assign(size_t(environment.table_width) * environment.table_height, 0.0);
        const std::vector<float> lum = filtered_luminance(e);
        for (uint32_t y = 0; y < e.height; ++y) {
            const double solid_angle = 2.0 * kPi / e.width * (std::cos(kPi * y / double(e.height)) - std::cos(kPi * (y + 1) / double(e.height)));
            const uint32_t row = uint32_t(uint64_t(y) * environment.table_height / e.height);
            for (uint32_t x = 0; x < e.width; ++x)
                weights[size_t(row) * environment.table_width + uint64_t(x) * environment.table_width / e.width] += solid_angle * lum[size_t(y) * e.width + x];
        }
        environment_flux = static_cast<float>(std::accumulate(weights.begin(), weights.end(), 0.0) / (4.0 * kPi));
    }
    std::vector<shared::AliasEntry> rows;
    append_alias_rows(weights, rows);
    environment_alias = make_table("environment_alias", std::move(rows));
}

// Object-space areas: they depend on nothing but which geometries emit.
void SceneGpu::State::make_triangle_tables() {
    std::vector<std::pair<Handle<Mesh>, uint32_t>> parts;
    for (const Handle<Mesh> handle : wanted_meshes) {
        const Mesh& mesh = scene->get(handle);
        for (uint32_t g = 0; g < mesh.primitives.size(); ++g) {
            const shared::Material& material = materials[mesh.primitives[g].material.index];
            if (!mesh.primitives[g].triangles.empty() && material.emission != glm::vec3(0.0f) && (material.flags & shared::kMaterialUnlit) == 0) parts.emplace_back(handle, g);
        }
    }
    if (triangle_alias && parts == emissive_parts) return;
    emissive_parts = std::move(parts);
    triangle_table_of_geometry.clear();
    std::vector<shared::AliasEntry> rows;
    for (const auto& [handle, g] : emissive_parts) {
        const Primitive& primitive = scene->get(handle).primitives[g];
        std::vector<double> areas;
        areas.reserve(primitive.triangles.size());
        for (const glm::uvec3& t : primitive.triangles)
            areas.push_back(0.5 * glm::length(glm::cross(primitive.positions[t.y] - primitive.positions[t.x], primitive.positions[t.z] - primitive.positions[t.x])));
        triangle_table_of_geometry[meshes.at(handle).geometry_base + g] = static_cast<uint32_t>(rows.size());
        append_alias_rows(areas, rows);
    }
    stats.emissive_triangles = rows.size();
    triangle_alias = make_table("triangle_alias", std::move(rows));
}

void SceneGpu::State::place_emitters() {
    emitters.clear();
    std::vector<double> finite, infinite;  // flux in lumen; irradiance in lux
    std::vector<uint32_t> finite_rows, infinite_rows;
    sun_rows.clear();
    const auto add = [&](const shared::Emitter& emitter, double weight, bool is_infinite) {
        (is_infinite ? infinite : finite).push_back(weight);
        (is_infinite ? infinite_rows : finite_rows).push_back(static_cast<uint32_t>(emitters.size()));
        emitters.push_back(emitter);
    };
    for (uint32_t i = 0; i < instances.size(); ++i) {
        if (!instance_handles[i]) continue;
        const Instance& instance = scene->get(instance_handles[i]);
        const Mesh& mesh = scene->get(instance.drawn_mesh());
        for (uint32_t g = 0; g < instances[i].geometry_count; ++g) {
            const uint32_t geometry = instances[i].geometry_base + g;
            const auto table = triangle_table_of_geometry.find(geometry);
            if (table == triangle_table_of_geometry.end()) continue;
            const shared::Material& material = materials[geometries[geometry].material];
            const double sides = (material.flags & shared::kMaterialDoubleSided) != 0 ? 2.0 : 1.0;
            geometry_emitter_rows[instances[i].emitter_base + g] = static_cast<uint32_t>(emitters.size());
            add({.kind = shared::kEmitterMesh, .instance = i, .geometry = geometry, .triangle_count = geometries[geometry].triangle_count, .triangle_table = table->second},
                sides * kPi * luminance(material.emission) * world_area(mesh.primitives[g], instance.place.world_from_object), false);
        }
    }
    for (const auto& [handle, light] : scene->lights()) {
        const glm::mat4& world = light.place.world_from_object;
        const glm::vec3 intensity = light.color * light.intensity;
        shared::Emitter row{.kind = light.kind == LightKind::Directional ? shared::kEmitterDirectional : light.kind == LightKind::Spot ? shared::kEmitterSpot : shared::kEmitterPoint,
                            .position_ws = glm::vec3(world[3]),
                            .direction_ws = glm::normalize(-glm::vec3(world[2])),
                            .intensity = intensity,
                            .cos_inner = std::cos(light.inner_cone),
                            .cos_outer = std::cos(light.outer_cone),
                            .opening = one_minus_cos(light.kind == LightKind::Directional ? light.angular_radius : 0.0f)};
        if (row.opening > 0.0f) sun_rows.push_back(static_cast<uint32_t>(emitters.size()));
        const double solid_angle = light.kind == LightKind::Spot ? 2 * kPi * (1 - row.cos_outer) : 4 * kPi;
        add(row, light.kind == LightKind::Directional ? luminance(intensity) : luminance(intensity) * solid_angle, light.kind == LightKind::Directional);
    }
    environment.emitter = shared::kNone;
    if (!scene->environment().black()) {
        environment.emitter = static_cast<uint32_t>(emitters.size());
        add({.kind = shared::kEmitterEnvironment}, kPi * luminance(environment.scale) * environment_flux, true);
    }

    // Infinite emitters have no flux to compare by: they get a set share.
    const double finite_total = std::accumulate(finite.begin(), finite.end(), 0.0), infinite_total = std::accumulate(infinite.begin(), infinite.end(), 0.0);
    const double share = finite.empty() ? 1.0 : infinite.empty() ? 0.0 : double(options.infinite_share);
    std::vector<double> weights(emitters.size());
    for (size_t k = 0; k < finite.size(); ++k) weights[finite_rows[k]] = (1 - share) * (finite_total > 0 ? finite[k] / finite_total : 1.0 / double(finite.size()));
    for (size_t k = 0; k < infinite.size(); ++k) weights[infinite_rows[k]] = share * (infinite_total > 0 ? infinite[k] / infinite_total : 1.0 / double(infinite.size()));
    std::vector<shared::AliasEntry> rows;
    append_alias_rows(weights, rows);
    emitter_table = make_table("emitters", std::span<const shared::Emitter>(emitters));
    emitter_alias = make_table("emitter_alias", std::move(rows));
    suns = make_table("suns", std::span<const uint32_t>(sun_rows));
    geometry_emitters = make_table("geometry_emitters", std::span<const uint32_t>(geometry_emitter_rows));
    stats.emitters = static_cast<uint32_t>(emitters.size());
}

}  // namespace parhelion
