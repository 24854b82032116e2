#include "session/scene_info.h"

#include <nlohmann/json.hpp>

#include "session/scene_setup.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

std::string joined(const std::vector<std::string>& names) {
    std::string out;
    for (const std::string& name : names) out += (out.empty() ? "" : ", ") + escape_name(name);
    return out.empty() ? "none" : out;
}

Json vector_json(glm::vec3 v) { return {v.x, v.y, v.z}; }

}  // namespace

SceneInfo describe_scene(const std::string& name) {
    const LoadedScene loaded = load_scene_by_name(name);
    const Scene& scene = loaded.scene;
    SceneInfo info{.name = name, .source = scene.source()};
    info.meshes = scene.meshes().size();
    info.instances = scene.instances().size();
    info.nodes = scene.nodes().size();
    info.materials = scene.materials().size();
    info.textures = scene.textures().size();
    info.images = scene.images().size();
    info.lights = scene.lights().size();
    info.environment = !scene.environment().black();
    info.bounds = scene.bounds();
    for (const auto& [handle, mesh] : scene.meshes()) info.primitives += mesh.primitives.size(), info.triangles += mesh.triangle_count;
    for (const auto& [handle, instance] : scene.instances()) info.instanced_triangles += scene.get(instance.mesh).triangle_count;
    for (const auto& [handle, image] : scene.images()) info.image_bytes += image.rgba.size();
    for (const auto& [handle, material] : scene.materials()) info.emissive_materials += material.emission != glm::vec3(0.0f);
    for (const auto& [handle, camera] : scene.cameras()) info.cameras.push_back(camera.name);
    for (const ScriptedEdit& edit : loaded.scripted_edits) info.scripted_edits.emplace_back(edit.name, edit.help);
    return info;
}

Json scene_info_json(const SceneInfo& info) {
    Json edits = Json::array();
    for (const auto& [name, help] : info.scripted_edits) edits.push_back({{"name", name}, {"help", help}});
    const SceneSource& source = info.source;
    return {{"scene", info.name},
            {"generator", source.generator},
            {"copyright", source.copyright},
            {"file_bytes", source.file_bytes},
            {"triangles", info.triangles},
            {"instanced_triangles", info.instanced_triangles},
            {"meshes", info.meshes},
            {"primitives", info.primitives},
            {"instances", info.instances},
            {"nodes", info.nodes},
            {"materials", info.materials},
            {"emissive_materials", info.emissive_materials},
            {"textures", info.textures},
            {"images", info.images},
            {"image_bytes", info.image_bytes},
            {"lights", info.lights},
            {"environment", info.environment},
            {"cameras", info.cameras},
            {"bounds", info.bounds.empty() ? Json(nullptr) : Json{{"min", vector_json(info.bounds.min)}, {"max", vector_json(info.bounds.max)}}},
            {"extensions_used", source.extensions_used},
            {"extensions_required", source.extensions_required},
            {"extensions_not_drawn", source.extensions_not_drawn},
            {"animations", source.animation_count},
            {"skins", source.skin_count},
            {"morphed_meshes", source.morphed_mesh_count},
            {"scripted_edits", edits},
            {"warnings", source.warnings}};
}

std::string scene_info_text(const SceneInfo& info) {
    const SceneSource& source = info.source;
    std::string out = fmt::format("{}\n", escape_name(info.name));
    const auto row = [&](std::string_view name, const std::string& value) { out += fmt::format("  {:<14}{}\n", name, value); };
    if (!source.generator.empty()) row("made by", escape_name(source.generator));
    if (!source.copyright.empty()) row("copyright", escape_name(source.copyright));
    row("triangles", fmt::format("{} ({} in the file)", info.instanced_triangles, info.triangles));
    row("meshes", fmt::format("{} with {} primitives, {} instances, {} nodes", info.meshes, info.primitives, info.instances, info.nodes));
    row("materials", fmt::format("{}, {} of them emissive", info.materials, info.emissive_materials));
    row("textures", fmt::format("{} of {} images, {:.1f} MiB decoded", info.textures, info.images, static_cast<double>(info.image_bytes) / (1 << 20)));
    row("lights", fmt::format("{}{}", info.lights, info.environment ? " and an environment" : ""));
    row("cameras", joined(info.cameras));
    if (!info.bounds.empty()) {
        const glm::vec3 size = info.bounds.max - info.bounds.min;
        row("size", fmt::format("{:.3g} x {:.3g} x {:.3g} m", size.x, size.y, size.z));
    }
    if (!source.extensions_used.empty()) row("extensions", joined(source.extensions_used));
    if (!source.extensions_not_drawn.empty()) row("not drawn", joined(source.extensions_not_drawn));
    if (source.animation_count + source.skin_count + source.morphed_mesh_count > 0)
        row("motion", fmt::format("{} animations, {} skins, {} morphed meshes", source.animation_count, source.skin_count, source.morphed_mesh_count));
    for (const auto& [name, help] : info.scripted_edits) row("--animate", fmt::format("{}: {}", escape_name(name), help));
    for (const std::string& warning : source.warnings) row("warning", escape_name(warning));
    return out;
}

}  // namespace parhelion
