// Built-in scenes that show materials: a grid of spheres, and the textured twin of what real assets bring.
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/builtin/scripts.h"
#include "scene/builtin/textures.h"
#include "scene/shapes.h"

namespace parhelion::builtin {

namespace {

// A plain sky: blue above, pale at the horizon, dim ground, and a soft warm sun of about 20 degrees that light sampling must find.
Environment make_sky() {
    Environment sky{.name = "plain sky", .width = 128, .height = 64, .scale = glm::vec3(1.0f)};
    const glm::dvec3 sun = glm::normalize(glm::dvec3(0.5, 0.7, 0.6));
    constexpr double kPi = 3.14159265358979323846;
    for (uint32_t y = 0; y < sky.height; ++y)
        for (uint32_t x = 0; x < sky.width; ++x) {
            const double theta = kPi * (y + 0.5) / sky.height, phi = 2.0 * kPi * ((x + 0.5) / sky.width - 0.5);
            const glm::dvec3 d(std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi));
            glm::dvec3 radiance =
                d.y < 0.0 ? glm::dvec3(0.15, 0.13, 0.11) : glm::mix(glm::dvec3(1.0, 1.0, 1.0), glm::dvec3(0.25, 0.45, 0.9), std::sqrt(d.y));
            const double glow = glm::smoothstep(0.94, 0.99, glm::dot(d, sun));
            radiance += glow * glm::dvec3(25.0, 21.0, 15.0);
            sky.radiance.emplace_back(radiance);
        }
    return sky;
}

Image square_image(std::string name, uint32_t size, const PixelFunction& pixel) { return make_image(std::move(name), size, size, pixel); }

bool checker(float u, float v, float cells) { return (int(u * cells) + int(v * cells)) % 2 == 0; }

struct Textures {
    TextureRef checker, bumps, metal_rough, cutout, glow;
};

Textures add_textures(SceneEdit& edit) {
    Textures t;
    t.checker =
        add_texture(edit,
                    square_image("checker", 64,
                               [](float u, float v) {
                                   // One red cell in the upper left corner shows orientation.
                                   if (u < 0.125f && v < 0.125f) return glm::vec4(0.9f, 0.1f, 0.1f, 1.0f);
                                   return checker(u, v, 8.0f) ? glm::vec4(0.85f, 0.85f, 0.8f, 1.0f) : glm::vec4(0.2f, 0.3f, 0.5f, 1.0f);
                               }),
                    ColorSpace::Srgb);
    t.bumps = add_texture(edit,
                          square_image("bumps", 64,
                                     [](float u, float v) {
                                         // Round bumps, 4 x 4: the slope of a cosine, green pointing up in the image.
                                         const glm::vec3 n = glm::normalize(
                                             glm::vec3(0.5f * std::sin(float(kTurn) * 4.0f * u), -0.5f * std::sin(float(kTurn) * 4.0f * v), 1.0f));
                                         return glm::vec4(0.5f * n + 0.5f, 1.0f);
                                     }),
                          ColorSpace::Linear);
    t.metal_rough = add_texture(
        edit,
        square_image("metal-rough", 32, [](float u, float v) { return glm::vec4(1.0f, 0.2f + 0.7f * v, u < 0.5f ? 1.0f : 0.0f, 1.0f); }),
        ColorSpace::Linear);
    t.cutout = add_texture(edit,
                           square_image("cutout", 64,
                                      [](float u, float v) {
                                          const float r = std::hypot(u - 0.5f, v - 0.5f);
                                          return glm::vec4(0.3f, 0.7f, 0.3f, glm::clamp(4.0f * (0.45f - r) + 0.5f, 0.0f, 1.0f));
                                      }),
                           ColorSpace::Srgb, {.wrap_u = Wrap::ClampToEdge, .wrap_v = Wrap::ClampToEdge});
    t.glow = add_texture(edit,
                         square_image("glow", 16,
                                    [](float u, float v) {
                                        return checker(u, v, 4.0f) ? glm::vec4(1.0f, 0.8f, 0.4f, 1.0f) : glm::vec4(0.1f, 0.1f, 0.3f, 1.0f);
                                    }),
                         ColorSpace::Srgb, {.mag = Filter::Nearest});
    return t;
}

Primitive textured_quad(glm::vec3 corner, glm::vec3 u, glm::vec3 v, float repeats = 1.0f) {
    Primitive quad;
    add_textured_quad(quad, corner, u, v, glm::vec2(repeats));
    return quad;
}

// Ground and back wall with a repeated, turned checker; a panel whose texture emits.
void add_textured_room(SceneEdit& edit, const Textures& t) {
    Material ground = glossy("ground", glm::vec3(1.0f), 0.0f, 0.6f);
    ground.base_color_texture = t.checker;
    ground.base_color_texture.rotation = 0.3f;
    ground.base_color_texture.offset = {0.25f, 0.1f};
    add_object(edit, "ground", textured_quad({-3.0f, 0.0f, 3.0f}, {6.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -6.0f}, 3.0f),
               edit.add(std::move(ground)));
    Material wall = glossy("wall", {0.8f, 0.8f, 0.8f}, 1.0f, 1.0f);
    wall.metal_rough_texture = t.metal_rough;
    wall.normal_texture = t.bumps;
    add_object(edit, "wall", textured_quad({-3.0f, 0.0f, -2.0f}, {6.0f, 0.0f, 0.0f}, {0.0f, 3.0f, 0.0f}, 2.0f), edit.add(std::move(wall)));
    Material panel = glossy("panel", glm::vec3(0.0f), 0.0f, 1.0f);
    panel.emission = glm::vec3(12.0f);
    panel.emissive_texture = t.glow;
    add_object(edit, "panel", textured_quad({-2.2f, 1.4f, -1.9f}, {1.2f, 0.0f, 0.0f}, {0.0f, 1.2f, 0.0f}), edit.add(std::move(panel)));
}

// One leaf that is cut out (MASK), one that fades (BLEND); both double-sided, crossing each other.
void add_alpha_quads(SceneEdit& edit, const Textures& t) {
    Material mask = glossy("leaf", glm::vec3(1.0f), 0.0f, 0.8f);
    mask.base_color_texture = t.cutout;
    mask.alpha_mode = AlphaMode::Mask;
    mask.double_sided = true;
    Material blend = mask;
    blend.name = "veil";
    blend.alpha_mode = AlphaMode::Blend;
    blend.base_color = {1.0f, 0.5f, 0.5f, 0.7f};
    add_object(edit, "leaf", textured_quad({1.1f, 0.1f, 0.9f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}), edit.add(std::move(mask)));
    add_object(edit, "veil", textured_quad({1.6f, 0.1f, 1.4f}, {0.0f, 0.0f, -1.0f}, {0.0f, 1.0f, 0.0f}), edit.add(std::move(blend)));
}

// One mesh, placed as it is, mirrored, and stretched.
Handle<Node> add_statues(SceneEdit& edit, const Textures& t) {
    Material material = glossy("statue", {0.9f, 0.75f, 0.5f}, 0.0f, 0.35f);
    material.base_color_texture = t.checker;
    material.base_color_texture.scale = {2.0f, 2.0f};
    material.normal_texture = t.bumps;
    material.normal_texture.scale = {2.0f, 2.0f};
    material.normal_scale = 0.8f;
    Mesh mesh{.name = "statue"};
    mesh.primitives.push_back(make_sphere(0.5f, 20, true));
    mesh.primitives[0].material = edit.add(std::move(material));
    const Handle<Mesh> handle = edit.add(std::move(mesh));
    const Handle<Node> group = edit.add(Node{.name = "statues"});
    const auto place = [&](std::string name, glm::vec3 at, glm::vec3 scale) {
        const Handle<Node> node = edit.add(Node{.name = std::move(name), .parent = group, .local = {.translation = at, .scale = scale}});
        edit.add(Instance{.mesh = handle, .place = {.node = node}});
    };
    place("plain", {-1.6f, 0.5f, 0.0f}, glm::vec3(1.0f));
    place("mirrored", {-0.4f, 0.5f, 0.3f}, {-1.0f, 1.0f, 1.0f});
    place("stretched", {0.8f, 0.8f, -0.4f}, {0.7f, 1.6f, 1.0f});
    return group;
}

}  // namespace

LoadedScene make_spheres(const BuiltinOptions&) {
    constexpr int kSteps = 5;
    SceneEdit edit;
    const Primitive sphere = make_sphere(0.45f, 24, true);
    std::vector<std::pair<Handle<Node>, glm::vec3>> middle_row;
    for (int row = 0; row < kSteps; ++row)
        for (int column = 0; column < kSteps; ++column) {
            const float metallic = float(row) / (kSteps - 1), roughness = 0.05f + 0.95f * float(column) / (kSteps - 1);
            const std::string name = fmt::format("metallic {:.2f} roughness {:.2f}", metallic, roughness);
            const glm::vec3 at(float(column) - 2.0f, float(row) - 2.0f, 0.0f);
            const Handle<Node> node = place_object(edit, name, sphere, edit.add(glossy(name, {0.9f, 0.6f, 0.3f}, metallic, roughness)), {.translation = at});
            if (row == kSteps / 2) middle_row.emplace_back(node, at);
        }
    const Environment sky = make_sky();
    edit.set_environment(sky);
    add_camera(edit, "front", {0.0f, 0.0f, 8.0f}, glm::vec3(0.0f), glm::radians(38.0f));
    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    for (auto& [node, at] : middle_row) node = changes.resolve(node);
    out.scripted_edits.push_back({"sky", "the sky turns, 30 degrees a second", [sky](const Scene&, double seconds) {
                                      Environment now = sky;
                                      now.rotation = static_cast<float>(std::fmod(seconds * glm::radians(30.0), glm::radians(360.0)));
                                      SceneEdit step;
                                      step.set_environment(std::move(now));
                                      return step;
                                  }});
    Light sun{.name = "sun", .kind = LightKind::Directional, .color = {1.0f, 0.9f, 0.75f}, .intensity = 3.0f, .angular_radius = 0.00465f};
    sun.place.node_from_object = place_looking(glm::vec3(0.0f), {0.6f, -0.5f, -0.7f});
    out.scripted_edits.push_back(passing_lights("sun", "a sun shines every other second", {sun}, [](size_t, double seconds) { return is_on(seconds); }));
    out.scripted_edits.push_back({"leave", "the middle row moves out of the picture and comes back, once in 4 seconds", [middle_row](const Scene&, double seconds) {
                                      SceneEdit step;
                                      for (const auto& [node, at] : middle_row)
                                          step.set_transform(node, {.translation = at + glm::vec3(4.0 - 4.0 * std::cos(1.5707963267948966 * seconds), 0.0f, 0.0f)});
                                      return step;
                                  }});
    return out;
}

LoadedScene make_textured(const BuiltinOptions&) {
    SceneEdit edit;
    const Textures textures = add_textures(edit);
    add_textured_room(edit, textures);
    add_alpha_quads(edit, textures);
    const Handle<Node> statues = add_statues(edit, textures);
    const Handle<Node> lamp = edit.add(Node{.name = "lamp", .local = {.translation = {1.5f, 2.5f, 1.5f}}});
    edit.add(Light{.name = "lamp", .kind = LightKind::Point, .color = {1.0f, 0.95f, 0.9f}, .intensity = 30.0f, .place = {.node = lamp}});
    edit.set_environment({.name = "dim", .scale = glm::vec3(0.1f, 0.12f, 0.15f)});
    add_camera(edit, "front", {0.3f, 1.6f, 5.5f}, {0.0f, 0.9f, 0.0f}, glm::radians(40.0f));

    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    const Handle<Node> moving = changes.resolve(statues);
    out.scripted_edits.push_back(
        {"sway", "the statues move sideways and back, once in 4 seconds", [moving](const Scene&, double seconds) {
             SceneEdit step;
             step.set_transform(moving, {.translation = {float(0.3 * std::sin(kTurn * seconds / 4.0)), 0.0f, 0.0f}});
             return step;
         }});
    const Handle<Light> light = *out.scene.lights().handle_at(0);
    const Light lit = out.scene.get(light);
    out.scripted_edits.push_back({"flicker", "the lamp's brightness swings, once a second", [light, lit](const Scene&, double seconds) {
                                      Light now = lit;
                                      now.intensity = lit.intensity * float(1.0 + 0.5 * std::sin(kTurn * seconds));
                                      SceneEdit step;
                                      step.set_light(light, now);
                                      return step;
                                  }});
    return out;
}

}  // namespace parhelion::builtin
