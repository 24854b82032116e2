#pragma once
// `parhelion info`: what is in a scene.
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "scene/builtin.h"

namespace parhelion {

struct SceneInfo {
    std::string name;
    SceneSource source;
    size_t meshes = 0, primitives = 0, instances = 0, nodes = 0, materials = 0, textures = 0, images = 0, lights = 0, emissive_materials = 0;
    uint64_t triangles = 0, instanced_triangles = 0, image_bytes = 0;
    bool environment = false;
    Bounds bounds;
    std::vector<std::string> cameras;
    std::vector<std::pair<std::string, std::string>> scripted_edits;  // name, help
};

SceneInfo describe_scene(const std::string& name);  // a file or builtin:name
nlohmann::ordered_json scene_info_json(const SceneInfo& info);
std::string scene_info_text(const SceneInfo& info);  // names from the file are escaped

}  // namespace parhelion
