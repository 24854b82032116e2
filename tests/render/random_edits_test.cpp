// Frames of a scene that is edited at random; tests/soak/random_edits_test.cpp draws 10,000 of them.
#include "support/random_edits.h"
#include "support/gpu_fixture.h"

namespace parhelion::testing::random_edits_test {
namespace {

class RandomEditsTest : public GpuTest {};

TEST_F(RandomEditsTest, frames_are_finite_and_nothing_is_left_of_what_is_taken_away) {
    if (!LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    draw_random_edits(device(), 80, 5);
}

}  // namespace
}  // namespace parhelion::testing::random_edits_test
