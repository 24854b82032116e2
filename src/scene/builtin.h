#pragma once
// Built-in scenes: code, deterministic, for tests, first pictures and benchmarks. Names begin with "builtin:".
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/scene.h"

namespace parhelion {

// A motion that a scene declares: `parhelion render --animate NAME`. apply(scene, t) gives the edit that puts the scene into its state at
// t seconds, whatever this edit has done to it before. The state depends on t alone; the scene tells what of it is there already.
struct ScriptedEdit {
    std::string name, help;
    std::function<SceneEdit(const Scene& scene, double seconds)> apply;
};

struct LoadedScene {
    Scene scene;
    std::vector<ScriptedEdit> scripted_edits;
};

struct BuiltinEntry {
    std::string_view name;  // with "builtin:"
    std::string_view help;
};
const std::vector<BuiltinEntry>& builtin_scenes();
bool is_builtin(std::string_view name);

// Numbers that a built-in scene may take; each scene reads the ones that its help names.
struct BuiltinOptions {
    glm::vec3 albedo{0.5f};    // furnace, diffuse-box
    glm::vec3 emission{0.5f};  // diffuse-box: nits of every wall; furnace: nits of the environment
    float roughness = 1.0f;    // furnace: below 1 or with metallic the surface is not pure Lambert
    float metallic = 0.0f;
    uint64_t triangles = 0;  // forest: about how many; room, room-instanced: which of their sizes; 0: the scene's own choice
};

// Throws a usage Error that lists all names.
LoadedScene make_builtin(std::string_view name, const BuiltinOptions& options = {});

}  // namespace parhelion
