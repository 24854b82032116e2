// Reservoirs: what varies between machines changes no picture. That their means are the reference's is tested by ./dev truth.
#include <algorithm>

#include "support/render_fixture.h"

namespace parhelion::testing {
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
    const RealtimeOptions options{.reuse = RealtimeReuse::Full};
    const image::ImageF whole = image::resolve_film(stage.play(shot, options)), again = image::resolve_film(stage.play(shot, options));
    RealtimeOptions bands = options, without_history = options;
    bands.slots = 24 * 8;  // the last of them has four rows
    without_history.reuse_options.confidence = 0;
    const image::ImageF in_bands = image::resolve_film(stage.play(shot, bands)), other = image::resolve_film(stage.play(shot, without_history));
    bool differs = false;
    for (size_t c = 0; c < whole.channels.size(); ++c) {
        EXPECT_TRUE(std::ranges::equal(whole.plane(c), again.plane(c))) << whole.channels[c];
        EXPECT_TRUE(std::ranges::equal(whole.plane(c), in_bands.plane(c))) << whole.channels[c];
        differs = differs || !std::ranges::equal(whole.plane(c), other.plane(c));
    }
    EXPECT_TRUE(differs) << "the last frame's reservoirs are used";
}

}  // namespace
}  // namespace parhelion::testing
