// --upscale: frames with fewer pixels than the picture, and anti-aliasing on its own, on light without noise: surfaces that shine, in patterns and
// colours that are known. No test here depends on chance: seeds are fixed, and the limits hold by wide margins.
#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "image/metrics.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/film_state.h"
#include "support/realtime_player.h"

namespace parhelion::testing::upscale_test {
namespace {

constexpr uint32_t kSize = 64;
constexpr float kDistance = 4.0f;
const float kYfov = glm::radians(40.0f);
const float kPixel = 2.0f * kDistance * std::tan(0.5f * kYfov) / kSize;  // metres of the wall

CameraView straight(float x_px = 0.0f, float y_px = 0.0f) {
    const glm::vec3 at{x_px * kPixel, y_px * kPixel, 0.0f};
    return look_at(at + glm::vec3(0, 0, kDistance), at, kYfov);
}

uint8_t cell(uint32_t x, uint32_t y) {
    const uint32_t h = (x * 9781u + y * 6271u + 77u) * 747796405u;
    return (h >> 22 ^ h) >> 9 & 1u ? 230 : 60;
}

// Shines with this many nits times a pattern of cells, dark and bright ones by chance, of `cell_px` pixels of the picture.
Handle<Material> shining(SceneEdit& edit, float nits, glm::vec3 tint = glm::vec3(1.0f)) {
    Image image{.name = "cells", .width = 64, .height = 64, .texels = {}};
    for (uint32_t i = 0; i < 64 * 64; ++i)
        for (int c = 0; c < 4; ++c) image.texels.push_back(c == 3 ? 255 : static_cast<uint8_t>(cell(i % 64, i / 64) * tint[c]));
    Material material = builtin::lambert("shining", glm::vec3(0.0f), glm::vec3(nits));
    material.emissive_texture.texture = edit.add(Texture{.image = edit.add(std::move(image)), .sampler = {.mag = Filter::Nearest, .min = Filter::Nearest}});
    return edit.add(std::move(material));
}

struct Shown {
    float cell_px = 3.0f;    // of the wall's pattern
    bool board = true;       // something with a pattern of its own in front
    float wire_px = 0.0f;    // width of a bright wire in front of the wall
    float wall_nits = 1.0f;
};

Stage make_stage(const Shown& shown) {
    SceneEdit edit;
    const float side = 64.0f * kPixel * 4.0f;
    Primitive wall, board, wire;
    add_textured_quad(wall, {-0.5f * side, -0.5f * side, 0}, {side, 0, 0}, {0, side, 0}, glm::vec2(256.0f / (64.0f * shown.cell_px)));
    builtin::add_object(edit, "wall", std::move(wall), shining(edit, shown.wall_nits));
    add_textured_quad(board, {-0.31f, -0.37f, 1.0f}, {0.8f, 0.05f, 0}, {-0.05f, 0.7f, 0}, glm::vec2(0.2f));
    if (shown.board) builtin::add_object(edit, "board", std::move(board), shining(edit, 0.8f, {1.0f, 0.5f, 0.3f}));
    const float width = shown.wire_px * kPixel;
    if (shown.wire_px > 0) {
        add_quad(wire, {-0.83f, -2.0f, 0.02f}, {width, 0, 0}, {0.3f, 4, 0});
        builtin::add_object(edit, "wire", std::move(wire), edit.add(builtin::lambert("wire", glm::vec3(0.0f), glm::vec3(1.0f))));
    }
    return Stage(make_scene(std::move(edit)));
}

Shot shot_of(uint32_t width = kSize, uint32_t height = kSize) { return {.view = {.width = width, .height = height, .seed = 1, .max_bounces = 1, .filter = PixelFilter::Point}, .camera = straight()}; }
RealtimeOptions options_of(double upscale, ReconstructionOptions reconstruction = {}) {
    return {.tiles = false, .cache = false, .exposure = 1.0f, .reconstruction = reconstruction, .upscale = upscale};
}
image::ImageF truth_of(Stage& stage, const CameraView& camera) {
    Shot shot = shot_of();
    shot.view.filter = PixelFilter::Box;
    shot.view.max_bounces = 0;  // surfaces shine and reflect nothing
    shot.camera = camera;
    shot.sample_count = 128;
    return stage.picture(shot);
}
double psnr(const image::ImageF& picture, const image::ImageF& truth) { return image::psnr_from_mse(image::squared_errors(image::rgb_planes(picture), image::rgb_planes(truth)).mse); }

// The camera a frame of a sequence has: to one side for 16 frames and back for 16.
CameraView camera_at(uint32_t frame, float pixels_per_frame) {
    const uint32_t phase = (frame + 8) % 32;
    return straight(pixels_per_frame * (static_cast<float>(phase < 16 ? phase : 32 - phase) - 8.0f), 0.1f * pixels_per_frame * static_cast<float>(frame % 3));
}

struct Score {
    double mean = 0, psnr = 0;  // over the reference's, and against it; of frames 20, 28, 36 and 44
};
Score score(Stage& stage, double upscale, float pixels_per_frame) {
    Player player(stage, shot_of(), options_of(upscale));
    Score out;
    for (uint32_t frame = 0; frame <= 44; ++frame) {
        const CameraView camera = camera_at(frame, pixels_per_frame);
        player.set_camera(camera);
        const image::ImageF picture = player.next();
        if (frame < 20 || frame % 8 != 4) continue;
        expect_sane(picture);
        const image::ImageF truth = truth_of(stage, camera);
        out.mean += mean_luminance(picture) / mean_luminance(truth) / 4;
        out.psnr += psnr(picture, truth) / 4;
    }
    return out;
}

// The picture of half the pixels each way, between its pixels.
image::ImageF stretched(const image::ImageF& small) {
    image::ImageF out = image::make_image(2 * small.width, 2 * small.height, {"R", "G", "B"});
    const auto at = [&](size_t plane, int x, int y) {
        return small.plane(plane)[static_cast<size_t>(std::clamp(y, 0, int(small.height) - 1)) * small.width + static_cast<size_t>(std::clamp(x, 0, int(small.width) - 1))];
    };
    for (size_t plane = 0; plane < 3; ++plane)
        for (int y = 0; y < int(out.height); ++y)
            for (int x = 0; x < int(out.width); ++x) {
                const int x0 = (x - 1) >> 1, y0 = (y - 1) >> 1;
                const float fx = x % 2 == 0 ? 0.75f : 0.25f, fy = y % 2 == 0 ? 0.75f : 0.25f;
                out.plane(plane)[static_cast<size_t>(y) * out.width + static_cast<size_t>(x)] =
                    std::lerp(std::lerp(at(plane, x0, y0), at(plane, x0 + 1, y0), fx), std::lerp(at(plane, x0, y0 + 1), at(plane, x0 + 1, y0 + 1), fx), fy);
            }
    return out;
}

using Upscaling = GpuTest;

TEST_F(Upscaling, light_without_noise_is_as_bright_as_the_reference_while_the_camera_moves) {
    Stage stage = make_stage({.cell_px = 3.1f, .board = false});
    for (const float speed : {0.0f, 5.37f}) {
        const Score native = score(stage, 1.0, speed), twice = score(stage, 2.0, speed);
        EXPECT_NEAR(native.mean, 1.0, 0.002) << speed;
        EXPECT_NEAR(twice.mean, 1.0, 0.004) << speed;
        EXPECT_GE(twice.psnr, speed > 0 ? 15.0 : 24.0) << speed;
    }
}

TEST_F(Upscaling, a_still_picture_of_a_quarter_of_the_rays_comes_near_the_reference) {
    Stage stage = make_stage({});
    const image::ImageF truth = truth_of(stage, straight());
    Shot small = shot_of(kSize / 2, kSize / 2);
    small.view.filter = PixelFilter::Box;
    small.sample_count = 256;
    Player player(stage, shot_of(), options_of(2.0));
    player.skip(63);
    const image::ImageF picture = player.next();
    EXPECT_GE(psnr(picture, truth), 22.0);
    EXPECT_LE(psnr(stretched(stage.picture(small)), truth), 16.0);  // what no time adds to
    EXPECT_NEAR(mean_luminance(picture) / mean_luminance(truth), 1.0, 0.01);
}

// A wire of half a pixel, which most frames miss somewhere.
TEST_F(Upscaling, a_thin_wire_does_not_flicker) {
    Stage stage = make_stage({.board = false, .wire_px = 0.5f, .wall_nits = 0.02f});
    for (const double upscale : {1.0, 2.0}) {
        Player player(stage, shot_of(), options_of(upscale));
        player.skip(64);
        double flicker = 0, sum = 0;
        image::ImageF before = player.next();
        for (uint32_t i = 0; i < 16; ++i) {
            const image::ImageF now = player.next();
            for (size_t p = 0; p < now.pixel_count(); ++p) flicker += std::abs(luminance_of(now, p) - luminance_of(before, p)), sum += luminance_of(now, p);
            before = now;
        }
        EXPECT_LE(flicker / sum, 0.08) << upscale;
        EXPECT_NEAR(mean_luminance(before) / mean_luminance(truth_of(stage, straight())), 1.0, 0.2) << upscale;
    }
}

TEST_F(Upscaling, sizes_that_do_not_divide_are_rounded_up_and_even_light_stays_even) {
    SceneEdit edit;
    Primitive wall;
    add_quad(wall, {-8, -8, 0}, {16, 0, 0}, {0, 16, 0});
    builtin::add_object(edit, "wall", std::move(wall), edit.add(builtin::lambert("wall", glm::vec3(0.0f), glm::vec3(0.7f))));
    Stage stage(make_scene(std::move(edit)));
    for (const double upscale : {1.3, 2.0, 3.0}) {
        Player player(stage, shot_of(61, 37), options_of(upscale));
        const gpu::Extent traced = player.realtime.gbuffer().identity.extent();
        EXPECT_EQ(traced.width, static_cast<uint32_t>(std::ceil(61 / upscale)));
        EXPECT_EQ(traced.height, static_cast<uint32_t>(std::ceil(37 / upscale)));
        for (uint32_t i = 0; i < 8; ++i) {
            player.set_camera(straight(0.7f * static_cast<float>(i)));
            const image::ImageF picture = player.next();
            ASSERT_EQ(picture.width, 61u);
            for (size_t p = 0; p < picture.pixel_count(); ++p) ASSERT_NEAR(luminance_of(picture, p) / 0.7, 1.0, 0.002) << upscale << ", pixel " << p;
        }
    }
}

std::string refusal(Stage& stage, const RealtimeOptions& options, std::vector<std::string> aovs = {}) {
    Shot shot = shot_of();
    shot.view.aovs = std::move(aovs);
    try {
        Player(stage, shot, options);
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Usage) << error.line;
        return error.line;
    }
    return "(accepted)";
}

TEST_F(Upscaling, what_cannot_be_upscaled_is_refused_in_a_line) {
    Stage& stage = builtin_stage("builtin:cornell");
    RealtimeOptions without = options_of(2.0);
    without.reconstruction.reset();
    EXPECT_NE(refusal(stage, without).find("--upscale: what is traced becomes the picture by reconstruction alone (add --denoise builtin)"), std::string::npos);
    EXPECT_NE(refusal(stage, options_of(0.5)).find("--upscale: 0.5 is out of range (from 1 to 3)"), std::string::npos);
    EXPECT_NE(refusal(stage, options_of(std::nan(""))).find("out of range"), std::string::npos);
    EXPECT_NE(refusal(stage, options_of(2.0), {"normal"}).find("--aov: normal has a value a traced pixel"), std::string::npos);
    EXPECT_EQ(refusal(stage, options_of(2.0), {"depth", "ids", "motion", "variance"}), "(accepted)");
    EXPECT_EQ(refusal(stage, options_of(1.0), {"normal"}), "(accepted)");
}

}  // namespace
}  // namespace parhelion::testing::upscale_test
