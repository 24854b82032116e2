// The realtime renderer without its cache is an estimator of the reference: the same mean of the picture and of each class of paths.
#include "truth/equality.h"

namespace parhelion::testing {
namespace {

class RealtimeEquality : public TruthTest, public ::testing::WithParamInterface<TruthScene> {};

TEST_P(RealtimeEquality, without_the_cache_every_class_has_the_mean_of_the_reference) {
    expect_equal_classes(GetParam(), {.test = "equality", .options = {.cache = false}});
}

INSTANTIATE_TEST_SUITE_P(Scenes, RealtimeEquality, ::testing::ValuesIn(truth_scenes().begin(), truth_scenes().end()), scene_name);

}  // namespace
}  // namespace parhelion::testing
