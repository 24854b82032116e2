#include "scene/builtin/scripts.h"

#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"

namespace parhelion::builtin {

namespace {

// What has this name now, if anything has.
template <class T>
std::optional<Handle<T>> find_named(const Scene& scene, std::string_view name) {
    for (const auto& [handle, value] : scene.all<T>())
        if (value.name == name) return handle;
    return std::nullopt;
}

}  // namespace

bool is_on(double seconds) { return seconds / 2.0 - std::floor(seconds / 2.0) < 0.5; }

double back_and_forth(double seconds, double period) {
    const double t = seconds / period + 0.25;
    return 1.0 - 4.0 * std::abs(t - std::floor(t) - 0.5);
}

ScriptedEdit switched_materials(std::string name, std::string help, const Scene& scene, std::vector<Handle<Material>> materials) {
    std::vector<std::pair<Handle<Material>, Material>> lit;
    for (const Handle<Material> handle : materials) lit.emplace_back(handle, scene.get(handle));
    return {std::move(name), std::move(help), [lit](const Scene&, double seconds) {
                SceneEdit step;
                for (const auto& [handle, material] : lit) {
                    Material now = material;
                    if (!is_on(seconds)) now.emission = glm::vec3(0.0f);
                    step.set_material(handle, std::move(now));
                }
                return step;
            }};
}

ScriptedEdit switched_light(std::string name, std::string help, const Scene& scene, Handle<Light> light) {
    return {std::move(name), std::move(help), [light, lit = scene.get(light)](const Scene&, double seconds) {
                Light now = lit;
                if (!is_on(seconds)) now.intensity = 0.0f;
                SceneEdit step;
                step.set_light(light, now);
                return step;
            }};
}

ScriptedEdit passing_lights(std::string name, std::string help, std::vector<Light> lights, bool (*present)(size_t, double)) {
    return {std::move(name), std::move(help), [lights = std::move(lights), present](const Scene& scene, double seconds) {
                SceneEdit step;
                for (size_t i = 0; i < lights.size(); ++i) {
                    const std::optional<Handle<Light>> there = find_named<Light>(scene, lights[i].name);
                    if (there && !present(i, seconds)) step.remove(*there);
                    if (!there && present(i, seconds)) step.add(lights[i]);
                }
                return step;
            }};
}

ScriptedEdit moving_torch(std::string name, std::string help, const Torch& torch) {
    return {std::move(name), std::move(help), [torch](const Scene& scene, double seconds) {
                constexpr std::string_view kNode = "torch";
                const double period = 4.0 * double(glm::length(torch.to_end)) / torch.meters_per_second;
                const Transform local{.translation = torch.middle + float(back_and_forth(seconds, period)) * torch.to_end};
                SceneEdit step;
                if (const std::optional<Handle<Node>> node = find_named<Node>(scene, kNode)) step.set_transform(*node, local);
                else place_object(step, std::string(kNode), make_sphere(torch.radius, 12, true), step.add(lambert("torch", glm::vec3(0.5f), torch.nits)), local);
                return step;
            }};
}

ScriptedEdit camera_cut(std::string name, std::string help, const Scene& scene, Handle<Camera> camera, std::vector<glm::mat4> places) {
    places.insert(places.begin(), scene.get(camera).place.node_from_object);
    return {std::move(name), std::move(help), [camera, places = std::move(places)](const Scene&, double seconds) {
                SceneEdit step;
                step.set_transform(camera, places[static_cast<size_t>(std::fmod(std::floor(seconds), double(places.size())))]);
                return step;
            }};
}

}  // namespace parhelion::builtin
