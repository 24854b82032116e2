// The picture's history by surface: what moves leaves nothing behind, and edges that stand still become as smooth as a box over each pixel has
// them. On light without noise: surfaces that shine. No test here depends on chance: seeds are fixed.
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/realtime_player.h"

namespace parhelion::testing::antialias_test {
namespace {

constexpr uint32_t kSize = 64;
constexpr float kDistance = 4.0f, kWallNits = 0.3f;
const float kYfov = glm::radians(40.0f);
const float kPixel = 2.0f * kDistance * std::tan(0.5f * kYfov) / kSize;  // metres of the wall

Handle<Material> shining(SceneEdit& edit, float nits) { return edit.add(builtin::lambert("shining", glm::vec3(0.0f), glm::vec3(nits))); }
void add_wall(SceneEdit& edit) {
    Primitive wall;
    add_quad(wall, {-8, -8, 0}, {16, 0, 0}, {0, 16, 0});
    builtin::add_object(edit, "wall", std::move(wall), shining(edit, kWallNits));
}

Shot shot_of() { return {.view = {.width = kSize, .height = kSize, .seed = 1, .max_bounces = 1, .filter = PixelFilter::Point}, .camera = look_at({0, 0, kDistance}, glm::vec3(0.0f), kYfov)}; }
RealtimeOptions options_of(double upscale) { return {.tiles = false, .cache = false, .exposure = 1.0f, .reconstruction = ReconstructionOptions(), .upscale = upscale}; }

// What pixels show whose boxes are sampled all over.
image::ImageF box_picture(Stage& stage) {
    Shot box = shot_of();
    box.view.filter = PixelFilter::Box;
    box.view.max_bounces = 0;
    box.sample_count = 1024;
    return stage.picture(box);
}

using Antialiasing = GpuTest;

// Chequers of three pixels, so that the light around admits much: as bright as the wall, and a quarter of it.
void add_chequered_wall(SceneEdit& edit) {
    Image image{.name = "chequers", .width = 2, .height = 2, .texels = {}};
    for (int i = 0; i < 16; ++i) image.texels.push_back(i % 4 == 3 || i / 4 == 0 || i / 4 == 3 ? 255 : 137);  // sRGB
    Material material = builtin::lambert("chequered", glm::vec3(0.0f), glm::vec3(kWallNits));
    material.emissive_texture.texture = edit.add(Texture{.image = edit.add(std::move(image)), .sampler = {.mag = Filter::Nearest, .min = Filter::Nearest}});
    Primitive wall;
    const float side = 192.0f * kPixel;
    add_textured_quad(wall, {-0.5f * side, -0.5f * side, 0}, {side, 0, 0}, {0, side, 0}, glm::vec2(32.0f));
    builtin::add_object(edit, "wall", std::move(wall), edit.add(std::move(material)));
}

// A ball rests, and then goes to and fro along the wall. Two frames after it was there a pixel shows the wall, and is no brighter.
TEST_F(Antialiasing, what_has_moved_away_leaves_nothing_behind) {
    constexpr float kRadius = 0.35f;
    for (const double upscale : {1.0, 2.0}) {
        SceneEdit edit;
        add_chequered_wall(edit);
        const Handle<Node> made = builtin::place_object(edit, "ball", make_sphere(kRadius, 24, true), shining(edit, 3.0f), {.translation = {0, 0, kRadius}});
        Scene scene;
        const Handle<Node> ball = scene.apply(std::move(edit)).resolve(made);
        Stage stage(std::move(scene));
        Player player(stage, shot_of(), options_of(upscale));
        const auto x_m = [](uint32_t frame) { return kPixel * 5.37f * (std::abs(static_cast<float>(std::max(frame, 12u) % 12) - 6.0f) - 3.0f); };
        const auto distance_px = [&](uint32_t frame, size_t pixel) {  // from the ball's outline, on the wall behind its middle
            const float nearer = kDistance / (kDistance - kRadius), radius_px = nearer * kRadius / kPixel;
            const glm::vec2 at(static_cast<float>(pixel % kSize) + 0.5f - 0.5f * kSize, static_cast<float>(pixel / kSize) + 0.5f - 0.5f * kSize);
            return glm::length(at - glm::vec2(nearer * x_m(frame) / kPixel, 0.0f)) - radius_px;
        };
        size_t looked_at = 0;
        for (uint32_t frame = 0; frame < 32; ++frame) {
            SceneEdit step;
            step.set_transform(ball, {.translation = {x_m(frame), 0, kRadius}});
            const image::ImageF picture = player.next(std::move(step));
            for (size_t p = 0; frame >= 14 && p < picture.pixel_count(); ++p) {
                if (distance_px(frame, p) < 4.0f || distance_px(frame - 1, p) < 1.0f) continue;
                looked_at += distance_px(frame - 2, p) < 0.0f ? 1 : 0;
                ASSERT_LE(luminance_of(picture, p), 1.01f * kWallNits) << "upscaled " << upscale << ", frame " << frame << ", pixel " << p;
            }
        }
        EXPECT_GT(looked_at, 500u);
    }
}

// Root mean square over the pixels of edges, of the contrast.
TEST_F(Antialiasing, edges_that_stand_still_are_those_of_a_box) {
    SceneEdit edit;
    add_wall(edit);
    for (int i = 0; i < 3; ++i) {
        Primitive board;
        const float turn = 0.13f + 0.4f * static_cast<float>(i);
        const glm::vec3 along(std::cos(turn), std::sin(turn), 0), up(-std::sin(turn), std::cos(turn), 0);
        add_quad(board, glm::vec3(-1.0f + 0.8f * static_cast<float>(i), -0.5f, 0.1f), 0.4f * along, 0.9f * up);
        builtin::add_object(edit, "board", std::move(board), shining(edit, 1.0f));
    }
    Stage stage(make_scene(std::move(edit)));
    const image::ImageF truth = box_picture(stage);
    for (const double upscale : {1.0, 2.0}) {
        Player player(stage, shot_of(), options_of(upscale));
        player.skip(31);
        const image::ImageF picture = player.next();
        double squares = 0;
        size_t count = 0;
        for (size_t p = 0; p < picture.pixel_count(); ++p) {
            const double wanted = luminance_of(truth, p);
            if (wanted < kWallNits + 0.02 || wanted > 0.98) continue;
            squares += std::pow((luminance_of(picture, p) - wanted) / (1.0 - kWallNits), 2), ++count;
        }
        ASSERT_GT(count, 150u);
        EXPECT_LE(std::sqrt(squares / static_cast<double>(count)), upscale == 1.0 ? 0.055 : 0.08) << upscale;
        EXPECT_NEAR(mean_luminance(picture) / mean_luminance(truth), 1.0, upscale == 1.0 ? 0.002 : 0.004) << upscale;
    }
}

// Hundreds of things to a few pixels, of which some shine: each frame's rays meet others of them, and what a ray meets once does not fill its pixel.
TEST_F(Antialiasing, lamps_smaller_than_pixels_do_not_flash) {
    constexpr int kAcross = 60;  // stones, a third of a pixel wide
    constexpr float kLampNits = 100.0f;
    SceneEdit edit;
    add_wall(edit);
    const Handle<Material> dark = shining(edit, kWallNits), lamp = shining(edit, kLampNits);
    const float side = kPixel / 3.0f;
    for (int i = 0; i < kAcross * kAcross; ++i) {
        Primitive stone;
        add_quad(stone, {side * static_cast<float>(i % kAcross - kAcross / 2), side * static_cast<float>(i / kAcross - kAcross / 2), 0.01f}, {side, 0, 0}, {0, side, 0});
        builtin::add_object(edit, "stone", std::move(stone), i % 37 == 0 ? lamp : dark);
    }
    Stage stage(make_scene(std::move(edit)));
    const image::ImageF truth = box_picture(stage);
    Player player(stage, shot_of(), options_of(1.0));
    player.skip(32);
    const auto around = [&](size_t pixel) {
        double most = 0;
        for (int i = 0; i < 9; ++i) {
            const size_t x = pixel % kSize + static_cast<size_t>(i % 3), y = pixel / kSize + static_cast<size_t>(i / 3);
            if (x >= 1 && y >= 1 && x <= kSize && y <= kSize) most = std::max(most, luminance_of(truth, (y - 1) * kSize + x - 1));
        }
        return most;
    };
    double brightest = 0, mean = 0;
    for (int frame = 0; frame < 16; ++frame) {
        const image::ImageF picture = player.next();
        mean += mean_luminance(picture) / 16;
        for (size_t p = 0; p < picture.pixel_count(); ++p) brightest = std::max(brightest, luminance_of(picture, p) / around(p));
    }
    EXPECT_LT(brightest, 5.0);
    EXPECT_NEAR(mean / mean_luminance(truth), 1.0, 0.05);
}

}  // namespace
}  // namespace parhelion::testing::antialias_test
