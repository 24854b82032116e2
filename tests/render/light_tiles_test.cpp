// Light tiles against the reference's own choice of lights, where only one lamp can be chosen: what a tile says of it may cost variance, and
// must not show.
#include <algorithm>
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/realtime_player.h"
#include "support/statistics.h"

namespace parhelion::testing::light_tiles_test {
namespace {

// From dim to bright, in colours of which tiles keep each channel by itself.
struct Glow {
    float nits;
    glm::vec3 color;
};
const Glow kGlows[] = {{0.1f, {1, 0, 0}},     {1.3f, {0, 0, 1}},       {7.0f, {1, 1, 1}},      {55.0f, {0, 1, 0}},
                       {410.0f, {1, 0, 0.01f}}, {3000.0f, {0.3f, 0.6f, 1}}, {21000.0f, {1e-3f, 1, 1}}, {60000.0f, {1, 0.5f, 0.02f}}};

class LightTiles : public GpuTest {
protected:
    // A closed room of 4 x 3 x 4 metres, white, so that it takes every colour.
    static SceneEdit room() {
        SceneEdit edit;
        Primitive walls;
        add_box(walls, {-2, 0, -2}, {2, 3, 2}, Facing::In);
        builtin::add_object(edit, "walls", std::move(walls), edit.add(builtin::lambert("white", glm::vec3(0.6f))));
        builtin::add_camera(edit, "inside", {-1.5f, 1.6f, 1.6f}, {0.5f, 0.8f, -1.0f}, 1.1f);
        return edit;
    }
    static Shot shot(uint32_t frames, uint32_t seed) {
        return {.view = {.width = 16, .height = 16, .seed = seed, .max_bounces = 1, .filter = PixelFilter::Point}, .sample_count = frames};
    }
    // The pictures with tiles and without, of the same numbers but for the light sample at the first surface.
    static std::pair<image::ImageF, image::ImageF> both(Stage& stage, const Shot& shot, float exposure) {
        RealtimeOptions options{.cache = false, .exposure = exposure};
        const image::ImageF with = image::resolve_film(stage.play(shot, options));
        options.tiles = false;
        return {with, image::resolve_film(stage.play(shot, options))};
    }
};

// A light without extent has one sample: the picture is the same, pixel by pixel and channel by channel, to the signals' 14 bits.
TEST_F(LightTiles, of_one_point_light_change_no_pixel_whatever_its_strength_and_colour) {
    SceneEdit edit = room();
    const Handle<Light> pending = edit.add(Light{.kind = LightKind::Point});
    Scene scene;
    const Handle<Light> lamp = scene.apply(std::move(edit)).resolve(pending);
    Stage stage(std::move(scene));
    for (const Glow& glow : kGlows) {
        SCOPED_TRACE(glow.nits);
        SceneEdit step;
        step.set_light(lamp, {.kind = LightKind::Point, .color = glow.color, .intensity = glow.nits});
        step.set_transform(lamp, glm::translate(glm::mat4(1.0f), {0.4f, 2.3f, -0.3f}));
        stage.step(std::move(step));
        const auto [with, without] = both(stage, shot(2, 1), 1.0f / glow.nits);
        EXPECT_GT(mean_rgb(without), 0.0);
        for (size_t i = 0; i < with.data.size(); ++i) ASSERT_NEAR(with.data[i], without.data[i], 0x1p-12 * without.data[i] + 1e-9) << i;
    }
}

// A lamp with extent: the same in the mean of independent runs, and no pixel stays dark that sees it. Colours draw the same numbers, so one run
// of each says whether it is as good as the white one.
TEST_F(LightTiles, of_one_lamp_change_no_mean_whatever_its_strength_and_colour) {
    SceneEdit edit = room();
    Primitive square;
    add_quad(square, {0.35f, 2.9f, -0.35f}, {0.1f, 0, 0}, {0, 0, 0.1f});
    const Handle<Material> pending = edit.add(builtin::lambert("lamp", glm::vec3(0.0f)));
    builtin::add_object(edit, "lamp", std::move(square), pending);
    Scene scene;
    const Handle<Material> lamp = scene.apply(std::move(edit)).resolve(pending);
    Stage stage(std::move(scene));
    const auto ratio = [&](glm::vec3 nits, uint32_t seed) {
        SceneEdit step;
        step.set_material(lamp, builtin::lambert("lamp", glm::vec3(0.0f), nits));
        stage.step(std::move(step));
        const auto [with, without] = both(stage, shot(4, seed), 1.0f / std::max({nits.x, nits.y, nits.z}));
        for (size_t p = 0; p < with.pixel_count(); ++p) EXPECT_TRUE(luminance_of(without, p) == 0 || luminance_of(with, p) > 0) << p;
        return mean_luminance(with) / mean_luminance(without);
    };
    std::vector<double> white;
    for (uint32_t seed = 1; seed <= 6; ++seed) white.push_back(ratio(glm::vec3(10.0f), seed));
    expect_mean(white, 1.0, 1e-3, "with tiles over without");
    for (const Glow& glow : kGlows) EXPECT_NEAR(ratio(glow.nits * glow.color, 1), white[0], 1e-4) << glow.nits;
}

// A lamp as large as the ceiling is found by light samples and by the surface's own about as often, and is counted once.
TEST_F(LightTiles, of_a_lamp_as_large_as_the_ceiling_count_its_light_once) {
    SceneEdit edit = room();
    Primitive square;
    add_quad(square, {-1.9f, 2.5f, -1.9f}, {3.8f, 0, 0}, {0, 0, 3.8f});
    builtin::add_object(edit, "lamp", std::move(square), edit.add(builtin::lambert("lamp", glm::vec3(0.0f), glm::vec3(1.0f))));
    Stage stage(make_scene(std::move(edit)));
    std::vector<double> ratios;
    for (uint32_t run = 0; run < 6; ++run) {
        const auto [with, without] = both(stage, shot(16, 1 + run), 1.0f);
        ratios.push_back(mean_luminance(with) / mean_luminance(without));
    }
    expect_mean(ratios, 1.0, 0.02, "with tiles over without");
}

}  // namespace
}  // namespace parhelion::testing::light_tiles_test
