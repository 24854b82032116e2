// The camera of a render over its shutter, and what its lens is focused on.
#include "session/camera_setup.h"

#include <cmath>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/file.h"
#include "scene/builtin/scenes.h"
#include "scene/load.h"
#include "scene/pose.h"
#include "scene/shapes.h"

namespace parhelion::camera_setup_test {
namespace {

std::string error_line(const std::function<void()>& run) {
    try {
        run();
    } catch (const Error& error) {
        return error.line;
    }
    return "(no error)";
}

void add_wall(SceneEdit& edit, float z, const Material& material, const glm::mat4& place = glm::mat4(1.0f)) {
    Primitive wall;
    add_quad(wall, {-1, -1, z}, {2, 0, 0}, {0, 2, 0});  // faces +Z
    edit.set_transform(builtin::add_object(edit, "wall", std::move(wall), edit.add(Material(material))), place);
}

LoadedScene scene_of(SceneEdit edit) {
    LoadedScene loaded;
    loaded.scene.apply(std::move(edit));
    return loaded;
}

const CameraView kAlongMinusZ = look_at({0.2f, 0.1f, 0}, {0.2f, 0.1f, -1}, 0.8f);

TEST(CameraSetup, the_focus_is_the_nearest_surface_in_the_middle_of_the_picture) {
    SceneEdit edit;
    add_wall(edit, -5.0f, builtin::lambert("far", glm::vec3(0.5f)));
    add_wall(edit, -1.0f, builtin::lambert("near", glm::vec3(0.5f)), glm::translate(glm::scale(glm::mat4(1.0f), glm::vec3(3.0f)), {0, 0, 0.25f}));
    add_wall(edit, -1.0f, builtin::lambert("aside", glm::vec3(0.5f)), glm::translate(glm::mat4(1.0f), {3, 0, 0}));
    const LoadedScene loaded = scene_of(std::move(edit));
    EXPECT_NEAR(find_focus(loaded.scene, kAlongMinusZ, true), 2.25f, 1e-6f);
    const CameraView backwards = look_at({0.2f, 0.1f, 0}, {0.2f, 0.1f, 1}, 0.8f);
    EXPECT_NE(error_line([&] { find_focus(loaded.scene, backwards, true); }).find("--aperture-radius: nothing lies in the middle of the picture to focus on (add --focus-distance METRES)"),
              std::string::npos);
}

TEST(CameraSetup, what_is_culled_from_behind_is_no_focus) {
    Material plain = builtin::lambert("plain", glm::vec3(0.5f)), both = plain, glass = plain;
    both.double_sided = true;
    glass.transmission = 1.0f;
    const glm::mat4 away = glm::translate(glm::mat4(1.0f), {0, 0, -1}) * glm::rotate(glm::mat4(1.0f), glm::radians(180.0f), glm::vec3(0, 1, 0));
    for (const Material* behind : {&plain, &both, &glass}) {
        SceneEdit edit;
        add_wall(edit, 0.0f, *behind, away);
        add_wall(edit, -4.0f, plain);
        const LoadedScene loaded = scene_of(std::move(edit));
        EXPECT_NEAR(find_focus(loaded.scene, kAlongMinusZ, true), behind == &plain ? 4.0f : 1.0f, 1e-6f);
        EXPECT_NEAR(find_focus(loaded.scene, kAlongMinusZ, false), 1.0f, 1e-6f);
    }
}

TEST(CameraSetup, a_lens_is_focused_where_the_options_say_or_else_on_the_middle) {
    SceneEdit edit;
    add_wall(edit, -5.0f, builtin::lambert("wall", glm::vec3(0.5f)));
    LoadedScene loaded = scene_of(std::move(edit));
    RenderOptions options;
    options.look_from = {0, 0, 0};
    options.look_at = {0, 0, -1};
    std::string description;
    EXPECT_EQ(set_up_camera(loaded, options, true, description).opens.lens_radius, 0.0f);
    options.aperture_radius = 0.25;
    const MovingCamera middle = set_up_camera(loaded, options, true, description);
    EXPECT_EQ(middle.opens.lens_radius, 0.25f);
    EXPECT_FLOAT_EQ(middle.opens.focus_distance, 5.0f);
    EXPECT_FALSE(middle.closes);
    options.focus_distance = 2.5;
    EXPECT_EQ(set_up_camera(loaded, options, true, description).opens.focus_distance, 2.5f);
}

TEST(CameraSetup, over_the_shutter_the_camera_goes_where_its_animation_takes_it_and_the_scene_stays) {
    SceneEdit edit;
    const Handle<Node> rig = edit.add(Node{.name = "rig"});
    Camera camera{.name = "camera"};
    camera.place.node = rig;
    camera.place.node_from_object = glm::translate(glm::mat4(1.0f), {0, 1, 0});
    edit.add(std::move(camera));
    edit.add(Animation{.name = "ride", .channels = {{.node = rig, .times = {0, 4}, .values = {0, 0, 0, 8, 0, 0}}}});
    LoadedScene loaded = scene_of(std::move(edit));
    RenderOptions options;
    options.load.time = 0;
    options.shutter_seconds = 0.5;
    std::string description;
    MovingCamera moving = set_up_camera(loaded, options, true, description);
    EXPECT_EQ(description, "camera");
    ASSERT_TRUE(moving.closes);
    EXPECT_EQ(moving.opens.position, glm::vec3(0, 1, 0));
    EXPECT_EQ(moving.closes->position, glm::vec3(1, 1, 0));
    EXPECT_EQ(loaded.scene.get((*loaded.scene.cameras().begin()).handle).place.world_from_object[3], glm::vec4(0, 1, 0, 1));
    options.load.time = 5;  // beyond the last key: nothing moves
    loaded.scene.apply(pose_at(loaded.scene, 5.0));
    options.fov_degrees = 30;
    EXPECT_FALSE(set_up_camera(loaded, options, true, description).closes);
}

TEST(CameraSetup, over_the_shutter_a_scripted_edit_moves_the_camera_and_the_scene_stays) {
    LoadOptions load;
    load.animate = "walk";
    load.time = 0.5;
    LoadedScene loaded = load_scene("builtin:diorama", load);
    RenderOptions options;
    options.load = load;
    options.shutter_seconds = 0.25;
    std::string description;
    const Camera before = loaded.scene.get((*loaded.scene.cameras().begin()).handle);
    const MovingCamera moving = set_up_camera(loaded, options, true, description);
    ASSERT_TRUE(moving.closes);
    const glm::vec3 step = moving.closes->position - moving.opens.position;
    EXPECT_NEAR(glm::length(step), 0.1f, 1e-5f);
    EXPECT_NEAR(glm::dot(glm::normalize(step), moving.opens.forward), 1.0f, 1e-5f);
    EXPECT_EQ(loaded.scene.get((*loaded.scene.cameras().begin()).handle).place.world_from_object, before.place.world_from_object);
}

TEST(CameraSetup, a_path_is_a_camera_for_any_scene) {
    const std::filesystem::path file = std::filesystem::temp_directory_path() / "parhelion_camera_setup.json";
    write_text_file(file, R"({"keys": [{"time": 0, "look_from": [0, 0, 5], "look_at": [0, 0, 0]}, {"time": 2, "look_from": [4, 0, 5], "look_at": [0, 0, 0]}]})");
    LoadedScene loaded = scene_of({});
    RenderOptions options;
    options.camera_path = file;
    options.load.time = 1;
    options.shutter_seconds = 0.5;
    options.fov_degrees = 90;
    std::string description;
    const MovingCamera moving = set_up_camera(loaded, options, true, description);
    std::filesystem::remove(file);
    EXPECT_EQ(description, "(--camera-path)");
    EXPECT_EQ(moving.opens.position, glm::vec3(2, 0, 5));
    ASSERT_TRUE(moving.closes);
    EXPECT_EQ(moving.closes->position, glm::vec3(3, 0, 5));
    EXPECT_FLOAT_EQ(moving.closes->yfov, glm::radians(90.0f));
}

}  // namespace
}  // namespace parhelion::camera_setup_test
