// What the world cache may cost in truth: a bias that stays within a budget, scene by scene.
#include <ostream>

#include "truth/truth.h"

namespace parhelion::testing {
namespace {

// Of the mean over the picture: in scenes with light that smooth surfaces throw at diffuse ones, and in others; and of the 95th percentile
// of tiles.
constexpr double kMeanWithCaustics = 0.03, kMean = 0.02, kTile = 0.08;
constexpr uint32_t kRuns = 32, kWarmUp = 64;

class RealtimeBudget : public TruthTest, public ::testing::WithParamInterface<TruthScene> {};
class RealtimeReuseBudget : public RealtimeBudget {};

// Judged on 99 % bounds, so that noise fails.
void expect_within_budget(const TruthScene& scene, const std::string& test_name, RealtimeReuse reuse) {
    if (const std::string why = why_skipped(scene); !why.empty()) {
        report_skip(test_name, scene.name, why);
        GTEST_SKIP() << scene.name << ": " << why;
    }
    TruthStage& on = truth_stage(scene);
    const uint32_t size = by_size(192u, 32u), warm_up = by_size(kWarmUp, 24u), frames = by_size(scene.noisy ? 64u : 32u, 16u) * truth_effort();
    Runs test(size, size), reference(size, size);
    for (uint32_t i = 0; i < kRuns; ++i) {
        RealtimeOptions options = truth_options(on, true);
        options.reuse = reuse;
        TruthRun run(on, size, 1 + i, options);
        run.skip(warm_up);
        test.add_run(luminance(run.average(frames)));
        reference.add_run(luminance(draw_reference(on, size, 10001 + i, 2 * frames)));
    }
    const double wider = by_size(1.0, 2.0), mean = (scene.caustics ? kMeanWithCaustics : kMean) * wider, tile = kTile * by_size(1.0, 2.5);
    const Ratio ratio = ratio_of_means(test.means(), reference.means()), tiles = tile_quantile(test, reference, 0.95);
    const std::string after = fmt::format("after {} frames", warm_up);
    report({.test = test_name, .scene = scene.name, .what = "mean", .value = ratio.value, .low = ratio.lower(), .high = ratio.upper(), .least = 1 - mean, .most = 1 + mean,
            .runs = kRuns, .frames = frames, .note = after});
    report({.test = test_name, .scene = scene.name, .what = "95th percentile of tiles", .value = tiles.value, .low = tiles.value, .high = tiles.upper(), .least = 0, .most = tile,
            .runs = kRuns, .frames = frames, .note = after});
}

TEST_P(RealtimeBudget, with_the_cache_the_mean_and_its_tiles_stay_within_their_budgets) { expect_within_budget(GetParam(), "cache", RealtimeReuse::None); }
TEST_P(RealtimeReuseBudget, with_cache_and_reservoirs_the_mean_and_its_tiles_stay_within_their_budgets) { expect_within_budget(GetParam(), "reuse", RealtimeReuse::Full); }

INSTANTIATE_TEST_SUITE_P(Scenes, RealtimeBudget, ::testing::ValuesIn(truth_scenes().begin(), truth_scenes().end()), scene_name);
INSTANTIATE_TEST_SUITE_P(Scenes, RealtimeReuseBudget, ::testing::ValuesIn(truth_scenes().begin(), truth_scenes().end()), scene_name);

struct CutCase {
    const char* name;
    const char* scene;
    const char* before;  // cameras
    const char* after;   // empty: `from` and `at`
    bool caustics = false;
    glm::vec3 from{0.0f}, at{0.0f};
    float fov_degrees = 60.0f;
};
std::ostream& operator<<(std::ostream& out, const CutCase& cut) { return out << cut.name; }
constexpr CutCase kCuts[] = {
    {.name = "cornell", .scene = "builtin:cornell", .before = "front", .after = "", .from = {0.7f, 1.5f, 0.8f}, .at = {-0.5f, 0.4f, -0.4f}},
    {.name = "many_lights", .scene = "builtin:many-lights", .before = "above", .after = "near", .caustics = true},  // the diorama is too noisy for means of single frames
    {.name = "reflections", .scene = "builtin:reflections", .before = "hall", .after = "samples", .caustics = true},
};

class RealtimeCut : public TruthTest, public ::testing::WithParamInterface<CutCase> {};

TEST_P(RealtimeCut, the_first_frames_after_a_camera_cut_have_the_mean_of_any_frame) {
    const CutCase& cut = GetParam();
    const bool first = &cut == kCuts || std::string_view(cut.name) == kCuts[0].name;
    if (small_truth() && !first) GTEST_SKIP() << "not in the small truth";
    LoadedScene loaded = make_builtin(cut.scene);
    const auto camera = [&](const char* name) { return view_of(loaded.scene.get(find_camera(loaded.scene, name)), 1.0f); };
    const CameraView before = camera(cut.before), after = cut.after[0] ? camera(cut.after) : look_at(cut.from, cut.at, glm::radians(cut.fov_degrees));
    TruthStage on = set_up(std::move(loaded), after);
    const uint32_t size = by_size(192u, 24u), runs = by_size(64u, 12u), warm_up = by_size(64u, 12u);
    constexpr uint32_t kFrames[] = {1, 4, 16};  // the first after the cut is 1
    std::vector<double> reference, found[3];
    for (uint32_t i = 0; i < runs; ++i) {
        reference.push_back(mean_luminance(draw_reference(on, size, 10001 + i, by_size(32u, 16u))));
        TruthStage& stage = on;
        stage.camera = before;
        TruthRun run(stage, size, 1 + i, truth_options(stage, true));
        stage.camera = after;
        run.skip(warm_up);
        run.look(after);
        uint32_t frame = 0;
        for (size_t k = 0; k < std::size(kFrames); ++k) {
            if (frame + 1 < kFrames[k]) run.skip(kFrames[k] - 1 - frame);
            found[k].push_back(mean_luminance(run.average(1)));
            frame = kFrames[k];
        }
    }
    const double margin = (cut.caustics ? kMeanWithCaustics : kMean) * by_size(1.0, 5.0);
    for (size_t k = 0; k < std::size(kFrames); ++k) {
        const Ratio ratio = ratio_of_means(found[k], reference);
        report({.test = "cut", .scene = cut.name, .what = fmt::format("mean of frame {}", kFrames[k]), .value = ratio.value,
                .low = ratio.lower(), .high = ratio.upper(), .least = 1 - margin, .most = 1 + margin, .runs = runs, .frames = 1});
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, RealtimeCut, ::testing::ValuesIn(kCuts), [](const auto& entry) { return std::string(entry.param.name); });

}  // namespace
}  // namespace parhelion::testing
