// Every built-in scene as a picture, and darkness where it belongs.
#include <gtest/gtest.h>

#include "support/render_fixture.h"

namespace parhelion::testing::builtin_scenes_test {
namespace {

class BuiltinPictures : public GpuTest {};

CameraView camera_named(const Scene& scene, std::string_view name) {
    for (const auto& [handle, camera] : scene.cameras())
        if (camera.name == name) return view_of(camera, 1.0f);
    throw Error(ErrorCode::Failed, "no such camera");
}

}  // namespace

TEST_F(BuiltinPictures, every_scene_gives_a_finite_picture_that_is_not_black) {
    for (const BuiltinEntry& entry : builtin_scenes()) {
        SCOPED_TRACE(entry.name);
        Stage stage(make_builtin(entry.name, {.triangles = 20'000}).scene, {.hardware = false, .own_bvh = true});
        const image::ImageF picture = stage.picture({.sample_count = 4});
        expect_sane(picture);
        EXPECT_GT(mean_rgb(picture), 1e-3);
    }
}

TEST_F(BuiltinPictures, a_shut_leak_box_is_black_inside_and_light_enters_by_its_door) {
    LoadedScene loaded = make_builtin("builtin:leak-box");
    Stage stage(std::move(loaded.scene), {.hardware = false, .own_bvh = true});
    for (const char* name : {"inside 1 cm", "inside 5 cm", "inside 20 cm"})
        EXPECT_EQ(mean_rgb(stage.picture({.camera = camera_named(stage.scene, name), .sample_count = 16})), 0.0) << name;
    EXPECT_GT(mean_rgb(stage.picture({.camera = camera_named(stage.scene, "outside"), .sample_count = 4})), 10.0);
    stage.step(loaded.scripted_edits.at(1).apply(stage.scene, 2.0));
    EXPECT_GT(mean_rgb(stage.picture({.camera = camera_named(stage.scene, "inside 5 cm"), .sample_count = 16})), 1.0);
    EXPECT_EQ(mean_rgb(stage.picture({.camera = camera_named(stage.scene, "inside 20 cm"), .sample_count = 16})), 0.0);
    stage.step(loaded.scripted_edits.at(0).apply(stage.scene, 1.5));
    EXPECT_EQ(mean_rgb(stage.picture({.camera = camera_named(stage.scene, "inside 5 cm"), .sample_count = 4})), 0.0);
}

}  // namespace parhelion::testing::builtin_scenes_test
