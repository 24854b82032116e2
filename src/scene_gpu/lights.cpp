// The top of the light table: emitters (emissive geometry of an instance, punctual light, environment) by their share of the emitted
// flux; and the environment's table. Motion remakes only the top.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <string_view>
#include <tuple>

#include "base/hash.h"
#include "scene/deform.h"
#include "scene/environment_flux.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;

float luminance(glm::vec3 c) { return glm::dot(c, glm::vec3(0.2126f, 0.7152f, 0.0722f)); }
float max_component(glm::vec3 c) { return std::max(c.x, std::max(c.y, c.z)); }

// Exact for angles as small as the sun's.
float one_minus_cos(float angle) {
    const double sine = std::sin(0.5 * double(angle));
    return static_cast<float>(2.0 * sine * sine);
}

// Sum of area x shown over the triangles in the world, square metres.
double world_flux(const Scene& scene, const Mesh& mesh, uint32_t geometry, const EmissiveTable& table, const glm::mat4& world) {
    const glm::dmat3 m{glm::mat3(world)}, gram = glm::transpose(m) * m;
    const double scale = (gram[0][0] + gram[1][1] + gram[2][2]) / 3;
    double skew = 0;
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) skew = std::max(skew, std::abs(gram[i][k] - (i == k ? scale : 0.0)));
    if (skew <= 1e-6 * scale) return scale * table.flux;  // all areas grow alike
    double flux = 0;
    Primitive storage;
    const Primitive& primitive = drawn_shape(scene, mesh, geometry, storage);
    for (size_t i = 0; i < primitive.triangles.size(); ++i) {
        const glm::uvec3& t = primitive.triangles[i];
        const glm::dvec3 a(primitive.positions[t.x]), b(primitive.positions[t.y]), c(primitive.positions[t.z]);
        flux += 0.5 * glm::length(glm::cross(m * (b - a), m * (c - a))) * (table.shown.empty() ? 1.0 : double(table.shown[i]));
    }
    return flux;
}

constexpr uint32_t kMaxTableWidth = 1024, kMaxTableHeight = 512;


}  // namespace

std::vector<uint32_t> translate_rows(std::span<const EmitterKey> before, std::span<const EmitterKey> now) {
    if (std::ranges::equal(before, now)) return {};
    std::map<EmitterKey, uint32_t> row_of;
    for (uint32_t row = 0; row < now.size(); ++row) row_of.emplace(now[row], row);
    std::vector<uint32_t> rows(before.size(), shared::kNone);
    bool same = true;
    for (uint32_t row = 0; row < before.size(); ++row) {
        if (const auto found = row_of.find(before[row]); found != row_of.end()) rows[row] = found->second;
        same = same && rows[row] == row;
    }
    if (same) rows.clear();
    return rows;
}

std::vector<float> lit_before(std::span<const EmitterLook> before, std::span<const EmitterLook> now, std::span<const uint32_t> rows_now) {
    std::vector<float> ratios(now.size(), 0.0f);
    for (uint32_t row = 0; row < before.size(); ++row) {
        const uint32_t there = rows_now.empty() ? row : rows_now[row];
        if (there != shared::kNone && now[there].radiance > 0 && now[there].place == before[row].place) ratios[there] = static_cast<float>(before[row].radiance / now[there].radiance);
    }
    if (std::ranges::all_of(ratios, [](float ratio) { return ratio == 1.0f; })) ratios.clear();
    return ratios;
}

double switched_share(EmitterShares before, EmitterShares now, std::span<const uint32_t> rows_now) {
    std::vector<bool> was_there(now.looks.size());
    double share = 0;
    for (uint32_t row = 0; row < before.looks.size(); ++row) {
        const uint32_t there = rows_now.empty() ? row : rows_now[row];
        if (there == shared::kNone) {
            share += before.shares[row];
            continue;
        }
        was_there[there] = true;
        const EmitterLook old = before.looks[row], look = now.looks[there];
        const bool moved = old.place != look.place && old.radiance > 0 && look.radiance > 0;
        if (moved || old.radiance == look.radiance) continue;
        share += look.radiance > old.radiance ? now.shares[there] * (1 - old.radiance / look.radiance) : before.shares[row] * (1 - look.radiance / old.radiance);
    }
    for (uint32_t row = 0; row < now.looks.size(); ++row)
        if (!was_there[row]) share += now.shares[row];
    return share;
}

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
    if (!e.radiance.empty()) {
        environment.table_width = std::min(e.width, kMaxTableWidth);
        environment.table_height = std::min(e.height, kMaxTableHeight);
    }
    const std::vector<double> flux = environment_flux(e, environment.table_width, environment.table_height);
    environment_luminance = std::accumulate(flux.begin(), flux.end(), 0.0) / (4.0 * kPi);
    std::vector<shared::AliasEntry> rows = make_alias_rows(flux);
    for (size_t i = 0; i < rows.size(); ++i)
        rows[i].pmf = static_cast<float>(rows[i].pmf / environment_cell_solid_angle(static_cast<uint32_t>(i / environment.table_width), environment.table_width, environment.table_height));
    environment_alias = make_table("environment_alias", std::move(rows));
}

namespace {

uint64_t hash_place(const Instance& instance, const shared::Material& material) {
    const Handle<Mesh> mesh = instance.drawn_mesh();  // of each pose another one
    const glm::mat4& place = instance.place.world_from_object;
    return Hasher{}.bytes(&place, sizeof place).add(mesh.index).add(mesh.generation).add(material.emissive_texture.texture).value();
}
uint64_t hash_place(const shared::Emitter& light) {
    Hasher hasher;
    hasher.bytes(&light.position_ws, sizeof light.position_ws).bytes(&light.direction_ws, sizeof light.direction_ws);
    return hasher.add(light.cos_inner).add(light.cos_outer).add(light.opening).add(light.kind).value();
}
uint64_t hash_place(const shared::Environment& e) { return Hasher{}.add(e.rotation_sin).add(e.rotation_cos).add(e.texture).value(); }

}  // namespace

// Rows of drawn instances that shine, by their nodes, which last, and not as they have come: so that the same random number means the same light, whatever was added
// and taken away before.
std::vector<uint32_t> SceneGpu::State::shining_instances() const {
    std::vector<std::tuple<uint32_t, uint32_t, uint32_t, uint32_t>> order;  // node, mesh, slot; row
    for (uint32_t row = 0; row < instances.size(); ++row) {
        if (!instance_handles[row]) continue;
        const auto shines = [&](uint32_t g) { return geometries[instances[row].geometry_base + g].triangle_table != shared::kNone; };
        bool any = false;
        for (uint32_t g = 0; g < instances[row].geometry_count; ++g) any = any || shines(g);
        if (!any) continue;
        const Instance& instance = scene->get(instance_handles[row]);
        order.emplace_back(instance.place.node.index, instance.mesh.index, instance_handles[row].index, row);
    }
    std::ranges::sort(order);
    std::vector<uint32_t> rows;
    for (const auto& entry : order) rows.push_back(std::get<3>(entry));
    return rows;
}

// The same of lights without a mesh, which may have a name of their own instead of a node.
std::vector<Handle<Light>> SceneGpu::State::shown_lights() const {
    std::vector<Handle<Light>> lights;
    for (const auto& [handle, light] : scene->lights())
        if (light.place.shown) lights.push_back(handle);
    std::ranges::sort(lights, {}, [&](Handle<Light> handle) {
        const Light& light = scene->get(handle);
        return std::tuple(light.place.node.index, std::string_view(light.name), handle.index);
    });
    return lights;
}

void SceneGpu::State::place_emitters() {
    emitters.clear();
    const std::vector<EmitterKey> keys_before = std::move(emitter_keys);
    const std::vector<EmitterLook> looks_before = std::move(emitter_looks);
    const std::vector<double> shares_before = std::move(emitter_shares);
    emitter_keys.clear();
    emitter_looks.clear();
    std::vector<double> finite, infinite;  // flux in lumen; irradiance in lux
    std::vector<uint32_t> finite_rows, infinite_rows;
    sun_rows.clear();
    const auto add = [&](const EmitterKey& key, const shared::Emitter& emitter, const EmitterLook& look, double weight, bool is_infinite) {
        emitter_looks.push_back(look);
        (is_infinite ? infinite : finite).push_back(weight);
        (is_infinite ? infinite_rows : finite_rows).push_back(static_cast<uint32_t>(emitters.size()));
        emitters.push_back(emitter);
        emitter_keys.push_back(key);
    };
    for (const uint32_t i : shining_instances()) {
        for (uint32_t g = 0; g < instances[i].geometry_count; ++g) {
            const uint32_t geometry = instances[i].geometry_base + g;
            if (geometries[geometry].triangle_table == shared::kNone) continue;
            const Instance& instance = scene->get(instance_handles[i]);
            const Mesh& mesh = scene->get(instance.drawn_mesh());
            const EmissiveTable& table = *emissive_table_of_geometry.at(geometry);
            const shared::Material& material = materials[geometries[geometry].material];
            const double strength = table.shown.empty() ? luminance(material.emission) : max_component(material.emission);
            const double sides = (material.flags & shared::kMaterialDoubleSided) != 0 ? 2.0 : 1.0;
            geometry_emitter_rows[instances[i].emitter_base + g] = static_cast<uint32_t>(emitters.size());
            add({kOfInstance, i, g, instance_handles[i].generation}, {.kind = shared::kEmitterMesh, .instance = i, .geometry = geometry, .triangle_count = geometries[geometry].triangle_count, .triangle_table = geometries[geometry].triangle_table},
                {strength, hash_place(instance, material)}, sides * kPi * strength * world_flux(*scene, mesh, g, table, instance.place.world_from_object), false);
        }
    }
    for (const Handle<Light> handle : shown_lights()) {
        const Light& light = scene->get(handle);
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
        add({kOfLight, handle.index, 0, handle.generation}, row, {luminance(intensity), hash_place(row)}, light.kind == LightKind::Directional ? luminance(intensity) : luminance(intensity) * solid_angle, light.kind == LightKind::Directional);
    }
    environment.emitter = shared::kNone;
    if (!scene->environment().black() && environment_luminance > 0) {
        environment.emitter = static_cast<uint32_t>(emitters.size());
        add({kOfEnvironment, 0, 0, 0}, {.kind = shared::kEmitterEnvironment}, {luminance(environment.scale) * environment_luminance, hash_place(environment)}, kPi * luminance(environment.scale) * environment_luminance, true);
    }

    // Infinite emitters have no flux to compare by: they get a set share, where both kinds shine.
    const double finite_total = std::accumulate(finite.begin(), finite.end(), 0.0), infinite_total = std::accumulate(infinite.begin(), infinite.end(), 0.0);
    const double share = finite_total <= 0 ? 1.0 : infinite_total <= 0 ? 0.0 : double(options.infinite_share);
    std::vector<double> weights(emitters.size());
    for (size_t k = 0; k < finite.size(); ++k) weights[finite_rows[k]] = finite_total > 0 ? (1 - share) * (finite[k] / finite_total) : 0;
    for (size_t k = 0; k < infinite.size(); ++k) weights[infinite_rows[k]] = infinite_total > 0 ? share * (infinite[k] / infinite_total) : 0;
    std::vector<shared::AliasEntry> rows = make_alias_rows(weights);
    emitter_shares = std::move(weights);
    emitter_table = make_table("emitters", std::span<const shared::Emitter>(emitters));
    emitter_alias = make_table("emitter_alias", std::move(rows));
    suns = make_table("suns", std::span<const uint32_t>(sun_rows));
    geometry_emitters = make_table("geometry_emitters", std::span<const uint32_t>(geometry_emitter_rows));
    stats.emitters = static_cast<uint32_t>(emitters.size());
    if (!anything_stale) return;  // the previous frame is still the same
    emitters_before = static_cast<uint32_t>(keys_before.size());
    emitter_translation = emitter_lit_before = {};
    std::vector<uint32_t> rows_now = translate_rows(keys_before, emitter_keys);
    constexpr double kMatters = 0.05;
    light_switched |= !has_no_past && switched_share({looks_before, shares_before}, {emitter_looks, emitter_shares}, rows_now) >= kMatters;
    if (std::vector<float> ratios = lit_before(looks_before, emitter_looks, rows_now); !has_no_past && !ratios.empty()) emitter_lit_before = make_table("emitter_lit_before", std::move(ratios));
    if (!rows_now.empty()) emitter_translation = make_table("emitter_now_of_before", std::move(rows_now));
}

}  // namespace parhelion
