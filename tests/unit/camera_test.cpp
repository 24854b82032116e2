// Cameras: frames, matrices, aspect rules, and finding them.
#include "scene/camera.h"

#include <gtest/gtest.h>

#include <cmath>

namespace parhelion::camera_test {

namespace {

void expect_near(glm::vec3 a, glm::vec3 b, float tolerance = 1e-5f) {
    EXPECT_LT(glm::length(a - b), tolerance) << "(" << a.x << ", " << a.y << ", " << a.z << ") instead of (" << b.x << ", " << b.y << ", "
                                             << b.z << ")";
}

void expect_orthonormal(const CameraView& view) {
    expect_near(glm::cross(view.right, view.up), -view.forward);
    EXPECT_NEAR(glm::length(view.right), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::length(view.forward), 1.0f, 1e-6f);
    EXPECT_NEAR(glm::dot(view.right, view.forward), 0.0f, 1e-6f);
}

// Normalised device coordinates of a world point.
glm::vec3 project(const CameraView& view, float aspect, glm::vec3 p) {
    const glm::vec4 clip = clip_from_world(view, aspect) * glm::vec4(p, 1.0f);
    return glm::vec3(clip) / clip.w;
}

Camera placed(glm::mat4 world) {
    Camera camera;
    camera.place.world_from_object = world;
    return camera;
}

}  // namespace

TEST(Camera, look_at_has_its_target_in_the_middle_and_y_up) {
    const CameraView view = look_at({1, 2, 3}, {4, 2, 3}, 0.5f);
    expect_orthonormal(view);
    expect_near(view.forward, {1, 0, 0});
    expect_near(view.right, {0, 0, 1});
    expect_near(view.up, {0, 1, 0});
    const glm::vec3 middle = project(view, 1.5f, {4, 2, 3});
    EXPECT_NEAR(middle.x, 0.0f, 1e-6f);
    EXPECT_NEAR(middle.y, 0.0f, 1e-6f);
}

TEST(Camera, looking_straight_up_or_down_still_has_a_frame) {
    for (const float y : {1.0f, -1.0f}) {
        const CameraView view = look_at({0, 0, 0}, {0, y, 0}, 0.5f);
        expect_orthonormal(view);
        expect_near(view.forward, {0, y, 0});
        expect_near(view.right, {1, 0, 0});
    }
    expect_near(look_at({0, 5, 0}, {0, 0, 0}, 0.5f).up, {0, 0, -1});
    EXPECT_THROW(look_at({1, 1, 1}, {1, 1, 1}, 0.5f), Error);
}

TEST(Camera, perspective_depth_is_one_at_the_near_plane_and_falls_to_zero) {
    CameraView view = look_at({0, 0, 0}, {0, 0, -1}, glm::radians(90.0f));
    view.near_plane = 0.5f;
    EXPECT_FLOAT_EQ(project(view, 2.0f, {0, 0, -0.5f}).z, 1.0f);
    EXPECT_FLOAT_EQ(project(view, 2.0f, {0, 0, -5.0f}).z, 0.1f);
    EXPECT_NEAR(project(view, 2.0f, {0, 0, -1e9f}).z, 0.0f, 1e-8f);
}

TEST(Camera, image_edges_follow_the_vertical_angle_and_the_aspect_with_y_down_in_clip_space) {
    const CameraView view = look_at({0, 0, 0}, {0, 0, -1}, glm::radians(90.0f));
    const glm::vec3 top = project(view, 2.0f, {0, 3, -3}), right = project(view, 2.0f, {6, 0, -3});
    EXPECT_NEAR(top.y, -1.0f, 1e-6f);
    EXPECT_NEAR(right.x, 1.0f, 1e-6f);
    EXPECT_NEAR(view.image_half_extents(2.0f).x, 2.0f, 1e-6f);
    EXPECT_NEAR(view.image_half_extents(2.0f).y, 1.0f, 1e-6f);
}

TEST(Camera, of_gltf_looks_along_minus_z_of_its_placement_and_ignores_scale_and_mirroring) {
    const CameraView plain = view_of(placed(glm::mat4(1.0f)), 1.0f);
    expect_near(plain.forward, {0, 0, -1});
    expect_near(plain.right, {1, 0, 0});
    glm::mat4 world(0.0f);
    world[0] = {0, 0, -3, 0};  // x axis to -z: looks along -x ... scaled by 3, 2 and 5
    world[1] = {0, 2, 0, 0};
    world[2] = {5, 0, 0, 0};
    world[3] = {1, 2, 3, 1};
    const CameraView turned = view_of(placed(world), 1.0f);
    expect_orthonormal(turned);
    expect_near(turned.forward, {-1, 0, 0});
    expect_near(turned.right, {0, 0, -1});
    expect_near(turned.position, {1, 2, 3});
    world[0] = -world[0];
    expect_near(view_of(placed(world), 1.0f).right, {0, 0, -1});
}

TEST(Camera, perspective_keeps_its_vertical_angle_at_every_aspect) {
    Camera camera = placed(glm::mat4(1.0f));
    camera.yfov = 1.1f;
    for (const float aspect : {0.5f, 1.0f, 3.0f}) {
        EXPECT_EQ(view_of(camera, aspect).yfov, 1.1f);
        EXPECT_NEAR(view_of(camera, aspect).image_half_extents(aspect).x, aspect * std::tan(0.55f), 1e-5f);
    }
}

TEST(Camera, orthographic_shows_all_of_its_extents_undistorted) {
    Camera camera = placed(glm::mat4(1.0f));
    camera.kind = CameraKind::Orthographic;
    camera.xmag = 4.0f;
    camera.ymag = 1.0f;
    camera.near_plane = 1.0f;
    camera.far_plane = 11.0f;
    for (const float aspect : {0.5f, 4.0f, 8.0f}) {
        const CameraView view = view_of(camera, aspect);
        const glm::vec2 half = view.image_half_extents(aspect);
        EXPECT_FLOAT_EQ(half.x / half.y, aspect);
        EXPECT_GE(half.x, 4.0f);
        EXPECT_GE(half.y, 1.0f);
        EXPECT_TRUE(half.x == 4.0f || half.y == 1.0f);
        EXPECT_FLOAT_EQ(project(view, aspect, {half.x, 0, -1}).x, 1.0f);
        EXPECT_FLOAT_EQ(project(view, aspect, {0, half.y, -1}).y, -1.0f);
        EXPECT_FLOAT_EQ(project(view, aspect, {0, 0, -1}).z, 1.0f);
        EXPECT_NEAR(project(view, aspect, {0, 0, -11}).z, 0.0f, 1e-6f);
    }
}

TEST(Camera, framing_has_every_corner_in_the_image_and_little_room_to_spare) {
    const Bounds boxes[] = {
        {{-1, -1, -1}, {1, 1, 1}}, {{10, 0, 5}, {11, 0, 500}}, {{-1e-4f, 0, 0}, {1e-4f, 2e-4f, 1e-4f}}, {{0, 0, 0}, {0, 1e5f, 0}}};
    for (const Bounds& box : boxes)
        for (const float aspect : {0.4f, 1.0f, 1.78f}) {
            const CameraView view = framing_view(box, aspect);
            float extreme = 0.0f;
            for (int corner = 0; corner < 8; ++corner) {
                const glm::vec3 p(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y,
                                  corner & 4 ? box.max.z : box.min.z);
                EXPECT_GT(glm::dot(p - view.position, view.forward), 0.0f);
                const glm::vec3 ndc = project(view, aspect, p);
                extreme = std::max({extreme, std::abs(ndc.x), std::abs(ndc.y)});
            }
            EXPECT_LT(extreme, 1.0f);
            EXPECT_GT(extreme, 0.85f);
        }
    EXPECT_NO_THROW(framing_view(Bounds{}, 1.0f));
    EXPECT_NO_THROW(framing_view(Bounds{{2, 2, 2}, {2, 2, 2}}, 1.0f));
}

TEST(Camera, is_found_by_name_or_number_and_else_all_are_listed) {
    Scene scene;
    SceneEdit edit;
    edit.add(Camera{.name = "left"});
    edit.add(Camera{.name = "0"});
    edit.add(Camera{});
    scene.apply(std::move(edit));
    EXPECT_EQ(find_camera(scene, "left").index, 0u);
    EXPECT_EQ(find_camera(scene, "0").index, 1u);  // names come first
    EXPECT_EQ(find_camera(scene, "2").index, 2u);
    for (const char* wrong : {"right", "3", "-1", "1x", "", "99999999999999999999"}) {
        try {
            find_camera(scene, wrong);
            FAIL() << wrong;
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Usage);
            EXPECT_NE(error.line.find("cameras: 0 'left', 1 '0', 2 ''"), std::string::npos) << error.line;
        }
    }
    EXPECT_THROW(find_camera(Scene(), "0"), Error);
}

}  // namespace parhelion::camera_test
