#include "session/info_json.h"

#include <nlohmann/json.hpp>

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

Json vector_json(glm::vec3 v) { return {v.x, v.y, v.z}; }

Json textures_json(const SceneInfo& info) {
    Json list = Json::array();
    for (const TextureInfoRow& row : info.textures)
        list.push_back({{"name", row.name},
                        {"size", {row.width, row.height}},
                        {"color_space", row.color_space == ColorSpace::Srgb ? "srgb" : "linear"}});
    return list;
}

Json not_drawn_json(const SceneInfo& info) {
    Json list = Json::array();
    for (const NotDrawnRow& row : info.not_drawn) list.push_back({{"feature", row.feature}, {"materials", row.materials}});
    return list;
}

Json lights_json(const SceneInfo& info) {
    Json list = Json::array();
    for (const LightInfoRow& row : info.lights) {
        const char* kind = row.kind == LightKind::Directional ? "directional" : row.kind == LightKind::Point ? "point" : "spot";
        list.push_back({{"name", row.name}, {"kind", kind}, {"intensity", vector_json(row.intensity)}});
    }
    return list;
}

Json animations_json(const SceneInfo& info) {
    Json list = Json::array();
    for (const AnimationInfoRow& row : info.animations)
        list.push_back({{"name", row.name}, {"seconds", row.seconds}, {"channels", row.channels}});
    return list;
}

Json skins_json(const SceneInfo& info) {
    Json list = Json::array();
    for (const SkinInfoRow& row : info.skins) list.push_back({{"name", row.name}, {"joints", row.joints}});
    return list;
}

Json morphs_json(const SceneInfo& info) {
    Json list = Json::array();
    for (const MorphInfoRow& row : info.morphed_meshes) list.push_back({{"mesh", row.name}, {"targets", row.targets}});
    return list;
}

}  // namespace

Json info_json(const SceneInfo& info) {
    return {{"scene", info.name},
            {"generator", info.generator},
            {"copyright", info.copyright},
            {"triangles", info.triangles},
            {"instanced_triangles", info.instanced_triangles},
            {"vertices", info.vertices},
            {"nodes", info.nodes},
            {"meshes", info.meshes},
            {"primitives", info.primitives},
            {"instances", info.instances},
            {"materials", info.materials},
            {"images", info.images},
            {"textures", textures_json(info)},
            {"lights", lights_json(info)},
            {"emitters", info.emitters},
            {"emissive_triangles", info.emissive_triangles},
            {"environment", info.environment},
            {"cameras", info.cameras},
            {"bounds",
             info.bounds.empty() ? Json(nullptr) : Json{{"min", vector_json(info.bounds.min)}, {"max", vector_json(info.bounds.max)}}},
            {"scripted_edits", info.scripted_edits},
            {"animations", animations_json(info)},
            {"skins", skins_json(info)},
            {"morphed_meshes", morphs_json(info)},
            {"extensions_used", info.extensions_used},
            {"variants", info.variants},
            {"not_drawn", not_drawn_json(info)},
            {"extensions_not_drawn", info.extensions_not_drawn},
            {"memory", {{"geometry", info.geometry_bytes}, {"images", info.image_bytes}, {"files", info.file_bytes}}},
            {"warnings", info.warnings}};
}

}  // namespace parhelion
