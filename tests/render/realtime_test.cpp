// The realtime renderer without its cache is the reference with another choice of lights: the same picture in the mean, and without
// light tiles the same samples.
#include "support/render_fixture.h"

namespace parhelion::testing {
namespace {

const std::vector<std::string> kClasses{"path.*"};
constexpr const char* kScenes[] = {"builtin:cornell", "builtin:diorama", "builtin:spheres", "builtin:many-lights", "builtin:reflections", "builtin:leak-box", "builtin:glass"};

class RealtimePicture : public GpuTest {};

Shot pinhole_shot(gpu::TraceWay way, uint32_t samples) {
    return {.way = way, .view = {.width = 32, .height = 32, .filter = PixelFilter::Point, .aovs = kClasses}, .sample_count = samples};
}

TEST_F(RealtimePicture, without_tiles_a_frame_is_a_sample_of_the_reference) {
    for (const char* name : kScenes) {
        SCOPED_TRACE(name);
        Stage& stage = builtin_stage(name);
        const Shot shot = pinhole_shot(gpu::TraceWay::Compute, 2);
        const image::ImageF expected = image::resolve_film(stage.render(shot));
        const RayCounts rays = stage.rays;
        const image::ImageF found = image::resolve_film(stage.play(shot, {.tiles = false}));
        EXPECT_GT(mean_rgb(expected), 0.0);
        EXPECT_EQ(stage.rays.path + 2 * 32 * 32, rays.path);
        EXPECT_EQ(stage.rays.shadow, rays.shadow);
        for (size_t c = 0; c < expected.channels.size(); ++c) {
            double worst = 0.0;
            for (size_t p = 0; p < expected.pixel_count(); ++p) {
                const double a = expected.plane(c)[p], b = found.plane(c)[p];
                worst = std::max(worst, std::abs(a - b) / std::max(1e-6, std::abs(a)));
            }
            EXPECT_LE(worst, c < 3 ? 0x1p-12 : 1e-5) << expected.channels[c] << ": the picture's signals have 14 bits";
        }
    }
}

}  // namespace
}  // namespace parhelion::testing
