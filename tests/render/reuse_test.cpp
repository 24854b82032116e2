// Reservoirs: what varies between machines changes no picture. That their means are the reference's is tested by ./dev truth.
#include <algorithm>
#include <array>
#include <bit>

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/realtime_player.h"

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

constexpr RealtimeOptions kWithHistory{.reuse = RealtimeReuse::Full, .reuse_options = {.adapt_confidence = false}};

// A wall of 4 m, lit from above.
Stage make_lit_wall(const std::vector<Light>& lights) {
    SceneEdit edit;
    Primitive wall;
    add_quad(wall, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
    builtin::add_object(edit, "wall", std::move(wall), edit.add(builtin::lambert("wall", glm::vec3(0.5f))));
    for (const Light& light : lights) edit.add(light);
    return Stage(make_scene(std::move(edit)));
}
Light lamp_at(float height, float intensity) { return {.intensity = intensity, .place = {.node_from_object = glm::translate(glm::mat4(1.0f), {0.0f, height, 0.0f})}}; }
// 64x64: means of a frame are within 1 % of their own mean.
Shot shot_from_above() { return {.view = {.width = 64, .height = 64, .filter = PixelFilter::Point}, .camera = camera_from_above(2.0f, 1.0f)}; }

// Fewer lights than eight for each candidate: what the last frame knew is left out; from then on it counts for log2 of how many there are.
TEST_F(Reuse, the_last_frame_counts_where_there_are_eight_lights_for_each_candidate) {
    for (const uint32_t lights : {7u, 8u}) {
        std::vector<Light> lamps;
        for (uint32_t i = 0; i < lights; ++i) lamps.push_back(lamp_at(0.5f + 0.25f * static_cast<float>(i), 10.0f));
        Stage stage = make_lit_wall(lamps);
        Shot shot = shot_from_above();
        shot.view.width = shot.view.height = 16;
        shot.sample_count = 4;
        const auto draw = [&](const ReuseOptions& reuse) { return image::resolve_film(stage.play(shot, {.reuse = RealtimeReuse::Full, .reuse_options = reuse, .candidates = 1})); };
        const image::ImageF adapted = draw({}), without = draw({.confidence = 0}), three = draw({.confidence = 3, .adapt_confidence = false});
        EXPECT_EQ(std::ranges::equal(adapted.data, without.data), lights == 7) << lights;
        EXPECT_EQ(std::ranges::equal(adapted.data, three.data), lights == 8) << lights;
    }
}

// The last frame's samples were of a weaker one, and must not stand in for what is new.
TEST_F(Reuse, a_lamp_that_is_turned_up_shines_in_the_same_frame) {
    const Light weak = lamp_at(2.0f, 10.0f);
    Stage stage = make_lit_wall({weak});
    Player player(stage, shot_from_above(), kWithHistory);
    player.skip(9);
    const double before = player.mean(1);
    SceneEdit up;
    Light bright = weak;
    bright.intensity *= 10.0f;
    up.set_light(*stage.scene.lights().handle_at(0), bright);
    EXPECT_NEAR(mean_luminance(player.next(std::move(up))) / before, 10.0, 0.2);
}

// A lamp behind a veil that half of the rays meet: as bright as without reservoirs. Were each step's ray to meet it by a chance of its own, what was found
// unveiled would be veiled again before it lights the wall.
TEST_F(Reuse, what_is_blended_hides_a_sample_in_all_steps_of_a_frame_or_in_none) {
    SceneEdit edit;
    Primitive wall, veil;
    add_quad(wall, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
    builtin::add_object(edit, "wall", std::move(wall), edit.add(builtin::lambert("wall", glm::vec3(0.5f))));
    add_quad(veil, {-2.0f, 1.5f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
    Material thin = builtin::lambert("veil", glm::vec3(0.0f));
    thin.base_color.a = 0.5f;
    thin.alpha_mode = AlphaMode::Blend;
    thin.double_sided = true;
    builtin::add_object(edit, "veil", std::move(veil), edit.add(std::move(thin)));
    edit.add(lamp_at(2.0f, 10.0f));
    Stage stage(make_scene(std::move(edit)));
    Shot shot = shot_from_above();
    shot.view.max_bounces = 1;
    shot.camera = look_at({0.0f, 1.2f, 0.01f}, {0.0f, 0.0f, 0.0f}, 1.2f);  // below the veil
    RealtimeOptions options{.cache = false};
    const auto mean_of = [&](RealtimeReuse reuse) {
        options.reuse = reuse;
        options.reuse_options.adapt_confidence = false;
        Player player(stage, shot, options);
        player.skip(12);
        return player.mean(24);
    };
    EXPECT_NEAR(mean_of(RealtimeReuse::Unbiased) / mean_of(RealtimeReuse::None), 1.0, 0.02);
}

// Where a wall is nearer than the steps in which its points are told, floor that it lights is as bright as without reservoirs: such paths stay the pixel's own.
TEST_F(Reuse, light_from_points_nearer_than_their_places_are_told_is_not_shared) {
    SceneEdit edit;
    Primitive floor, wall;
    add_quad(floor, {-2.0f, 0.0f, 4.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
    add_quad(wall, {-2.0f, 0.0f, 0.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 4.0f, 0.0f});
    const auto white = edit.add(builtin::lambert("white", glm::vec3(0.8f)));
    builtin::add_object(edit, "floor", std::move(floor), white);
    builtin::add_object(edit, "wall", std::move(wall), white);
    Light lamp = lamp_at(0.2f, 10.0f);  // grazes the floor
    lamp.place.node_from_object = glm::translate(lamp.place.node_from_object, {0.0f, 0.0f, 3.0f});
    edit.add(lamp);
    Stage stage(make_scene(std::move(edit)));
    constexpr float kHalf = 3e-5f;  // of what is seen: a step is 6e-5 m
    CameraView above = camera_from_above(1.0f, kHalf);
    above.position.z = 1.1f * kHalf;
    Shot shot{.view = {.width = 16, .height = 16, .max_bounces = 2, .filter = PixelFilter::Point}, .camera = above};
    const auto mean_of = [&](RealtimeReuse reuse, uint32_t seed) {
        shot.view.seed = seed;
        Player player(stage, shot, {.reuse = reuse, .cache = false});
        return player.mean(100);
    };
    EXPECT_NEAR(mean_of(RealtimeReuse::Unbiased, 2) / mean_of(RealtimeReuse::None, 1), 1.0, 0.01);
}

// From far away it was hardly ever sampled: what the last frame knows of it counts for nothing.
TEST_F(Reuse, a_lamp_that_comes_near_shines_in_the_same_frame) {
    Stage stage = make_lit_wall({lamp_at(2.0f, 10.0f), lamp_at(60.0f, 10.0f)});
    Player player(stage, shot_from_above(), kWithHistory);
    player.skip(9);
    const double before = player.mean(1);
    SceneEdit nearer;
    nearer.set_transform(*stage.scene.lights().handle_at(1), lamp_at(1.5f, 10.0f).place.node_from_object);
    const double seen = mean_luminance(player.next(std::move(nearer)));
    EXPECT_GT(seen, 2.0 * before);
    EXPECT_NEAR(seen / Player(stage, shot_from_above(), {}).mean(8), 1.0, 0.03);
}

// Sums over the picture of the signals that reconstruction gets: red, green and blue of the diffuse one, then of the specular one.
std::array<double, 6> signals_of(Stage& stage, const Shot& shot, const RealtimeOptions& options, uint32_t frames) {
    Player player(stage, shot, options);
    player.realtime.keep_input(true);
    std::array<double, 6> sums{};
    for (uint32_t i = 0; i < frames; ++i) {
        player.skip(1);
        const InputReadback input = player.realtime.read_input(stage.frame);
        for (size_t plane = 0; plane < sums.size(); ++plane)
            for (const uint32_t word : input.plane(plane)) sums[plane] += std::bit_cast<float>(word);
    }
    return sums;
}

// Who shares with nobody has what its paths bring, by the same lobes: also where these are a mirror's, and another surface is shown in its place.
TEST_F(Reuse, a_pixel_alone_has_what_its_path_brings_by_the_same_lobes) {
    for (const char* scene : {"builtin:cornell", "builtin:reflections", "builtin:spheres"}) {
        Stage& stage = builtin_stage(scene);
        const Shot shot{.view = {.width = 48, .height = 48, .filter = PixelFilter::Point}};
        const RealtimeOptions none{.reconstruction = ReconstructionOptions{}};
        RealtimeOptions alone = none;
        alone.reuse = RealtimeReuse::Full;
        alone.reuse_options = {.confidence = 0, .neighbours = 0};
        const std::array<double, 6> want = signals_of(stage, shot, none, 4), got = signals_of(stage, shot, alone, 4);
        for (size_t i = 0; i < want.size(); ++i) EXPECT_NEAR(got[i], want[i], 0.002 * want[i]) << scene << ", " << i;
    }
}

// Of what its path was offered a pixel takes all, not one sample for it, and pairs exchange: in a room of red and green walls that one sample would make the
// colours of means over pixels noisier than they are without reuse, which reconstruction could not mend.
TEST_F(Reuse, colours_of_means_over_pixels_are_no_noisier_than_without) {
    constexpr uint32_t kSize = 64, kBlock = 16, kBlocks = kSize / kBlock, kFrames = 48;
    Stage& stage = builtin_stage("builtin:cornell");
    const Shot shot{.view = {.width = kSize, .height = kSize, .filter = PixelFilter::Point}};
    const auto variance_of = [&](const RealtimeOptions& options) {  // of red's part in each block's light, summed over them
        Player player(stage, shot, options);
        player.skip(16);
        std::array<double, kBlocks * kBlocks> sum{}, squares{};
        for (uint32_t f = 0; f < kFrames; ++f) {
            const image::ImageF picture = player.next();
            for (size_t block = 0; block < sum.size(); ++block) {
                double red = 0, all = 0;
                for (size_t p = 0; p < kBlock * kBlock; ++p) {
                    const size_t x = block % kBlocks * kBlock + p % kBlock, y = block / kBlocks * kBlock + p / kBlock;
                    for (size_t c = 0; c < 3; ++c) all += picture.plane(c)[y * kSize + x];
                    red += picture.plane(0)[y * kSize + x];
                }
                const double part = red / std::max(all, 1e-9);
                sum[block] += part / kFrames, squares[block] += part * part / kFrames;
            }
        }
        double variance = 0;
        for (size_t block = 0; block < sum.size(); ++block) variance += squares[block] - sum[block] * sum[block];
        return variance;
    };
    const double none = variance_of({}), full = variance_of({.reuse = RealtimeReuse::Full});
    EXPECT_LT(full, none);
}

// A pixel's share of what it was offered is that of one sample, which costs colours where a red lamp is hidden from the partner and a ceiling in green light, which paths find, is
// not: here 0.2 % of red, 0.1 % of green.
TEST_F(Reuse, a_lamp_that_a_partner_does_not_see_keeps_its_light_and_nearly_its_colour) {
    SceneEdit edit;
    Primitive wall, card, ceiling;
    add_quad(wall, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
    add_quad(card, {0.0f, 0.02f, 2.0f}, {0.0f, 0.75f, 0.0f}, {0.0f, 0.0f, -4.0f});  // upright: hides red from the left half of the picture
    add_quad(ceiling, {-3.0f, 2.1f, -3.0f}, {6.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 6.0f});
    builtin::add_object(edit, "wall", std::move(wall), edit.add(builtin::lambert("wall", glm::vec3(0.5f))));
    builtin::add_object(edit, "ceiling", std::move(ceiling), edit.add(builtin::lambert("ceiling", glm::vec3(0.9f))));
    Material black = builtin::lambert("card", glm::vec3(0.0f));
    black.double_sided = true;
    builtin::add_object(edit, "card", std::move(card), edit.add(std::move(black)));
    for (const float x : {-0.6f, 0.6f}) {
        const glm::mat4 up = glm::rotate(glm::translate(glm::mat4(1.0f), {x, 0.1f, 0.0f}), glm::radians(90.0f), {1.0f, 0.0f, 0.0f});
        edit.add(Light{.kind = LightKind::Spot, .color = {0.0f, 1.0f, 0.0f}, .intensity = 10.0f, .inner_cone = 0.7f, .outer_cone = 0.75f, .place = {.node_from_object = up}});
    }
    Light red = lamp_at(2.0f, 10.0f);
    red.color = {1.0f, 0.0f, 0.0f};
    red.place.node_from_object[3].x = 2.0f;
    edit.add(red);
    Stage stage(make_scene(std::move(edit)));
    Shot shot = shot_from_above();
    shot.view.width = shot.view.height = 48;
    shot.view.max_bounces = 2;
    const auto colour_of = [&](RealtimeReuse reuse) {
        Player player(stage, shot, {.reuse = reuse, .cache = false});
        glm::dvec3 sum(0.0);
        for (uint32_t i = 0; i < 64; ++i) {
            const image::ImageF picture = player.next();
            for (int c = 0; c < 3; ++c)
                for (const float value : picture.plane(static_cast<size_t>(c))) sum[c] += value;
        }
        return sum;
    };
    const glm::dvec3 none = colour_of(RealtimeReuse::None), full = colour_of(RealtimeReuse::Full);
    EXPECT_NEAR(full.r / none.r, 1.0, 0.005);
    EXPECT_NEAR(full.g / none.g, 1.0, 0.005);
}

// Samples of light that points of the room sent on are kept with that light: it must go with what it came from. Without the cache nothing else remembers.
TEST_F(Reuse, light_that_came_by_way_of_a_wall_is_gone_with_its_lamp) {
    Stage stage(make_builtin("builtin:cornell").scene);
    RealtimeOptions options = kWithHistory;
    options.cache = false;
    Player player(stage, {.view = {.width = 16, .height = 16, .max_bounces = 3, .filter = PixelFilter::Point}}, options);
    EXPECT_GT(player.mean(8), 0.0);
    SceneEdit off;
    for (const auto& [handle, material] : stage.scene.materials()) {
        Material dark = material;
        dark.emission = glm::vec3(0.0f);
        off.set_material(handle, dark);
    }
    EXPECT_EQ(mean_luminance(player.next(std::move(off))), 0.0);
}

// What is not fed back cannot spread: of the 48 pixels around one hardly any goes on with its sample, whether the last frame counts or not. Without it some do,
// because a square of pixels draws from one light tile.
TEST_F(Reuse, pixels_near_each_other_seldom_keep_one_sample) {
    Stage& stage = builtin_stage("builtin:cornell");
    const auto duplicates = [&](bool adapts) {
        const Shot shot{.way = gpu::TraceWay::Compute, .view = {.width = 48, .height = 48, .filter = PixelFilter::Point, .aovs = {"debug.duplicates"}}, .sample_count = 24};
        const image::ImageF picture = image::resolve_film(stage.play(shot, {.reuse = RealtimeReuse::Full, .reuse_options = {.adapt_confidence = adapts}}));
        double sum = 0;
        for (const float around : picture.plane(*picture.find_channel("debug.duplicates"))) sum += static_cast<double>(around);
        return sum / static_cast<double>(picture.pixel_count());
    };
    const double alone = duplicates(true);
    EXPECT_GT(alone, 0.0);
    EXPECT_LT(alone, 0.05);
    EXPECT_LT(duplicates(false), 0.05);
}

}  // namespace
}  // namespace parhelion::testing::reuse_test
