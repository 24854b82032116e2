#include "scene/info.h"

#include <unordered_set>

#include "scene/animation.h"

namespace parhelion {

namespace {

uint64_t bytes_of_deformation(const Primitive& p) {
    uint64_t bytes = p.joints.size() * sizeof(uint16_t) + p.joint_weights.size() * sizeof(float);
    for (const MorphTarget& target : p.targets)
        bytes += (target.positions.size() + target.normals.size() + target.tangents.size()) * sizeof(glm::vec3);
    return bytes;
}

uint64_t bytes_of(const Primitive& p) {
    return p.positions.size() * sizeof(glm::vec3) + p.normals.size() * sizeof(glm::vec3) + p.tangents.size() * sizeof(glm::vec4) +
           (p.uv0.size() + p.uv1.size()) * sizeof(glm::vec2) + p.colors.size() * sizeof(glm::vec4) +
           p.triangles.size() * sizeof(glm::uvec3) + bytes_of_deformation(p);
}

void describe_geometry(const Scene& scene, SceneInfo& info) {
    std::unordered_set<Handle<Mesh>> posed;
    for (const auto& [handle, instance] : scene.instances())
        if (instance.posed) posed.insert(instance.posed);
    for (const auto& [handle, mesh] : scene.meshes()) {
        for (const Primitive& primitive : mesh.primitives) info.geometry_bytes += bytes_of(primitive);
        if (posed.contains(handle)) continue;
        ++info.meshes;
        info.primitives += mesh.primitives.size();
        info.triangles += mesh.triangle_count;
        for (const Primitive& primitive : mesh.primitives) info.vertices += primitive.positions.size();
    }
    for (const auto& [handle, instance] : scene.instances()) {
        const Mesh& mesh = scene.get(instance.drawn_mesh());
        info.instanced_triangles += mesh.triangle_count;
        for (const Primitive& primitive : scene.get(mesh.deformation ? mesh.rest : instance.drawn_mesh()).primitives) {
            const Material& material = scene.get(primitive.material);
            if (material.emission == glm::vec3(0.0f) || material.unlit) continue;
            ++info.emitters;
            info.emissive_triangles += primitive.triangles.size();
        }
    }
}

// Features of materials beyond the BSDF of shaders/lib/bsdf.glsl, and whether a material has them: not by what it names, but by
// what would be seen. Dispersion shows only where light passes through a body with thickness.
struct Feature {
    std::string_view name;
    bool (*used)(const Material& material);
};
constexpr Feature kNotDrawn[] = {
    {"dispersion", [](const Material& m) { return m.transmission > 0.0f && m.thickness > 0.0f && m.dispersion > 0.0f; }},
    {"anisotropy", [](const Material& m) { return m.anisotropy > 0.0f; }},
    {"iridescence", [](const Material& m) { return m.iridescence > 0.0f; }},
};

std::vector<NotDrawnRow> describe_not_drawn(const Scene& scene) {
    std::unordered_set<Handle<Material>> seen;
    for (const auto& [handle, instance] : scene.instances())
        for (const Primitive& primitive : scene.get(instance.drawn_mesh()).primitives) seen.insert(primitive.material);
    std::vector<NotDrawnRow> rows;
    for (const Feature& feature : kNotDrawn) {
        size_t materials = 0;
        for (const Handle<Material> handle : seen) {
            const Material& material = scene.get(handle);
            materials += !material.unlit && feature.used(material) ? 1 : 0;
        }
        if (materials != 0) rows.push_back({feature.name, materials});
    }
    return rows;
}

// One line of what the picture lacks: features of materials, then extensions that are not read at all.
std::string not_drawn_text(const SceneInfo& info) {
    std::string out;
    const auto add = [&](const std::string& text) { out += (out.empty() ? "" : ", ") + text; };
    for (const NotDrawnRow& row : info.not_drawn)
        add(fmt::format("{} ({} material{})", row.feature, row.materials, row.materials == 1 ? "" : "s"));
    for (const std::string& name : info.extensions_not_drawn) add(escape_name(name));
    return out;
}

void describe_animation(const Scene& scene, SceneInfo& info) {
    for (const auto& [handle, animation] : scene.animations())
        info.animations.push_back({animation.name, duration_of(animation), animation.channels.size()});
    for (const auto& [handle, skin] : scene.skins()) info.skins.push_back({skin.name, skin.joints.size()});
    for (const auto& [handle, mesh] : scene.meshes()) {
        if (mesh.primitives.empty() || mesh.primitives[0].targets.empty()) continue;
        std::vector<std::string> names = mesh.target_names;
        names.resize(mesh.primitives[0].targets.size());
        info.morphed_meshes.push_back({mesh.name, std::move(names)});
    }
}

std::string_view light_kind_name(LightKind kind) {
    return kind == LightKind::Directional ? "directional" : kind == LightKind::Point ? "point" : "spot";
}

std::string list(const std::vector<std::string>& names) {
    std::string out;
    for (const std::string& name : names) out += (out.empty() ? "" : ", ") + (name.empty() ? "(no name)" : escape_name(name));
    return out.empty() ? "none" : out;
}

std::string target_list(const MorphInfoRow& row) {
    std::vector<std::string> names;
    for (const std::string& name : row.targets)
        if (!name.empty()) names.push_back(name);
    const std::string count = fmt::format("{} targets", row.targets.size());
    return names.empty() ? count : fmt::format("{} ({})", count, list(names));
}

double mebibytes(uint64_t bytes) { return static_cast<double>(bytes) / 1048576.0; }

}  // namespace

SceneInfo describe(const LoadedScene& loaded) {
    const Scene& scene = loaded.scene;
    const SceneSource& source = scene.source();
    SceneInfo info{.name = source.name, .generator = source.generator, .copyright = source.copyright};
    info.nodes = scene.nodes().size();
    info.instances = scene.instances().size();
    info.materials = scene.materials().size();
    info.images = scene.images().size();
    describe_geometry(scene, info);
    for (const auto& [handle, image] : scene.images()) info.image_bytes += image.texels.size();
    for (const auto& [handle, texture] : scene.textures()) {
        const Image& image = scene.get(texture.image);
        info.textures.push_back({texture.name.empty() ? image.name : texture.name, image.width, image.height, texture.color_space});
    }
    for (const auto& [handle, light] : scene.lights()) info.lights.push_back({light.name, light.kind, light.color * light.intensity});
    for (const auto& [handle, camera] : scene.cameras()) info.cameras.push_back(camera.name);
    for (const ScriptedEdit& edit : loaded.scripted_edits) info.scripted_edits.push_back(edit.name + ": " + edit.help);
    info.environment = !scene.environment().black();
    describe_animation(scene, info);
    info.variants = source.variants;
    info.not_drawn = describe_not_drawn(scene);
    info.extensions_used = source.extensions_used;
    info.extensions_not_drawn = source.extensions_not_drawn;
    info.warnings = source.warnings;
    info.bounds = scene.bounds();
    info.file_bytes = source.file_bytes;
    return info;
}

std::string format_info(const SceneInfo& info) {
    std::string out = fmt::format("{}\n", escape_name(info.name));
    const auto line = [&](std::string_view label, const std::string& text) { out += fmt::format("  {:<12} {}\n", label, text); };
    if (!info.generator.empty()) line("generator", escape_name(info.generator));
    if (!info.copyright.empty()) line("copyright", escape_name(info.copyright));
    line("geometry", fmt::format("{} triangles and {} vertices in {} meshes ({} primitives)", info.triangles, info.vertices, info.meshes,
                                 info.primitives));
    line("placed", fmt::format("{} triangles in {} instances, {} nodes", info.instanced_triangles, info.instances, info.nodes));
    line("materials", fmt::format("{} with {} textures of {} images", info.materials, info.textures.size(), info.images));
    for (const TextureInfoRow& t : info.textures)
        line("",
             fmt::format("{}x{} {} '{}'", t.width, t.height, t.color_space == ColorSpace::Srgb ? "sRGB" : "linear", escape_name(t.name)));
    line("lights", fmt::format("{} emissive geometries with {} triangles, {} punctual, environment {}", info.emitters,
                               info.emissive_triangles, info.lights.size(), info.environment ? "yes" : "no"));
    for (const LightInfoRow& l : info.lights)
        line("", fmt::format("{} '{}' ({:g}, {:g}, {:g}) {}", light_kind_name(l.kind), escape_name(l.name), l.intensity.x, l.intensity.y,
                             l.intensity.z, l.kind == LightKind::Directional ? "lux" : "candela"));
    line("cameras", list(info.cameras));
    if (!info.variants.empty()) line("variants", list(info.variants));
    if (!info.scripted_edits.empty()) line("animate", list(info.scripted_edits));
    for (size_t i = 0; i < info.animations.size(); ++i)
        line(i == 0 ? "animations" : "", fmt::format("{} '{}': {:.3g} seconds, {} channels", i, escape_name(info.animations[i].name),
                                                     info.animations[i].seconds, info.animations[i].channels));
    for (size_t i = 0; i < info.skins.size(); ++i)
        line(i == 0 ? "skins" : "", fmt::format("'{}': {} joints", escape_name(info.skins[i].name), info.skins[i].joints));
    for (size_t i = 0; i < info.morphed_meshes.size(); ++i)
        line(i == 0 ? "morphs" : "", fmt::format("'{}': {}", escape_name(info.morphed_meshes[i].name), target_list(info.morphed_meshes[i])));
    if (!info.bounds.empty())
        line("bounds", fmt::format("({:g}, {:g}, {:g}) to ({:g}, {:g}, {:g}) metres", info.bounds.min.x, info.bounds.min.y,
                                   info.bounds.min.z, info.bounds.max.x, info.bounds.max.y, info.bounds.max.z));
    line("memory", fmt::format("{:.1f} MiB geometry, {:.1f} MiB images; files {:.1f} MiB", mebibytes(info.geometry_bytes),
                               mebibytes(info.image_bytes), mebibytes(info.file_bytes)));
    if (!info.extensions_used.empty()) line("extensions", list(info.extensions_used));
    if (const std::string text = not_drawn_text(info); !text.empty()) line("not drawn", text);
    for (const std::string& warning : info.warnings) line("warning", escape_name(warning, 400));
    return out;
}

}  // namespace parhelion
