// The three ways to trace draw the same picture; the same command draws the same bits.
#include <cmath>

#include "support/render_fixture.h"

namespace parhelion::testing::equality_test {
namespace {

constexpr gpu::TraceWay kHardwareWays[] = {gpu::TraceWay::Query, gpu::TraceWay::Pipeline};

class Equality : public GpuTest, public ::testing::WithParamInterface<const char*> {
protected:
    std::string scene() const { return std::string("builtin:") + GetParam(); }
    bool is_cpu() const { return device()->caps().type == gpu::DeviceType::Cpu; }
};
// One body for each other way against `compute`, which every device has.
#define PARHELION_FOR_HARDWARE_WAYS(way)          \
    for (const gpu::TraceWay way : kHardwareWays) \
        if (device()->caps().supports(way))

TEST_P(Equality, ways_agree_at_one_bounce) {
    Shot shot{.view = {.width = 64, .height = 64, .max_bounces = 1}, .sample_count = 4};
    const image::ImageF expected = builtin_picture(scene(), shot);
    expect_sane(expected);
    EXPECT_GT(mean_rgb(expected), 0.0);
    PARHELION_FOR_HARDWARE_WAYS(way) {
        shot.way = way;
        EXPECT_GE(share_equal(builtin_picture(scene(), shot), expected), 0.999) << gpu::trace_way_name(way);
    }
}

TEST_P(Equality, ways_agree_at_full_depth) {
    Shot shot{.view = {.width = 64, .height = 64}, .sample_count = 1};
    const image::ImageF expected = builtin_picture(scene(), shot);
    expect_sane(expected);
    PARHELION_FOR_HARDWARE_WAYS(way) {
        shot.way = way;
        EXPECT_GE(share_equal(builtin_picture(scene(), shot), expected), is_cpu() ? 0.99 : 0.97) << gpu::trace_way_name(way);
    }
}

TEST_P(Equality, the_first_surface_is_the_same_to_the_last_bit) {
    Shot shot{.view = {.width = 64, .height = 64, .max_bounces = 1, .filter = PixelFilter::Point, .aovs = {"albedo", "normal", "roughness", "emission"}}, .sample_count = 1};
    // A little aside: scenes and cameras are symmetric, and rays would run exactly through edges, where either triangle is right.
    shot.camera = view_of((*builtin_stage(scene()).scene.cameras().begin()).value, 1.0f);
    shot.camera->position += glm::vec3(0.0137f, 0.0071f, 0.0f);
    const auto first_surface = [&] {  // the beauty left out
        image::ImageF picture = builtin_picture(scene(), shot);
        picture.channels.erase(picture.channels.begin(), picture.channels.begin() + 3);
        picture.data.erase(picture.data.begin(), picture.data.begin() + static_cast<ptrdiff_t>(3 * picture.pixel_count()));
        return picture;
    };
    const image::ImageF expected = first_surface();
    PARHELION_FOR_HARDWARE_WAYS(way) {
        shot.way = way;
        EXPECT_GE(share_bit_equal(first_surface(), expected), 0.999) << gpu::trace_way_name(way);
    }
}

// Every pixel's two values come from the same random numbers, so the difference of the pictures' means has next to no noise: the
// exact equality of expectations needs no repetition. Rays that graze an edge may take another triangle.
TEST_P(Equality, means_agree_over_many_samples) {
    Shot shot{.sample_count = 64};
    const double expected = mean_rgb(builtin_picture(scene(), shot));
    PARHELION_FOR_HARDWARE_WAYS(way) {
        shot.way = way;
        EXPECT_NEAR(mean_rgb(builtin_picture(scene(), shot)) / expected, 1.0, 1e-3) << gpu::trace_way_name(way);
    }
}

TEST_P(Equality, the_same_command_draws_the_same_bits) {
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        const Shot shot{.way = way, .view = {.width = 64, .height = 64}, .sample_count = 1};
        Stage again(make_builtin(scene()).scene);
        EXPECT_EQ(again.render(shot).limbs, builtin_film(scene(), shot).limbs) << gpu::trace_way_name(way);
    }
}

// Document 002 shades in closest-hit and miss shaders. They call the functions that raygen calls, so the CPU device draws the same
// bits, classes and first surfaces included; other compilers may round otherwise in another stage.
class ShadeInHit : public Equality {};

TEST_P(ShadeInHit, hit_and_miss_shaders_that_shade_draw_the_same_picture) {
    PARHELION_REQUIRE_WAY(gpu::TraceWay::Pipeline);
    Shot shot{.way = gpu::TraceWay::Pipeline, .view = {.width = 48, .height = 48, .aovs = {"albedo", "normal", "roughness", "emission", "path.*"}}, .sample_count = 2};
    const image::FilmSums expected = builtin_stage(scene()).render(shot);
    shot.view.shade_in = ShadeIn::ClosestHit;
    const image::FilmSums shaded_in_hit = builtin_stage(scene()).render(shot);
    EXPECT_GT(mean_rgb(image::resolve_film(expected)), 0.0);
    if (is_cpu()) EXPECT_EQ(shaded_in_hit.limbs, expected.limbs);
    else EXPECT_GE(share_equal(image::resolve_film(shaded_in_hit), image::resolve_film(expected)), 0.97);
}

INSTANTIATE_TEST_SUITE_P(Scenes, ShadeInHit, ::testing::Values("cornell", "textured", "spheres", "glass"), [](const auto& scene) { return std::string(scene.param); });
INSTANTIATE_TEST_SUITE_P(Scenes, Equality, ::testing::Values("cornell", "textured", "spheres", "glass"), [](const auto& scene) { return std::string(scene.param); });

}  // namespace
}  // namespace parhelion::testing::equality_test
