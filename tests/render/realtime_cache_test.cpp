// Pictures whose paths end in the world cache, against those whose paths go to their end.
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/realtime_player.h"
#include "support/statistics.h"

namespace parhelion::testing::realtime_cache_test {
namespace {

class RealtimeCache : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    }
    // Of a few pixels' size: those of eight that larger pictures have would be as large as the rooms.
    static RealtimeOptions options() { return {.cache_options = {.cells = 1u << 13, .cell_pixels = 2.0f}}; }
    static Shot shot(uint32_t seed) { return {.view = {.width = 16, .height = 16, .seed = seed, .filter = PixelFilter::Point}}; }
    // Means of runs with seeds of their own over so many frames after the first 16, in which the cache fills.
    static std::vector<double> run_means(Stage& stage, uint32_t runs, uint32_t frames) {
        std::vector<double> means;
        for (uint32_t run = 1; run <= runs; ++run) {
            Player player(stage, shot(run), options());
            player.skip(16);
            means.push_back(player.mean(frames));
        }
        return means;
    }
    // The reference's, of 64 samples each.
    static std::vector<double> true_means(Stage& stage, uint32_t runs) {
        std::vector<double> means;
        for (uint32_t run = 1; run <= runs; ++run) means.push_back(mean_luminance(stage.picture(shot(1000 + run))));
        return means;
    }
    // Budget of the cache's error, judged on the upper 99 % bound of the ratio; the truth's own error is a quarter of it at most.
    static void expect_within(const std::vector<double>& found, const std::vector<double>& truth, double budget) {
        const Moments a = moments(found), b = moments(truth);
        EXPECT_LE(b.standard_error() / b.mean, budget / 4);
        const double ratio = a.mean / b.mean, error = std::hypot(a.standard_error() / a.mean, b.standard_error() / b.mean);
        EXPECT_LE(std::abs(ratio - 1) + t_quantile(0.99, static_cast<double>(found.size() - 1)) * error, budget) << ratio << " +- " << error;
    }
};

TEST_F(RealtimeCache, the_cornell_box_is_as_bright_as_by_whole_paths) {
    Stage& stage = builtin_stage("builtin:cornell");
    expect_within(run_means(stage, 6, 16), true_means(stage, 16), 0.03);
}

// Walls that glow and are half diffuse, half of rough metal: paths end in the cache by the one half and go on by the other, and light samples
// are asked for at both. Each is counted once.
TEST_F(RealtimeCache, a_room_of_half_metal_is_as_bright_as_by_whole_paths) {
    SceneEdit edit;
    Material walls = builtin::glossy("walls", glm::vec3(0.7f), 0.5f, 0.5f);
    walls.emission = glm::vec3(0.4f);
    Primitive room;
    add_box(room, {-2, 0, -2}, {2, 3, 2}, Facing::In);
    builtin::add_object(edit, "room", std::move(room), edit.add(walls));
    builtin::add_camera(edit, "inside", {-1.7f, 1.6f, 1.7f}, {0.5f, 0.9f, -1.0f}, 1.0f);
    Stage stage(make_scene(std::move(edit)));
    expect_within(run_means(stage, 10, 16), true_means(stage, 8), 0.02);
}

// Stored light is pre-exposed; what is seen is not. Two runs of the same numbers, one of which opens its aperture on the way.
TEST_F(RealtimeCache, a_new_exposure_changes_nothing_in_nits) {
    Stage& stage = builtin_stage("builtin:cornell");
    Player one(stage, shot(1), options()), other(stage, shot(1), options());
    for (uint32_t frame = 0; frame < 16; ++frame) {
        if (frame == 8) other.realtime.set_exposure(64.0f);
        const double expected = mean_luminance(one.next()), found = mean_luminance(other.next());
        ASSERT_NEAR(found / expected, 1.0, 1e-3) << frame;
    }
}

}  // namespace
}  // namespace parhelion::testing::realtime_cache_test
