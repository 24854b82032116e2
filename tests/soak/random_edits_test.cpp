// 10,000 frames of a scene that is edited at random before each of them: nothing grows, nothing is left over, and validation layers say nothing.
#include <cstdio>

#include "support/gpu_fixture.h"
#include "support/random_edits.h"

namespace parhelion::testing::random_edits_test {
namespace {

class RandomEditsSoak : public GpuTest {};

void print(const std::vector<MemoryUsed>& used) {
    for (const MemoryUsed& part : used) std::printf("%8.1f MiB of the device, %8.1f MiB of the host\n", double(part.device) / (1 << 20), double(part.host) / (1 << 20));
}

// The first tenth compiles shaders. What a scene of random size takes at most varies from tenth to tenth.
TEST_F(RandomEditsSoak, ten_thousand_frames_under_the_validation_layers_take_no_more_of_the_device_than_the_first_ones) {
    const std::vector<MemoryUsed> used = draw_random_edits(device(), 10000, 5);
    print(used);
    EXPECT_LE(used.back().device, used[1].device + used[1].device / 20);
}

// The layers' own memory grows with what they have seen, so the process is looked at without them.
TEST_F(RandomEditsSoak, ten_thousand_frames_take_no_more_memory_than_the_first_ones) {
    const std::vector<MemoryUsed> used = draw_random_edits(gpu::Device::open({}), 10000, 5);
    print(used);
    EXPECT_LE(used.back().device, used[1].device + used[1].device / 20);
    EXPECT_LE(used.back().host, used[1].host + (uint64_t{8} << 20));
}

}  // namespace
}  // namespace parhelion::testing::random_edits_test
