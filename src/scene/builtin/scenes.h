#pragma once
// Internal to the scene layer: the makers of built-in scenes and what they share.
#include <numbers>

#include "scene/builtin.h"

namespace parhelion::builtin {

constexpr double kTurn = 2.0 * std::numbers::pi;  // radians

// Pure Lambert (specular 0, metallic 0).
Material lambert(std::string name, glm::vec3 albedo, glm::vec3 emission = glm::vec3(0.0f));
glm::mat4 place_looking(glm::vec3 from, glm::vec3 at);  // of a camera, upright
Handle<Camera> add_camera(SceneEdit& edit, std::string name, glm::vec3 from, glm::vec3 at, float yfov);
Material glossy(std::string name, glm::vec3 color, float metallic, float roughness);
// A mesh of one primitive, on a node of its own.
Handle<Instance> add_object(SceneEdit& edit, std::string name, Primitive primitive, Handle<Material> material, const Transform& local = {});
// The same for what is moved later: returns the node.
Handle<Node> place_object(SceneEdit& edit, std::string name, Primitive primitive, Handle<Material> material, const Transform& local = {},
                          Handle<Node> parent = {});

LoadedScene make_cornell(const BuiltinOptions& options);
LoadedScene make_furnace(const BuiltinOptions& options);
LoadedScene make_diffuse_box(const BuiltinOptions& options);
LoadedScene make_spheres(const BuiltinOptions& options);
LoadedScene make_textured(const BuiltinOptions& options);
LoadedScene make_many_lights(const BuiltinOptions& options);
LoadedScene make_reflections(const BuiltinOptions& options);
LoadedScene make_leak_box(const BuiltinOptions& options);
LoadedScene make_forest(const BuiltinOptions& options);
LoadedScene make_glass(const BuiltinOptions& options);
LoadedScene make_diorama(const BuiltinOptions& options);
LoadedScene make_room(const BuiltinOptions& options);
LoadedScene make_room_instanced(const BuiltinOptions& options);

}  // namespace parhelion::builtin
