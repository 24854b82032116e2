// What the realtime renderer's machine may not change, its bands and the length of paths, and what it says of itself, the layers debug.*.
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/realtime_player.h"

namespace parhelion::testing::realtime_bands_test {
namespace {

class RealtimeBands : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    }
};

const float* plane_of(const image::ImageF& picture, const std::string& channel) {
    for (size_t c = 0; c < picture.channels.size(); ++c)
        if (picture.channels[c] == channel) return picture.plane(c).data();
    ADD_FAILURE() << "no channel " << channel;
    return nullptr;
}

// A camera before panes with a glowing wall behind them.
Scene panes_before_a_wall(uint32_t count) {
    SceneEdit edit;
    Material glass = builtin::glossy("glass", glm::vec3(1.0f), 0.0f, 0.0f);
    glass.transmission = 1.0f;
    const auto material = edit.add(std::move(glass));
    for (uint32_t i = 0; i < count; ++i) {
        Primitive sheet;
        add_quad(sheet, {-9.0f, -9.0f, -1.0f - float(i)}, {18.0f, 0.0f, 0.0f}, {0.0f, 18.0f, 0.0f});
        builtin::add_object(edit, "sheet", std::move(sheet), material);
    }
    Primitive wall;
    add_quad(wall, {-90.0f, -90.0f, -40.0f}, {180.0f, 0.0f, 0.0f}, {0.0f, 180.0f, 0.0f});
    builtin::add_object(edit, "wall", std::move(wall), edit.add(builtin::lambert("wall", glm::vec3(0.0f), glm::vec3(1.0f))));
    builtin::add_camera(edit, "before", {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}, 0.4f);
    return make_scene(std::move(edit));
}

TEST_F(RealtimeBands, pictures_do_not_depend_on_how_many_paths_are_traced_at_a_time) {
    Stage& stage = builtin_stage("builtin:cornell");
    const Shot shot{.way = gpu::TraceWay::Compute, .view = {.width = 24, .height = 28, .filter = PixelFilter::Point}, .sample_count = 3};
    const image::ImageF whole = image::resolve_film(stage.play(shot, {}));
    const RayCounts rays = stage.rays;
    const image::ImageF in_bands = image::resolve_film(stage.play(shot, {.slots = 24 * 8}));  // the last of them has four rows
    EXPECT_EQ(stage.rays.path, rays.path);
    EXPECT_EQ(stage.rays.shadow, rays.shadow);
    for (size_t c = 0; c < whole.channels.size(); ++c) EXPECT_TRUE(std::ranges::equal(whole.plane(c), in_bands.plane(c))) << whole.channels[c];
}

// What the G-buffer knows of the first surface, and of the sky: the reference's.
TEST_F(RealtimeBands, layers_of_what_is_seen_first_are_those_of_the_reference) {
    for (const char* name : {"builtin:cornell", "builtin:spheres"}) {
        Stage& stage = builtin_stage(name);
        const Shot shot{.way = gpu::TraceWay::Compute,
                        .view = {.width = 24, .height = 24, .max_bounces = 1, .filter = PixelFilter::Point, .aovs = {"albedo", "normal", "emission", "roughness"}},
                        .sample_count = 2};
        const image::ImageF expected = stage.picture(shot), found = image::resolve_film(stage.play(shot, {.cache = false}));
        for (const char* channel : {"albedo.R", "normal.X", "normal.Z", "emission.G", "roughness"}) {
            const float *a = plane_of(expected, channel), *b = plane_of(found, channel);
            double worst = 0.0, most = 0.0;
            for (size_t p = 0; p < expected.pixel_count(); ++p) worst = std::max(worst, double(std::abs(a[p] - b[p]))), most = std::max(most, double(std::abs(a[p])));
            EXPECT_GT(most, 0.0) << name << " " << channel;
            EXPECT_LE(worst, 1e-5 * most) << name << " " << channel;
        }
    }
}

TEST_F(RealtimeBands, layers_tell_rays_lights_and_cells) {
    Stage& stage = builtin_stage("builtin:cornell");
    const Shot shot{.way = gpu::TraceWay::Compute, .view = {.width = 24, .height = 24, .filter = PixelFilter::Point, .aovs = {"debug.*"}}, .sample_count = 8};
    const image::ImageF picture = image::resolve_film(stage.play(shot, {}));
    const float *rays = plane_of(picture, "debug.rays"), *light = plane_of(picture, "debug.light"), *count = plane_of(picture, "debug.count"), *level = plane_of(picture, "debug.level");
    const float *cells = plane_of(picture, "debug.cells.R"), *irradiance = plane_of(picture, "debug.irradiance.G"), *age = plane_of(picture, "debug.age"), *life = plane_of(picture, "debug.life");
    double traced = 0.0, known = 0.0, asked = 0.0;
    for (size_t p = 0; p < picture.pixel_count(); ++p) {
        traced += 8.0 * rays[p];
        asked += light[p] > 0.0f;
        known += irradiance[p] > 0.0f;
        EXPECT_LE(light[p], 1.0f) << "there is one lamp";
        EXPECT_EQ(cells[p] > 0.0f, life[p] > 0.0f);
        EXPECT_LE(age[p], 8.0f);
        EXPECT_TRUE(irradiance[p] == 0.0f || count[p] > 0.0f);
        EXPECT_GE(level[p], 0.0f);
    }
    EXPECT_NEAR(traced, double(stage.rays.path + stage.rays.shadow), 1e-3 * traced);
    EXPECT_GT(asked, 0.5 * double(picture.pixel_count()));
    EXPECT_GT(known, 0.3 * double(picture.pixel_count()));
}

// Those of reservoirs, too, however many partners and sets there are.
TEST_F(RealtimeBands, every_ray_of_reservoirs_is_counted_once) {
    Stage& stage = builtin_stage("builtin:cornell");
    const Shot shot{.way = gpu::TraceWay::Compute, .view = {.width = 24, .height = 24, .filter = PixelFilter::Point, .aovs = {"debug.rays"}}, .sample_count = 2};
    const auto rays_of = [&](const RealtimeOptions& options) {
        RealtimeOptions near = options;
        near.reuse_options.radius = 4.0f;  // so that most partners are in the picture
        const image::ImageF picture = image::resolve_film(stage.play(shot, near));
        const float* rays = plane_of(picture, "debug.rays");
        double traced = 0.0;
        for (size_t p = 0; p < picture.pixel_count(); ++p) traced += 2.0 * rays[p];
        EXPECT_NEAR(traced, double(stage.rays.path + stage.rays.shadow), 1e-3 * traced);
        return traced;
    };
    const double none = rays_of({}), alone = rays_of({.reuse = RealtimeReuse::Full, .reuse_options = {.neighbours = 0}}), pairs = rays_of({.reuse = RealtimeReuse::Full});
    EXPECT_GE(alone, none);
    EXPECT_GT(pairs, 1.1 * alone) << "partners trace rays";
    EXPECT_GT(rays_of({.reuse = RealtimeReuse::Full, .reuse_options = {.neighbours = 2}}), 1.1 * pairs);
    rays_of({.reuse = RealtimeReuse::Full, .reuse_options = {.sets = ReservoirSets::Split}});
}

bool has_pass(const Frame& frame, std::string_view name) {
    return std::ranges::any_of(frame.passes(), [&](const PassInfo& pass) { return pass.name == name; });
}

TEST_F(RealtimeBands, the_cache_is_shown_only_to_layers_of_it_and_frame_by_frame_at_the_levels_that_paths_ask) {
    Stage& stage = builtin_stage("builtin:cornell");
    const auto shot = [](const char* layer) { return Shot{.way = gpu::TraceWay::Compute, .view = {.width = 24, .height = 24, .filter = PixelFilter::Point, .aovs = {layer}}}; };
    for (const char* layer : {"debug.rays", "debug.light", "path.emission"}) {
        Player player(stage, shot(layer), {});
        player.skip(1);
        EXPECT_FALSE(has_pass(stage.frame, "realtime/debug")) << layer;
    }
    Player player(stage, shot("debug.level"), {});
    player.skip(8);
    EXPECT_TRUE(has_pass(stage.frame, "realtime/debug"));
    std::vector<float> first;
    size_t whole = 0, other = 0;
    for (int frame = 0; frame < 8; ++frame) {
        const image::ImageF picture = player.next();
        const float* level = plane_of(picture, "debug.level");
        if (first.empty()) first.assign(level, level + picture.pixel_count());
        for (size_t p = 0; p < picture.pixel_count(); ++p) whole += level[p] == std::floor(level[p]), other += level[p] != first[p];
    }
    EXPECT_EQ(whole, 8u * 24 * 24) << "a frame shows one cell";
    EXPECT_GT(other, 24u * 24 / 4) << "another frame another";
}

TEST_F(RealtimeBands, pixels_are_drawn_where_that_is_faster_but_for_a_lens_and_a_shutter) {
    if (!device()->caps().raster) GTEST_SKIP() << "the device cannot draw";
    Stage stage(make_builtin("builtin:cornell").scene, {.hardware = false, .raster = true});
    const CameraView pinhole = view_of((*stage.scene.cameras().begin()).value, 1.0f);
    CameraView lens = pinhole, beside = pinhole;
    lens.lens_radius = 0.05f;
    lens.focus_distance = 3.0f;
    beside.position += 0.05f * pinhole.right;
    const auto draws = [&](bool draws_faster, const CameraView& camera, const std::optional<CameraView>& at_close) {
        const Shot shot{.view = {.width = 16, .height = 16, .filter = PixelFilter::Point}, .camera = camera, .camera_at_close = at_close};
        Player player(stage, shot, {.auto_draws = draws_faster, .cache = false});
        player.skip(1);
        EXPECT_NE(has_pass(stage.frame, "gbuffer/identity"), has_pass(stage.frame, "gbuffer/visible"));
        return has_pass(stage.frame, "gbuffer/visible");
    };
    EXPECT_TRUE(draws(true, pinhole, {}));
    EXPECT_FALSE(draws(false, pinhole, {}));
    EXPECT_FALSE(draws(true, lens, {}));
    EXPECT_FALSE(draws(true, pinhole, beside));
}

TEST_F(RealtimeBands, a_path_that_passes_too_many_panes_ends_and_its_next_ray_is_not_counted) {
    Stage stage(panes_before_a_wall(38));
    const Shot shot{.way = gpu::TraceWay::Compute, .view = {.width = 16, .height = 16, .max_bounces = 1, .filter = PixelFilter::Point, .aovs = {"debug.rays"}}, .sample_count = 2};
    const image::ImageF picture = image::resolve_film(stage.play(shot, {.cache = false}));
    const float* rays = plane_of(picture, "debug.rays");
    double traced = 0.0, most = 0.0;
    for (size_t p = 0; p < picture.pixel_count(); ++p) traced += 2.0 * rays[p], most = std::max(most, double(rays[p]));
    EXPECT_EQ(most, 33.0) << "with the pixel's ray two vertices and 32 panes";
    EXPECT_EQ(traced, double(stage.rays.path + stage.rays.shadow));
}

TEST_F(RealtimeBands, without_the_cache_a_path_passes_many_panes_to_and_fro) {
    Stage stage(panes_before_a_wall(15));
    const Shot shot{.way = gpu::TraceWay::Compute, .view = {.width = 16, .height = 16, .max_bounces = 1, .filter = PixelFilter::Point}, .sample_count = 4};
    const image::ImageF expected = stage.picture(shot);
    const RayCounts rays = stage.rays;
    const image::ImageF found = image::resolve_film(stage.play(shot, {.tiles = false, .cache = false}));
    EXPECT_EQ(stage.rays.path + 4 * 16 * 16, rays.path);
    EXPECT_GT(mean_rgb(expected), 0.1);
    EXPECT_NEAR(mean_rgb(found), mean_rgb(expected), 0x1p-12 * mean_rgb(expected));
}

TEST_F(RealtimeBands, paths_without_a_bound_are_those_of_the_reference) {
    Stage& stage = builtin_stage("builtin:cornell");
    const Shot shot{.way = gpu::TraceWay::Compute, .view = {.width = 12, .height = 12, .max_bounces = 0xFFFFFFFFu, .filter = PixelFilter::Point}, .sample_count = 1};
    const image::ImageF expected = stage.picture(shot);
    const RayCounts rays = stage.rays;
    const image::ImageF found = image::resolve_film(stage.play(shot, {.tiles = false, .cache = false}));
    EXPECT_EQ(stage.rays.path + 12 * 12, rays.path);
    EXPECT_EQ(stage.rays.shadow, rays.shadow);
    EXPECT_NEAR(mean_rgb(found), mean_rgb(expected), 0x1p-12 * mean_rgb(expected));
}

}  // namespace
}  // namespace parhelion::testing::realtime_bands_test
