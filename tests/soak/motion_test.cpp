// Motion of real models that skins and morph targets deform, against geometry in double.
#include <cstdio>
#include <cstdlib>
#include <ostream>

#include "scene/camera.h"
#include "scene/load.h"
#include "scene/pose.h"
#include "support/motion_check.h"

namespace parhelion::testing::motion_test {
namespace {

struct Model {
    const char* file;
    double seconds;  // at which it moves
};
std::ostream& operator<<(std::ostream& out, const Model& model) { return out << model.file; }
constexpr Model kModels[] = {{"cesium_man/CesiumMan.glb", 0.5}, {"fox/Fox.glb", 0.5}, {"morph_stress/MorphStressTest.gltf", 0.5}};

class ModelMotion : public GpuTest, public ::testing::WithParamInterface<Model> {};

TEST_P(ModelMotion, leads_to_where_the_surface_was) {
    const char* folder = std::getenv("PARHELION_ASSETS");
    if (!folder) GTEST_SKIP() << "PARHELION_ASSETS does not name the folder of real models";
    Stage stage(load_scene(std::string(folder) + "/" + GetParam().file).scene);
    stage.step(pose_at(stage.scene, GetParam().seconds));
    stage.scene_gpu.finish(stage.frame);
    const Scene before = stage.scene;
    stage.step(pose_at(stage.scene, GetParam().seconds + 1.0 / 30.0));
    const CameraView camera = framing_view(stage.scene.bounds(), 1.0f);
    const Shot shot{.view = {.width = 256, .height = 256, .max_bounces = 1, .aovs = {"depth", "ids", "motion"}}, .camera = camera, .sample_count = 1};
    const MotionFound found = check_motion(stage.scene, before, camera, stage.render(shot));
    ASSERT_GT(found.off.size(), 1000u);
    std::printf("%s: %zu pixels, the fastest moves %.2f px; off by %.4f px (95 %%), %.4f px (most)\n", GetParam().file, found.off.size(), found.moved, found.off[found.off.size() * 95 / 100], found.off.back());
    EXPECT_LE(found.off[found.off.size() * 95 / 100], 0.25);
    EXPECT_GT(found.moved, 0.2) << "it stands still";
}

INSTANTIATE_TEST_SUITE_P(Of, ModelMotion, ::testing::ValuesIn(kModels), [](const auto& entry) {
    const std::string file = entry.param.file;
    return file.substr(0, file.find('/'));
});

}  // namespace
}  // namespace parhelion::testing::motion_test
