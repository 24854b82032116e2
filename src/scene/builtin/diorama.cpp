// The diorama: a reading nook in the evening sun. What stands in it is in builtin_diorama_*.cpp.
#include "scene/builtin/diorama.h"

#include <cmath>
#include <numbers>

#include "scene/builtin/scripts.h"

namespace parhelion::builtin {

namespace {

// A clear evening outside of the window (-X), low hills, and the dim warm rest of the house behind the camera (+Z).
Environment evening() {
    Environment sky{.name = "evening", .width = 512, .height = 256, .scale = glm::vec3(1.0f)};
    constexpr double kPi = std::numbers::pi;
    for (uint32_t y = 0; y < sky.height; ++y)
        for (uint32_t x = 0; x < sky.width; ++x) {
            const double theta = kPi * (y + 0.5) / sky.height, phi = 2.0 * kPi * ((x + 0.5) / sky.width - 0.5);
            const glm::dvec3 d(std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi));
            const double hills = 0.05 + 0.03 * std::sin(5.0 * phi) + 0.015 * std::sin(13.0 * phi + 1.0);
            glm::dvec3 outside =
                glm::mix(glm::dvec3(470.0, 425.0, 360.0), glm::dvec3(105.0, 185.0, 340.0), std::sqrt(std::clamp(1.6 * d.y, 0.0, 1.0)));
            if (d.y < hills)
                outside = glm::mix(glm::dvec3(95.0, 110.0, 100.0), glm::dvec3(45.0, 58.0, 25.0), std::clamp(-4.0 * d.y, 0.0, 1.0));
            const glm::dvec3 house(62.0, 53.0, 42.0);
            sky.radiance.emplace_back(glm::mix(outside, house, glm::smoothstep(-0.45, 0.1, d.x)));
        }
    return sky;
}

void add_sun(SceneEdit& edit) {
    const glm::vec3 shines = glm::normalize(glm::vec3(0.80f, -0.50f, 0.05f));
    const Handle<Node> node = edit.add(Node{.name = "sun", .local = {.rotation = glm::quatLookAt(shines, glm::vec3(0.0f, 1.0f, 0.0f))}});
    edit.add(Light{.name = "sun",
                   .kind = LightKind::Directional,
                   .color = {1.0f, 0.74f, 0.46f},
                   .intensity = 3700.0f,
                   .angular_radius = 0.00465f,
                   .place = {.node = node}});
}

void add_cameras(SceneEdit& edit) {
    add_camera(edit, "nook", {0.85f, 1.36f, 2.72f}, {-0.19f, 0.84f, -0.9f}, glm::radians(41.0f));
    add_camera(edit, "table", {-0.35f, 0.88f, 0.55f}, {-1.0f, 0.56f, -0.40f}, glm::radians(36.0f));
    add_camera(edit, "window", {0.75f, 1.25f, 0.1f}, {-2.1f, 1.3f, -0.55f}, glm::radians(48.0f));
    add_camera(edit, "shelf", {0.55f, 1.35f, 0.6f}, {1.55f, 1.15f, -1.7f}, glm::radians(48.0f));
    add_camera(edit, "robot", {0.50f, 0.34f, 0.85f}, {0.08f, 0.19f, -0.05f}, glm::radians(38.0f));
}

void add_moving(LoadedScene& out, const DioramaHandles& handles) {
    out.scripted_edits.push_back({"ball", "a ball rolls over the rug and back, once in 8 seconds", [node = handles.ball](const Scene&, double seconds) {
                                      SceneEdit step;
                                      step.set_transform(node, ball_at(seconds));
                                      return step;
                                  }});
    const Transform shut = out.scene.get(handles.door).local;
    out.scripted_edits.push_back(
        {"door", "the left door of the cupboard opens and shuts, once in 6 seconds", [node = handles.door, shut](const Scene&, double seconds) {
             const double open = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * seconds / 6.0);
             Transform local = shut;
             local.rotation = glm::angleAxis(float(glm::radians(-115.0) * open), glm::vec3(0.0f, 1.0f, 0.0f));
             SceneEdit step;
             step.set_transform(node, local);
             return step;
         }});
    out.scripted_edits.push_back({"robot", "the toy robot walks in a circle, once round in 12 seconds", [handles](const Scene&, double seconds) {
                                      SceneEdit step;
                                      step.set_transform(handles.robot, robot_at(seconds));
                                      for (const int side : {0, 1}) {
                                          step.set_transform(handles.arms[side], robot_limb_at(seconds, false, side));
                                          step.set_transform(handles.legs[side], robot_limb_at(seconds, true, side));
                                      }
                                      return step;
                                  }});
    out.scripted_edits.push_back(
        {"lights", "the fairy lights vanish and come again one after the other", [handles](const Scene&, double seconds) {
             SceneEdit step;
             for (size_t i = 0; i < handles.bulbs.size(); ++i) {
                 const double t = seconds / 4.0 - double(i) / double(handles.bulbs.size());
                 const bool there = seconds <= 0.0 || t - std::floor(t) < 0.7;
                 step.set_transform(handles.bulbs[i], {.translation = handles.bulb_places[i], .scale = glm::vec3(there ? 1.0f : 0.0f)});
             }
             return step;
         }});
}

// The camera that pictures start from comes nearer, for blur by its motion.
void add_camera_walk(LoadedScene& out) {
    const Handle<Camera> nook = *out.scene.cameras().handle_at(0);
    const glm::mat4 start = out.scene.get(nook).place.node_from_object;
    out.scripted_edits.push_back({"walk", "the camera \"nook\" comes nearer, 40 cm a second", [nook, start](const Scene&, double seconds) {
                                      glm::mat4 now = start;
                                      now[3] -= float(0.4 * seconds) * start[2];
                                      SceneEdit step;
                                      step.set_transform(nook, now);
                                      return step;
                                  }});
}

// Off and on, each for a second: the shade and the bulb.
void add_lamp_switch(LoadedScene& out) {
    std::vector<Handle<Material>> glowing;
    for (const auto& [handle, material] : out.scene.materials())
        if (material.name.starts_with("lamp ")) glowing.push_back(handle);
    out.scripted_edits.push_back(switched_materials("lamp", "the floor lamp is off every other second", out.scene, std::move(glowing)));
}

}  // namespace

LoadedScene make_diorama(const BuiltinOptions&) {
    SceneEdit edit;
    const Palette palette = add_palette(edit);
    DioramaHandles handles;
    add_room(edit, palette);
    add_window(edit, palette);
    add_armchair(edit, palette);
    add_table(edit, palette);
    add_floor_lamp(edit, palette);
    add_shelf(edit, palette, handles);
    add_plants(edit, palette);
    add_fairy_lights(edit, palette, handles);
    add_toys(edit, palette, handles);
    add_sun(edit);
    edit.set_environment(evening());
    add_cameras(edit);

    LoadedScene out;
    const ChangeSet changes = out.scene.apply(std::move(edit));
    for (Handle<Node>* node :
         {&handles.ball, &handles.door, &handles.robot, &handles.arms[0], &handles.arms[1], &handles.legs[0], &handles.legs[1]})
        *node = changes.resolve(*node);
    for (Handle<Node>& bulb : handles.bulbs) bulb = changes.resolve(bulb);
    add_lamp_switch(out);
    add_moving(out, handles);
    add_camera_walk(out);
    out.scripted_edits.push_back(switched_light("sun", "a cloud hides the sun every other second", out.scene, *out.scene.lights().handle_at(0)));
    return out;
}

}  // namespace parhelion::builtin
