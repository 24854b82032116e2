// Many small lights over a field, in the proportions of Bevy Solari's many-lights benchmark scene.
#include <cmath>

#include "scene/builtin/random.h"
#include "scene/builtin/scenes.h"
#include "scene/builtin/scripts.h"
#include "scene/builtin/textures.h"
#include "scene/shapes.h"

namespace parhelion::builtin {

namespace {

constexpr uint32_t kBoxes = 8000, kLightsAcross = 21, kKinds = 64;
constexpr float kHalfField = 200.0f, kPitch = 20.0f, kLightHeight = 7.0f;

void add_field(SceneEdit& edit) {
    Material field = glossy("field", glm::vec3(1.0f), 0.0f, 0.0f);
    field.base_color_texture = add_texture(edit,
                                           make_image("checker", 2, 2,
                                                      [](float u, float v) {
                                                          const bool light = (u < 0.5f) == (v < 0.5f);
                                                          return glm::vec4(light ? glm::vec3(0.55f) : glm::vec3(0.22f), 1.0f);
                                                      }),
                                           ColorSpace::Srgb, {.mag = Filter::Nearest});
    Primitive ground;
    add_textured_quad(ground, {-kHalfField, 0.0f, kHalfField}, {2.0f * kHalfField, 0.0f, 0.0f}, {0.0f, 0.0f, -2.0f * kHalfField},
                      glm::vec2(100.0f));
    place_object(edit, "field", std::move(ground), edit.add(std::move(field)));
}

// Cubes of 64 materials, placed 8,000 times.
void add_boxes(SceneEdit& edit, Random& random) {
    std::vector<Handle<Mesh>> kinds;
    for (uint32_t kind = 0; kind < kKinds; ++kind) {
        const glm::vec3 color(random.range(0.05f, 0.95f), random.range(0.05f, 0.95f), random.range(0.05f, 0.95f));
        Mesh cube{.name = fmt::format("cube {}", kind)};
        add_box(cube.primitives.emplace_back(), glm::vec3(-0.5f), glm::vec3(0.5f));
        cube.primitives[0].material = edit.add(glossy(cube.name, color, random.unit() < 0.25f ? 1.0f : 0.0f, random.unit()));
        kinds.push_back(edit.add(std::move(cube)));
    }
    for (uint32_t i = 0; i < kBoxes; ++i) {
        const float size = random.range(0.2f, 2.0f), x = random.range(-kHalfField, kHalfField), z = random.range(-kHalfField, kHalfField);
        const Transform local{.translation = {x, 0.5f * size, z},
                              .rotation = glm::angleAxis(random.range(0.0f, float(kTurn)), glm::vec3(0.0f, 1.0f, 0.0f)),
                              .scale = glm::vec3(size)};
        const Handle<Node> node = edit.add(Node{.name = fmt::format("box {}", i), .local = local});
        edit.add(Instance{.mesh = kinds[random.below(kKinds)], .place = {.node = node}});
    }
}

struct Lamp {
    Handle<Node> node;
    Handle<Material> material;
    glm::vec3 at;
    float phase;  // [0, 1)
};

std::vector<Lamp> add_lamps(SceneEdit& edit, Random& random) {
    std::vector<Lamp> lamps;
    const Primitive sphere = make_sphere(1.0f, 8, true);
    for (uint32_t i = 0; i < kLightsAcross * kLightsAcross; ++i) {
        const float middle = 0.5f * float(kLightsAcross - 1);
        const glm::vec3 at((float(i % kLightsAcross) - middle) * kPitch, kLightHeight, (float(i / kLightsAcross) - middle) * kPitch);
        const glm::vec3 nits(random.range(0.0f, 60000.0f), random.range(0.0f, 60000.0f), random.range(0.0f, 60000.0f));
        const std::string name = fmt::format("light {}", i);
        const Handle<Material> material = edit.add(lambert(name, glm::vec3(0.5f), nits));
        lamps.push_back({place_object(edit, name, sphere, material, {.translation = at}), material, at, random.unit()});
    }
    return lamps;
}

}  // namespace

LoadedScene make_many_lights(const BuiltinOptions&) {
    SceneEdit edit;
    Random random(2025u);
    add_field(edit);
    add_boxes(edit, random);
    std::vector<Lamp> lamps = add_lamps(edit, random);
    add_camera(edit, "near", {-7.0f, 5.5f, 34.0f}, {4.0f, 2.5f, -10.0f}, glm::radians(55.0f));
    add_camera(edit, "far", {0.0f, 130.0f, 430.0f}, {0.0f, 0.0f, 30.0f}, glm::radians(45.0f));
    add_camera(edit, "above", {0.0f, 60.0f, 0.01f}, {0.0f, 0.0f, 0.0f}, glm::radians(60.0f));

    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    for (Lamp& lamp : lamps) lamp.node = changes.resolve(lamp.node), lamp.material = changes.resolve(lamp.material);
    out.scripted_edits.push_back({"drift", "every light circles about its place, once in 8 seconds", [lamps](const Scene&, double seconds) {
                                      SceneEdit step;
                                      for (const Lamp& lamp : lamps) {
                                          const double angle = kTurn * (seconds / 8.0 + double(lamp.phase));
                                          const glm::vec3 offset(4.0 * std::cos(angle), 1.5 * std::sin(2.0 * angle), 4.0 * std::sin(angle));
                                          step.set_transform(lamp.node, {.translation = lamp.at + offset});
                                      }
                                      return step;
                                  }});
    out.scripted_edits.push_back({"blink", "half of the lights vanish and come again, each once in 2 seconds", [lamps](const Scene&, double seconds) {
                                      SceneEdit step;
                                      for (size_t i = 0; i < lamps.size(); i += 2) {
                                          const double t = seconds / 2.0 + double(lamps[i].phase);
                                          const bool there = t - std::floor(t) < 0.5;
                                          step.set_transform(lamps[i].node,
                                                             {.translation = lamps[i].at, .scale = glm::vec3(there ? 1.0f : 0.0f)});
                                      }
                                      return step;
                                  }});
    out.scripted_edits.push_back(switched_materials("switch", "the light in the middle is off every other second", out.scene, {lamps[lamps.size() / 2].material}));
    std::vector<std::pair<Lamp, Handle<Mesh>>> guests;
    for (size_t i = 0; i < lamps.size(); i += 3) guests.emplace_back(lamps[i], out.scene.get(out.scene.get(lamps[i].node).instances.front()).mesh);
    out.scripted_edits.push_back({"guests", "a third of the lights are taken away and put back, each once in 2 seconds", [guests](const Scene& scene, double seconds) {
                                      SceneEdit step;
                                      for (const auto& [lamp, mesh] : guests) {
                                          const double t = seconds / 2.0 + double(lamp.phase);
                                          const bool wanted = seconds <= 0.0 || t - std::floor(t) < 0.5;
                                          const std::vector<Handle<Instance>>& there = scene.get(lamp.node).instances;
                                          if (wanted && there.empty()) step.add(Instance{.mesh = mesh, .place = {.node = lamp.node}});
                                          if (!wanted && !there.empty()) step.remove(there.front());
                                      }
                                      return step;
                                  }});
    return out;
}

}  // namespace parhelion::builtin
