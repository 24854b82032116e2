// The camera that a person steers.
#include <numbers>

#include <gtest/gtest.h>

#include "session/steered_camera.h"

namespace parhelion::steered_camera_test {
namespace {

constexpr float kQuarter = std::numbers::pi_v<float> / 2;

void expect_near(const glm::vec3& a, const glm::vec3& b, float tolerance = 1e-5f) { EXPECT_LE(glm::length(a - b), tolerance) << a.x << " " << a.y << " " << a.z; }

void expect_frame(const CameraView& view) {
    expect_near(glm::cross(view.right, view.up), -view.forward);
    EXPECT_NEAR(glm::length(view.forward), 1.0f, 1e-5f);
    EXPECT_NEAR(glm::length(view.up), 1.0f, 1e-5f);
    EXPECT_NEAR(view.right.y, 0.0f, 1e-6f);  // the horizon is level
}

SteeredCamera camera_in_front() { return {look_at({0, 0, 4}, {0, 0, 0}, 0.8f), 4.0f}; }

TEST(SteeredCamera, an_orbit_keeps_the_target_and_the_distance) {
    SteeredCamera camera = camera_in_front();
    camera.orbit(kQuarter, 0);
    expect_near(camera.target(), {0, 0, 0});
    expect_near(camera.view().position, {-4, 0, 0});  // the camera's eye turns to the right, so it stands on the left
    camera.orbit(0, -kQuarter / 2);
    expect_near(camera.target(), {0, 0, 0});
    EXPECT_NEAR(camera.view().position.y, 4 * std::sin(kQuarter / 2), 1e-5f);
    expect_frame(camera.view());
}

TEST(SteeredCamera, a_look_keeps_the_place_and_never_turns_over) {
    SteeredCamera camera = camera_in_front();
    camera.look(0.3f, 0.2f);
    expect_near(camera.view().position, {0, 0, 4});
    for (int i = 0; i < 20; ++i) camera.look(0.1f, 0.5f);
    EXPECT_GT(camera.view().up.y, 0.0f);
    EXPECT_LT(camera.view().forward.y, 1.0f);
    expect_frame(camera.view());
    for (int i = 0; i < 20; ++i) camera.look(0, -0.5f);
    EXPECT_GT(camera.view().up.y, 0.0f);
    expect_frame(camera.view());
}

// A view straight down has no horizon: its top says where north is.
TEST(SteeredCamera, a_view_straight_down_turns_about_the_vertical) {
    SteeredCamera camera(look_at({0, 4, 0}, {0, 0, 0}, 0.8f), 4.0f);
    const glm::vec3 up = camera.view().up;
    camera.orbit(0, 0.1f);
    EXPECT_GT(glm::dot(camera.view().up, up), 0.9f);
    expect_near(camera.target(), {0, 0, 0});
    expect_frame(camera.view());
}

TEST(SteeredCamera, a_pan_by_the_pictures_height_moves_what_is_at_the_bottom_to_the_top) {
    SteeredCamera camera = camera_in_front();
    camera.pan(0, 1);
    EXPECT_NEAR(camera.view().position.y, 2 * 4 * std::tan(0.4f), 1e-5f);
    expect_near(camera.view().forward, {0, 0, -1});
}

TEST(SteeredCamera, approaches_the_target_and_flies_along_its_axes) {
    SteeredCamera camera = camera_in_front();
    camera.approach(0.5f);
    expect_near(camera.view().position, {0, 0, 2});
    expect_near(camera.target(), {0, 0, 0});
    camera.fly({1, 2, 3});
    expect_near(camera.view().position, {1, 2, -1});
    camera.zoom(1000.0f);
    EXPECT_LT(camera.view().yfov, std::numbers::pi_v<float>);
}

TEST(SteeredCamera, an_orthographic_one_shows_less_when_it_approaches_and_keeps_its_height_in_a_wider_picture) {
    CameraView view = look_at({0, 0, 4}, {0, 0, 0}, 0.8f);
    view.orthographic = true;
    view.half_extents = {2, 2};
    SteeredCamera camera(view, 4.0f);
    camera.approach(0.5f);
    camera.set_aspect(2.0f);
    EXPECT_EQ(camera.view().half_extents, glm::vec2(2, 1));
    expect_near(camera.view().position, {0, 0, 4});
}

// What the viewer copies as options: from, at and the angle give the very camera.
TEST(SteeredCamera, one_that_has_moved_is_the_camera_of_two_points) {
    SteeredCamera camera(look_at({30, 4, -27}, {30.5f, 4, -26}, 0.8f), 0.01f);
    EXPECT_FALSE(camera.has_moved());
    const auto expect_two_points = [&] {
        const CameraView again = look_at(camera.view().position, camera.aim(), camera.view().yfov);
        EXPECT_EQ(camera.view().forward, again.forward);
        EXPECT_EQ(camera.view().right, again.right);
        EXPECT_EQ(camera.view().up, again.up);
        EXPECT_TRUE(camera.has_moved());
    };
    camera.orbit(0.3f, 0.1f), expect_two_points();
    camera.look(-0.7f, 0.2f), expect_two_points();
    camera.pan(0.1f, -0.2f), expect_two_points();
    camera.approach(0.001f), expect_two_points();
    camera.fly({1, 2, 3}), expect_two_points();
    camera.zoom(0.5f), expect_two_points();
    const glm::vec3 before = camera.view().forward;
    for (int i = 0; i < 1000; ++i) camera.fly({0, 0, 1e-3f});
    EXPECT_GT(glm::dot(before, camera.view().forward), 1.0f - 1e-5f);  // and does not drift
}

TEST(SteeredCamera, looks_at_a_new_target_and_turns_about_it) {
    SteeredCamera camera = camera_in_front();
    camera.set_target({1, 1, 0});
    expect_near(camera.view().position, {0, 0, 4});
    expect_near(camera.target(), {1, 1, 0});
    expect_near(camera.view().forward, glm::normalize(glm::vec3(1, 1, -4)));
    expect_frame(camera.view());
    camera.orbit(kQuarter, 0);
    expect_near(camera.target(), {1, 1, 0});
}

TEST(SteeredCamera, orbits_begin_about_the_middle_of_the_scene_if_it_lies_ahead) {
    const Bounds box{.min = {-1, -1, -1}, .max = {1, 1, 1}};
    EXPECT_NEAR(orbit_distance(look_at({0, 0, 4}, {0, 0, 0}, 0.8f), box), 4.0f, 1e-5f);
    EXPECT_GT(orbit_distance(look_at({0, 0, 4}, {0, 0, 8}, 0.8f), box), 0.0f);
    EXPECT_GT(orbit_distance(look_at({0, 0, 4}, {0, 0, 0}, 0.8f), Bounds{}), 0.0f);
}

}  // namespace
}  // namespace parhelion::steered_camera_test
