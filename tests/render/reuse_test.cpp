// Reservoirs: the mean of light that is shared is the reference's, and what varies between machines changes no picture.
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing {
namespace {

class Reuse : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    }
};

constexpr uint32_t kSize = 16, kRuns = 32, kFrames = 24;

Shot small_shot(uint32_t seed, uint32_t samples) {
    return {.way = gpu::TraceWay::Compute, .view = {.width = kSize, .height = kSize, .seed = seed, .max_bounces = 4, .filter = PixelFilter::Point}, .sample_count = samples};
}

Runs runs_of(uint32_t first_seed, const std::function<image::ImageF(uint32_t seed)>& draw) {
    Runs out(kSize, kSize);
    for (uint32_t i = 0; i < kRuns; ++i) {
        const image::ImageF picture = draw(first_seed + i);
        std::vector<float> luminance(picture.pixel_count());
        for (size_t p = 0; p < luminance.size(); ++p) luminance[p] = 0.2126f * picture.plane(0)[p] + 0.7152f * picture.plane(1)[p] + 0.0722f * picture.plane(2)[p];
        out.add_run(luminance);
    }
    return out;
}

// Frames of histories, from the first on: each of them has the mean. The lamp is in the picture, and noise all in what is not it.
TEST_F(Reuse, unbiased_reservoirs_have_the_mean_of_the_reference) {
    Stage& stage = builtin_stage("builtin:cornell");
    const Runs reference = runs_of(1000, [&](uint32_t seed) { return image::resolve_film(stage.render(small_shot(seed, 64))); });
    const RealtimeOptions options{.reuse = RealtimeReuse::Unbiased, .reuse_options = {.permutation = true}, .cache = false};
    const Runs test = runs_of(1, [&](uint32_t seed) { return image::resolve_film(stage.play(small_shot(seed, kFrames), options)); });
    const Equivalence found = equivalence_test(test, reference, 0.02);  // what 32 runs of 24 frames resolve
    EXPECT_TRUE(found.passed) << found.text;
}

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
