// What the realtime renderer's machine may not change, its bands, and what it says of itself, the layers debug.*.
#include "support/render_fixture.h"

namespace parhelion::testing {
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

}  // namespace
}  // namespace parhelion::testing
