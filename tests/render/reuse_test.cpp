// Reservoirs: what varies between machines changes no picture. That their means are the reference's is tested by ./dev truth.
#include <algorithm>

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/film_state.h"
#include "support/render_fixture.h"

namespace parhelion::testing::reuse_test {
namespace {

class Reuse : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    }
};

TEST_F(Reuse, pictures_do_not_depend_on_how_many_paths_are_traced_at_a_time_and_repeat) {
    Stage& stage = builtin_stage("builtin:cornell");
    const Shot shot{.way = gpu::TraceWay::Compute, .view = {.width = 24, .height = 28, .filter = PixelFilter::Point}, .sample_count = 4};
    const RealtimeOptions options{.reuse = RealtimeReuse::Full, .reuse_options = {.adapt_confidence = false}};
    const image::ImageF whole = image::resolve_film(stage.play(shot, options)), again = image::resolve_film(stage.play(shot, options));
    RealtimeOptions bands = options, without_history = options;
    bands.slots = 24 * 8;  // the last of them has four rows
    without_history.reuse_options.confidence = 0;
    RealtimeOptions adapted = options;
    adapted.reuse_options.adapt_confidence = true;  // to a room with one lamp
    const image::ImageF without = image::resolve_film(stage.play(shot, adapted));
    const image::ImageF in_bands = image::resolve_film(stage.play(shot, bands)), other = image::resolve_film(stage.play(shot, without_history));
    bool differs = false;
    for (size_t c = 0; c < whole.channels.size(); ++c) {
        EXPECT_TRUE(std::ranges::equal(whole.plane(c), again.plane(c))) << whole.channels[c];
        EXPECT_TRUE(std::ranges::equal(whole.plane(c), in_bands.plane(c))) << whole.channels[c];
        EXPECT_TRUE(std::ranges::equal(other.plane(c), without.plane(c))) << whole.channels[c] << ": no temporal reuse where one lamp is";
        differs = differs || !std::ranges::equal(whole.plane(c), other.plane(c));
    }
    EXPECT_TRUE(differs) << "the last frame's reservoirs are used";
}

// A wall under a lamp that is turned up: the last frame's samples were of a weaker one, and must not stand in for what is new.
TEST_F(Reuse, a_lamp_that_is_turned_up_shines_in_the_same_frame) {
    SceneEdit edit;
    Primitive wall;
    add_quad(wall, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
    builtin::add_object(edit, "wall", std::move(wall), edit.add(builtin::lambert("wall", glm::vec3(0.5f))));
    const Light weak{.intensity = 10.0f, .place = {.node_from_object = glm::translate(glm::mat4(1.0f), {0.0f, 2.0f, 0.0f})}};
    edit.add(weak);
    Stage stage(make_scene(std::move(edit)));
    const Shot shot{.view = {.width = 16, .height = 16, .filter = PixelFilter::Point}, .camera = camera_from_above(2.0f, 1.0f)};
    View view = stage.make_view(shot);
    stage.scene_gpu.finish(stage.frame);
    stage.step({});  // the scene stood there before, so that what it shows has a past
    stage.scene_gpu.finish(stage.frame);
    Realtime realtime(stage.frame.device(), view, {.reuse = RealtimeReuse::Full, .reuse_options = {.adapt_confidence = false}});
    const auto draw = [&] {
        view.clear_film();
        realtime.record(stage.frame, stage.scene_gpu, shot.way, view, true);
        stage.frame.run();
        return mean_rgb(image::resolve_film(make_film_sums(view.read_film(stage.frame), {16, 16}, {0, 1}, {})));
    };
    double before = 0.0;
    for (int i = 0; i < 10; ++i) before = draw();
    SceneEdit up;
    Light bright = weak;
    bright.intensity *= 10.0f;
    up.set_light(*stage.scene.lights().handle_at(0), bright);
    stage.step(std::move(up));
    stage.scene_gpu.finish(stage.frame);
    EXPECT_NEAR(draw() / before, 10.0, 0.2);
}

}  // namespace
}  // namespace parhelion::testing::reuse_test
