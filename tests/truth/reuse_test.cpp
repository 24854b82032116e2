// Reservoirs that are weighed with what hides their samples change nothing in the mean: of the whole, and of each step alone.
#include <ostream>

#include "truth/equality.h"

namespace parhelion::testing::reuse_test {
namespace {

constexpr uint32_t kWarmUp = 32, kPilotFrames = 16;

// With temporal reuse where few lights are, too.
EqualityCase unbiased(std::string what, ReuseOptions reuse, bool tiles = true) {
    reuse.adapt_confidence = false;
    return {.test = "unbiased",
            .what = std::move(what),
            .options = {.reuse = RealtimeReuse::Unbiased, .reuse_options = reuse, .tiles = tiles, .cache = false},
            .warm_up = by_size(kWarmUp, 16u),
            .pilot_frames = by_size(kPilotFrames, 32u)};
}

class RealtimeReuseEquality : public TruthTest, public ::testing::WithParamInterface<TruthScene> {};

TEST_P(RealtimeReuseEquality, unbiased_reuse_has_the_mean_of_the_reference_in_every_class) { expect_equal_classes(GetParam(), unbiased("", {})); }

INSTANTIATE_TEST_SUITE_P(Scenes, RealtimeReuseEquality, ::testing::ValuesIn(truth_scenes().begin(), truth_scenes().end()), scene_name);

struct Step {
    const char* name;
    ReuseOptions reuse;
    bool tiles = true;
};
std::ostream& operator<<(std::ostream& out, const Step& step) { return out << step.name; }
constexpr Step kSteps[] = {
    {.name = "candidates", .reuse = {.confidence = 0, .neighbours = 0}},
    {.name = "temporal", .reuse = {.neighbours = 0}},
    {.name = "permutation", .reuse = {.neighbours = 0, .permutation = true}},
    {.name = "spatial", .reuse = {.confidence = 0, .neighbours = 2}},
    {.name = "split", .reuse = {.sets = ReservoirSets::Split}},
    {.name = "without_tiles", .reuse = {}, .tiles = false},
};

class RealtimeReuseStep : public TruthTest, public ::testing::WithParamInterface<Step> {};

TEST_P(RealtimeReuseStep, each_step_alone_has_the_mean_of_the_reference) {
    const Step& step = GetParam();
    for (const TruthScene& scene : truth_scenes())
        if (scene.small) expect_equal_classes(scene, unbiased(step.name, step.reuse, step.tiles));
}

INSTANTIATE_TEST_SUITE_P(Steps, RealtimeReuseStep, ::testing::ValuesIn(kSteps), [](const auto& entry) { return std::string(entry.param.name); });

}  // namespace
}  // namespace parhelion::testing::reuse_test
