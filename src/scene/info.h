#pragma once
// What `parhelion info` says about a scene.
#include <string>
#include <vector>

#include "scene/builtin.h"

namespace parhelion {

struct TextureInfoRow {
    std::string name;
    uint32_t width = 0, height = 0;
    ColorSpace color_space = ColorSpace::Srgb;
};

struct LightInfoRow {
    std::string name;
    LightKind kind = LightKind::Point;
    glm::vec3 intensity{0.0f};  // colour x intensity: candela or lux
};

// Something that the scene says of its surfaces and the picture lacks.
struct NotDrawnRow {
    std::string_view feature;
    size_t materials = 0;  // that use it, of those that can be seen
};

struct AnimationInfoRow {
    std::string name;
    float seconds = 0.0f;  // until its last key
    size_t channels = 0;
};

struct SkinInfoRow {
    std::string name;
    size_t joints = 0;
};

struct MorphInfoRow {
    std::string name;                  // of the mesh
    std::vector<std::string> targets;  // names, "" where the file has none
};

struct SceneInfo {
    std::string name, generator, copyright;
    size_t nodes = 0, meshes = 0, primitives = 0, instances = 0, materials = 0, images = 0;
    uint64_t triangles = 0, vertices = 0;  // of all meshes at rest, each counted once
    uint64_t instanced_triangles = 0;      // as often as they are placed
    std::vector<TextureInfoRow> textures;
    std::vector<LightInfoRow> lights;
    uint64_t emitters = 0;                    // emissive mesh instances by geometry
    uint64_t emissive_triangles = 0;          // instanced
    bool environment = false;                 // not black
    std::vector<std::string> cameras;         // names, in the order of their indices
    std::vector<std::string> scripted_edits;  // "name: what it does"
    std::vector<AnimationInfoRow> animations;
    std::vector<SkinInfoRow> skins;
    std::vector<MorphInfoRow> morphed_meshes;
    std::vector<std::string> variants;  // names of the material variants
    std::vector<NotDrawnRow> not_drawn;
    std::vector<std::string> extensions_used, extensions_not_drawn, warnings;
    Bounds bounds;                                                 // world
    uint64_t geometry_bytes = 0, image_bytes = 0, file_bytes = 0;  // in memory on the host; of the files
};

SceneInfo describe(const LoadedScene& loaded);

// Lines for people.
std::string format_info(const SceneInfo& info);

}  // namespace parhelion
