// A table of glass and of what else has layers: every way in which light goes through a surface or is split by a coat.
#include <array>
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/builtin/textures.h"
#include "scene/shapes.h"

namespace parhelion::builtin {

namespace {

Material body_of_glass(std::string name, float ior, float roughness) {
    Material glass = glossy(std::move(name), glm::vec3(1.0f), 0.0f, roughness);
    glass.transmission = 1.0f;
    glass.thickness = 1.0f;
    glass.ior = ior;
    return glass;
}

Material tinted(Material glass, glm::vec3 color, float distance) {
    glass.attenuation_color = color;
    glass.attenuation_distance = distance;
    return glass;
}

void add_room(SceneEdit& edit) {
    Material checks = glossy("table", glm::vec3(1.0f), 0.0f, 0.6f);
    checks.base_color_texture = add_texture(edit,
                                            make_image("checks", 32, 32,
                                                       [](float u, float v) {
                                                           const bool dark = (u < 0.5f) == (v < 0.5f);
                                                           return dark ? glm::vec4(0.35f, 0.36f, 0.38f, 1.0f) : glm::vec4(0.82f, 0.80f, 0.76f, 1.0f);
                                                       }),
                                            ColorSpace::Srgb);
    Primitive table, wall, lamp;
    add_textured_quad(table, {-6.0f, 0.0f, 4.0f}, {12.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f}, {12.0f, 8.0f});
    add_quad(wall, {-6.0f, 0.0f, -4.0f}, {12.0f, 0.0f, 0.0f}, {0.0f, 6.0f, 0.0f});
    add_quad(lamp, {-2.6f, 4.4f, -1.6f}, {2.4f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.4f});
    add_object(edit, "table", std::move(table), edit.add(std::move(checks)));
    add_object(edit, "wall", std::move(wall), edit.add(lambert("wall", {0.42f, 0.46f, 0.52f})));
    add_object(edit, "lamp", std::move(lamp), edit.add(lambert("lamp", glm::vec3(0.5f), {30.0f, 27.0f, 23.0f})));
    edit.set_environment({.name = "dusk", .scale = {0.55f, 0.62f, 0.75f}});
}

void add_spheres(SceneEdit& edit) {
    Material lacquer = glossy("lacquer", {0.55f, 0.03f, 0.02f}, 0.0f, 0.6f);
    lacquer.clearcoat = 1.0f;
    Material velvet = glossy("velvet", {0.05f, 0.02f, 0.12f}, 0.0f, 1.0f);
    velvet.sheen_color = {0.75f, 0.55f, 0.9f};
    velvet.sheen_roughness = 0.35f;
    const std::array<Material, 6> row = {body_of_glass("clear glass", 1.5f, 0.0f), body_of_glass("rough glass", 1.5f, 0.3f),
                                         tinted(body_of_glass("amber", 1.55f, 0.0f), {0.95f, 0.55f, 0.12f}, 0.35f), glossy("mirror", glm::vec3(0.95f), 1.0f, 0.0f),
                                         lacquer, velvet};
    for (size_t i = 0; i < row.size(); ++i)
        place_object(edit, row[i].name, make_sphere(0.45f, 48, true), edit.add(row[i]), {.translation = {-2.75f + 1.1f * float(i), 0.451f, -0.9f}});
}

// The water reaches half a millimetre into the glass, which has the higher priority: no gap of air, no surface twice.
void add_tumbler(SceneEdit& edit) {
    constexpr float kInner = 0.32f, kOuter = 0.36f, kFloor = 0.06f, kHeight = 0.95f, kInto = 0.0005f;
    const std::array<glm::vec2, 9> wall = {glm::vec2(0.0f, 0.0f),   {kOuter - 0.02f, 0.0f},      {kOuter, 0.02f},          {kOuter, kHeight - 0.01f}, {kOuter - 0.02f, kHeight},
                                           {kInner, kHeight - 0.01f}, {kInner, kFloor + 0.02f}, {kInner - 0.02f, kFloor}, {0.0f, kFloor}};
    constexpr float kWet = kInner + kInto, kTop = 0.62f;
    const std::array<glm::vec2, 6> water = {glm::vec2(0.0f, kFloor - kInto), {kInner - 0.02f, kFloor - kInto}, {kWet, kFloor + 0.02f}, {kWet, kTop - 0.001f}, {kWet - 0.001f, kTop}, {0.0f, kTop}};
    Material glass = body_of_glass("tumbler", 1.5f, 0.0f);
    glass.nested_priority = 1;
    const Transform place{.translation = {-0.9f, 0.001f, 0.75f}};
    place_object(edit, "tumbler", make_lathe(wall, 96), edit.add(glass), place);
    place_object(edit, "water", make_lathe(water, 96), edit.add(tinted(body_of_glass("water", 1.33f, 0.0f), {0.55f, 0.85f, 0.9f}, 0.5f)), place);
}

Transform pane_at(double seconds) {
    return {.translation = {1.35f, 0.001f, 0.65f}, .rotation = glm::angleAxis(float(-0.5 + 0.7853981633974483 * seconds), glm::vec3(0.0f, 1.0f, 0.0f))};
}

Handle<Node> add_pane(SceneEdit& edit) {
    Material thin = body_of_glass("pane", 1.5f, 0.0f);
    thin.thickness = 0.0f;
    thin.base_color = {0.35f, 0.8f, 0.45f, 1.0f};
    Primitive pane;
    add_quad(pane, {-0.7f, 0.0f, 0.0f}, {1.4f, 0.0f, 0.0f}, {0.0f, 1.1f, 0.0f});
    Material frosted = thin;
    frosted.name = "frosted pane";
    frosted.base_color = glm::vec4(1.0f);
    frosted.roughness = 0.35f;
    Primitive screen;
    add_quad(screen, {-2.95f, 0.001f, 0.55f}, {1.1f, 0.0f, 0.35f}, {0.0f, 0.9f, 0.0f});
    place_object(edit, "frosted pane", std::move(screen), edit.add(std::move(frosted)));
    return place_object(edit, "pane", std::move(pane), edit.add(std::move(thin)), pane_at(0.0));
}

}  // namespace

LoadedScene make_glass(const BuiltinOptions&) {
    SceneEdit edit;
    add_room(edit);
    add_spheres(edit);
    add_tumbler(edit);
    const Handle<Node> pane = add_pane(edit);
    add_camera(edit, "table", {0.3f, 2.1f, 5.2f}, {-0.05f, 0.45f, 0.0f}, glm::radians(38.0f));
    add_camera(edit, "tumbler", {-0.6f, 1.1f, 2.9f}, {-0.9f, 0.45f, 0.7f}, glm::radians(30.0f));
    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    out.scripted_edits.push_back({"turn", "the thin pane turns about its middle, once in 8 seconds", [node = changes.resolve(pane)](const Scene&, double seconds) {
                                      SceneEdit step;
                                      step.set_transform(node, pane_at(seconds));
                                      return step;
                                  }});
    return out;
}

}  // namespace parhelion::builtin
