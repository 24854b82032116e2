// The realtime renderer is one renderer, whichever way the device traces: step three of the ladder of equalities.
#include <algorithm>

#include "truth/truth.h"

namespace parhelion::testing::ways_test {
namespace {

constexpr const char* kScenes[] = {"cornell", "diorama", "glass"};
constexpr uint32_t kRuns = 32;
constexpr double kConfidence = 0.9995;  // on each side: a 99.9 % interval

class RealtimeWays : public TruthTest, public ::testing::WithParamInterface<const char*> {};

// Frame 1 pixel by pixel, and the mean of later frames: runs of two ways share their seeds, so that the ratio of their means is known far
// better than either.
TEST_P(RealtimeWays, every_way_to_trace_gives_the_same_first_frame_and_the_same_mean) {
    const std::string name = GetParam();
    if (small_truth() && name != kScenes[0]) GTEST_SKIP() << "not in the small truth";
    const auto scenes = truth_scenes();
    TruthStage& on = truth_stage(*std::find_if(scenes.begin(), scenes.end(), [&](const TruthScene& s) { return s.name == name; }));
    const uint32_t size = by_size(192u, 16u), warm_up = by_size(16u, 4u), frames = by_size(32u, 4u) * truth_effort();
    const gpu::TraceWay own = on.way;
    const double equal_share = device()->caps().type == gpu::DeviceType::Cpu ? 0.99 : 0.97, margin = by_size(0.001, 0.02);
    image::ImageF first;
    std::vector<double> means;
    for (const gpu::TraceWay way : {gpu::TraceWay::Compute, gpu::TraceWay::Query, gpu::TraceWay::Pipeline}) {
        if (!device()->caps().supports(way)) {
            report_skip("ways", name, fmt::format("no {} on this device", gpu::trace_way_name(way)));
            continue;
        }
        on.way = way;
        image::ImageF of_first;
        std::vector<double> of_way;
        for (uint32_t i = 0; i < kRuns; ++i) {
            TruthRun run(on, size, 1 + i, truth_options(on, true));
            if (i == 0) of_first = run.average(1);
            run.skip(i == 0 ? warm_up - 1 : warm_up);
            of_way.push_back(mean_luminance(run.average(frames)));
        }
        if (way == gpu::TraceWay::Compute) {
            first = std::move(of_first), means = std::move(of_way);
            continue;
        }
        const double share = share_equal(of_first, first);
        const Ratio ratio = paired_ratio(of_way, means);
        report({.test = "ways", .scene = name, .what = fmt::format("{}: equal pixels", gpu::trace_way_name(way)), .value = share, .low = share,
                .high = share, .least = equal_share, .most = 1, .runs = 1, .frames = 1, .note = "of frame 1, beside compute"});
        report({.test = "ways", .scene = name, .what = fmt::format("{}: mean", gpu::trace_way_name(way)), .value = ratio.value,
                .low = ratio.lower(kConfidence), .high = ratio.upper(kConfidence), .least = 1 - margin, .most = 1 + margin, .runs = kRuns, .frames = frames, .note = "over compute's, pairs of one seed"});
    }
    on.way = own;
}

INSTANTIATE_TEST_SUITE_P(Scenes, RealtimeWays, ::testing::ValuesIn(kScenes), [](const auto& entry) { return std::string(entry.param); });

}  // namespace
}  // namespace parhelion::testing::ways_test
