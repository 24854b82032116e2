// A hall of mirrors and metals, in the size and with the light and the roughnesses of Bevy Solari's reflections scene.
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/builtin/scripts.h"
#include "scene/builtin/textures.h"
#include "scene/shapes.h"

namespace parhelion::builtin {

namespace {

constexpr float kRoughness[] = {0.0f, 0.0314f, 0.12f, 0.24f, 1.0f};
constexpr glm::vec3 kHallMin(-9.0f, 0.0f, -10.5f), kHallMax(9.0f, 8.0f, 10.5f);

void add_hall(SceneEdit& edit) {
    const Handle<Material> wall = edit.add(glossy("wall", {0.62f, 0.60f, 0.56f}, 0.0f, 0.9f));
    const Handle<Material> warm = edit.add(glossy("warm wall", {0.55f, 0.22f, 0.14f}, 0.0f, 0.8f));
    const Handle<Material> cool = edit.add(glossy("cool wall", {0.13f, 0.30f, 0.42f}, 0.0f, 0.8f));
    const glm::vec3 x(kHallMax.x - kHallMin.x, 0.0f, 0.0f), y(0.0f, kHallMax.y, 0.0f), z(0.0f, 0.0f, kHallMax.z - kHallMin.z);
    Primitive ends, left, right;
    add_quad(ends, kHallMin, x, y);
    add_quad(ends, {kHallMax.x, 0.0f, kHallMax.z}, -x, y);
    add_quad(ends, {kHallMin.x, kHallMax.y, kHallMin.z}, x, z);
    add_quad(left, {kHallMin.x, 0.0f, kHallMax.z}, -z, y);
    add_quad(right, {kHallMax.x, 0.0f, kHallMin.z}, z, y);
    place_object(edit, "ends and ceiling", std::move(ends), wall);
    place_object(edit, "left wall", std::move(left), warm);
    place_object(edit, "right wall", std::move(right), cool);

    Material tiles = glossy("floor", glm::vec3(1.0f), 0.0f, 0.12f);
    tiles.base_color_texture = add_texture(
        edit,
        make_image("tiles", 128, 128,
                   [](float u, float v) {
                       const float a = std::abs(std::fmod(2.0f * u, 1.0f) - 0.5f), b = std::abs(std::fmod(2.0f * v, 1.0f) - 0.5f);
                       if (std::max(a, b) > 0.488f) return glm::vec4(0.15f, 0.15f, 0.15f, 1.0f);
                       const float tone = (u < 0.5f) == (v < 0.5f) ? 0.75f : 0.38f;
                       return glm::vec4(glm::vec3(tone + 0.1f * (fractal_noise({8.0f * u, 8.0f * v}, {8, 8}, 4, 7u) - 0.5f)), 1.0f);
                   }),
        ColorSpace::Srgb);
    Primitive floor;
    add_textured_quad(floor, {kHallMin.x, 0.0f, kHallMax.z}, x, -z, {6.0f, 7.0f});
    place_object(edit, "floor", std::move(floor), edit.add(std::move(tiles)));
}

// Silver, gold and lacquer, each in five roughnesses.
void add_samples(SceneEdit& edit) {
    const struct {
        const char* name;
        glm::vec3 color;
        float metallic;
    } kinds[] = {{"silver", {0.95f, 0.93f, 0.88f}, 1.0f}, {"gold", {1.0f, 0.77f, 0.34f}, 1.0f}, {"lacquer", {0.55f, 0.03f, 0.04f}, 0.0f}};
    const Primitive sphere = make_sphere(0.55f, 32, true);
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 5; ++column) {
            const std::string name = fmt::format("{} roughness {:g}", kinds[row].name, kRoughness[column]);
            const glm::vec3 at(-3.2f + 1.6f * float(column), 0.55f, -1.6f + 1.7f * float(row));
            place_object(edit, name, sphere, edit.add(glossy(name, kinds[row].color, kinds[row].metallic, kRoughness[column])),
                         {.translation = at});
        }
}

// A framed sheet that stands upright and looks along +Z of its node.
Handle<Node> add_mirror(SceneEdit& edit, const std::string& name, glm::vec2 size, float roughness, Handle<Material> frame,
                        const Transform& local) {
    const Handle<Node> node = edit.add(Node{.name = name, .local = local});
    Primitive back = make_rounded_box({size.x + 0.2f, size.y + 0.2f, 0.1f}, 0.02f);
    place_object(edit, name + " frame", std::move(back), frame, {.translation = {0.0f, 0.5f * size.y + 0.1f, -0.052f}}, node);
    Primitive sheet;
    add_textured_quad(sheet, {-0.5f * size.x, 0.1f, 0.0f}, {size.x, 0.0f, 0.0f}, {0.0f, size.y, 0.0f});
    place_object(edit, name + " sheet", std::move(sheet), edit.add(glossy(name, {0.93f, 0.94f, 0.93f}, 1.0f, roughness)), {}, node);
    return node;
}

Transform turned(glm::vec3 at, float degrees) {
    return {.translation = at, .rotation = glm::angleAxis(glm::radians(degrees), glm::vec3(0.0f, 1.0f, 0.0f))};
}

Primitive make_ball() {
    Primitive ball = make_sphere(0.7f, 32, true);
    for (glm::vec2& uv : ball.uv0) uv *= glm::vec2(2.0f, 1.0f);
    return ball;
}

struct Moving {
    Handle<Node> panel, cube, ball;
    Handle<Material> lamp, ring;
};

Moving add_things(SceneEdit& edit) {
    Moving moving;
    const Handle<Material> frame = edit.add(glossy("frame", {0.05f, 0.045f, 0.04f}, 0.0f, 0.35f));
    moving.lamp = edit.add(lambert("ceiling lamp", glm::vec3(0.7f), {40000.0f, 38000.0f, 34000.0f}));
    Primitive lamp;
    add_quad(lamp, {-1.75f, 7.98f, -1.75f}, {3.5f, 0.0f, 0.0f}, {0.0f, 0.0f, 3.5f});
    place_object(edit, "ceiling lamp", std::move(lamp), moving.lamp);

    moving.panel = add_mirror(edit, "sliding mirror", {5.0f, 4.0f}, 0.0f, frame, turned({0.0f, 0.0f, -7.5f}, 0.0f));
    // Two mirrors that face each other: each is seen in the other, again and again.
    add_mirror(edit, "left mirror", {3.6f, 4.4f}, 0.0f, frame, turned({-8.3f, 0.0f, -3.0f}, 84.0f));
    add_mirror(edit, "right mirror", {3.6f, 4.4f}, 0.0314f, frame, turned({8.3f, 0.0f, -3.0f}, -84.0f));
    add_mirror(edit, "dull mirror", {3.0f, 3.0f}, 0.24f, frame, turned({5.6f, 0.0f, -8.2f}, -25.0f));

    // Behind the camera and above it: seen in mirrors.
    Primitive ring = make_torus(0.9f, 0.12f, 48, 16);
    moving.ring = edit.add(lambert("glow", glm::vec3(0.2f), {3000.0f, 14000.0f, 20000.0f}));
    place_object(edit, "glowing ring", std::move(ring), moving.ring,
                 {.translation = {-2.0f, 5.2f, 8.8f}, .rotation = glm::angleAxis(glm::radians(80.0f), glm::vec3(1.0f, 0.0f, 0.0f))});
    moving.cube = place_object(edit, "cube", make_rounded_box(glm::vec3(1.1f), 0.06f, 3),
                               edit.add(glossy("copper", {0.95f, 0.58f, 0.42f}, 1.0f, 0.12f)));

    Material stripes = glossy("ball", glm::vec3(1.0f), 0.0f, 0.24f);
    stripes.base_color_texture = add_texture(edit,
                                             make_image("stripes", 64, 8,
                                                        [](float u, float) {
                                                            return int(u * 4.0f) % 2 == 0 ? glm::vec4(0.93f, 0.90f, 0.80f, 1.0f)
                                                                                          : glm::vec4(0.85f, 0.42f, 0.08f, 1.0f);
                                                        }),
                                             ColorSpace::Srgb);
    moving.ball = place_object(edit, "ball", make_ball(), edit.add(std::move(stripes)));
    return moving;
}

Transform rolling_ball_at(double seconds) {
    const double x = -6.0 * back_and_forth(seconds, 12.0);
    return {.translation = {float(x), 0.7f, 4.4f}, .rotation = glm::angleAxis(float(-x / 0.7), glm::vec3(0.0f, 0.0f, 1.0f))};
}

Transform cube_at(double seconds) {
    const double angle = kTurn * seconds / 10.0;
    return {.translation = {float(5.6 * std::sin(angle)), 2.6f, float(-0.5 + 4.4 * std::cos(angle))},
            .rotation = glm::angleAxis(float(2.0 * angle), glm::normalize(glm::vec3(0.3f, 1.0f, 0.2f)))};
}

Transform panel_at(double seconds) {
    return turned({float(3.0 * back_and_forth(seconds, 16.0)), 0.0f, -7.5f}, float(8.0 * std::sin(kTurn * seconds / 7.0)));
}

ScriptedEdit mover(std::string name, std::string help, Handle<Node> node, Transform (*at)(double)) {
    return {std::move(name), std::move(help), [node, at](const Scene&, double seconds) {
                SceneEdit step;
                step.set_transform(node, at(seconds));
                return step;
            }};
}

}  // namespace

LoadedScene make_reflections(const BuiltinOptions&) {
    SceneEdit edit;
    add_hall(edit);
    add_samples(edit);
    const Moving moving = add_things(edit);
    edit.set_transform(moving.ball, rolling_ball_at(0.0));
    edit.set_transform(moving.cube, cube_at(0.0));
    add_camera(edit, "hall", {0.6f, 3.2f, 9.6f}, {0.0f, 1.3f, -2.0f}, glm::radians(52.0f));
    add_camera(edit, "between mirrors", {5.6f, 2.2f, 0.6f}, {-8.3f, 2.2f, -3.6f}, glm::radians(50.0f));
    add_camera(edit, "samples", {-4.6f, 1.9f, 4.0f}, {0.2f, 0.5f, -0.4f}, glm::radians(40.0f));

    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    out.scripted_edits.push_back(
        mover("roll", "a striped ball rolls past the mirrors and back, once in 12 seconds", changes.resolve(moving.ball), rolling_ball_at));
    out.scripted_edits.push_back(
        mover("orbit", "a copper cube circles the room, once in 10 seconds", changes.resolve(moving.cube), cube_at));
    out.scripted_edits.push_back(mover("panel", "the large mirror slides and turns", changes.resolve(moving.panel), panel_at));
    const Handle<Material> lamp = changes.resolve(moving.lamp);
    out.scripted_edits.push_back(
        {"light", "the lamp goes through the colours, once in 6 seconds", [lamp, white = out.scene.get(lamp)](const Scene&, double seconds) {
             Material now = white;
             for (int c = 0; c < 3; ++c) {
                 const double wave = 0.5 + 0.5 * std::cos(kTurn * (seconds / 6.0 - double(c) / 3.0));
                 now.emission[c] *= float(0.15 + 0.85 * wave);
             }
             SceneEdit step;
             step.set_material(lamp, std::move(now));
             return step;
         }});
    out.scripted_edits.push_back(switched_materials("ring", "the glowing ring is off every other second", out.scene, {changes.resolve(moving.ring)}));
    return out;
}

}  // namespace parhelion::builtin
