#pragma once
// Internal to the scene layer: scripted edits that several built-in scenes have.
#include <string>
#include <utility>
#include <vector>

#include "scene/builtin.h"

namespace parhelion::builtin {

// On in the first second of every two.
bool is_on(double seconds);
// There and back between -1 and 1, at an even pace, once in `period` seconds; starts at 0.
double back_and_forth(double seconds, double period);

// Materials that emit nothing every other second.
ScriptedEdit switched_materials(std::string name, std::string help, const Scene& scene, std::vector<Handle<Material>> materials);
// A light that gives nothing every other second.
ScriptedEdit switched_light(std::string name, std::string help, const Scene& scene, Handle<Light> light);
// Lights that are not in the scene at rest: each is there while present(its number, seconds).
ScriptedEdit passing_lights(std::string name, std::string help, std::vector<Light> lights, bool (*present)(size_t, double));
// A glowing ball that is not in the scene at rest. It moves along a line through `middle` to both sides, at an even pace.
struct Torch {
    glm::vec3 middle{0.0f}, to_end{1.0f, 0.0f, 0.0f};  // metres; `to_end` from the middle
    float radius = 0.06f;
    double meters_per_second = 2.0;
    glm::vec3 nits{1.0f};
};
ScriptedEdit moving_torch(std::string name, std::string help, const Torch& torch);
// A camera that stands at each of these places for a second, beginning with its own.
ScriptedEdit camera_cut(std::string name, std::string help, const Scene& scene, Handle<Camera> camera, std::vector<glm::mat4> places);

}  // namespace parhelion::builtin
