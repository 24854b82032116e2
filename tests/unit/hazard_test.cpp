// The hazard tracker against cases worked out by hand from Vulkan's memory model.
#include "frame/hazard.h"

#include <gtest/gtest.h>

namespace parhelion::hazard_test {
namespace {

using gpu::Use;

const int kBufferA = 0, kBufferB = 0;
const std::string kName = "buffer";

Access access(const int& buffer, Use use) { return {&buffer, use, &kName}; }

}  // namespace

TEST(HazardTracker, a_read_after_an_unordered_write_is_a_hazard) {
    HazardTracker tracker;
    tracker.add_access(access(kBufferA, Use::ComputeWrite));
    EXPECT_EQ(tracker.find(access(kBufferA, Use::ComputeRead)).before, use_bit(Use::ComputeWrite));
    EXPECT_FALSE(tracker.find(access(kBufferB, Use::ComputeRead)).exists());
}

TEST(HazardTracker, a_barrier_orders_only_the_uses_that_it_names) {
    HazardTracker tracker;
    tracker.add_access(access(kBufferA, Use::ComputeWrite));
    tracker.add_barrier(use_bit(Use::ComputeWrite), use_bit(Use::ComputeRead));
    EXPECT_FALSE(tracker.find(access(kBufferA, Use::ComputeRead)).exists());
    EXPECT_TRUE(tracker.find(access(kBufferA, Use::IndirectRead)).exists());
    EXPECT_TRUE(tracker.find(access(kBufferA, Use::TransferRead)).exists());
}

TEST(HazardTracker, a_barrier_before_the_write_does_not_count) {
    HazardTracker tracker;
    tracker.add_barrier(use_bit(Use::ComputeWrite), use_bit(Use::ComputeRead));
    tracker.add_access(access(kBufferA, Use::ComputeWrite));
    EXPECT_TRUE(tracker.find(access(kBufferA, Use::ComputeRead)).exists());
}

TEST(HazardTracker, a_write_waits_for_every_earlier_read) {
    HazardTracker tracker;
    tracker.add_access(access(kBufferA, Use::ComputeRead));
    tracker.add_access(access(kBufferA, Use::TransferRead));
    EXPECT_EQ(tracker.find(access(kBufferA, Use::ComputeWrite)).before, use_bit(Use::ComputeRead) | use_bit(Use::TransferRead));
    tracker.add_barrier(use_bit(Use::ComputeRead), use_bit(Use::ComputeWrite));
    EXPECT_TRUE(tracker.find(access(kBufferA, Use::ComputeWrite)).exists());
    tracker.add_barrier(use_bit(Use::ComputeRead) | use_bit(Use::TransferRead), use_bit(Use::ComputeWrite));
    EXPECT_FALSE(tracker.find(access(kBufferA, Use::ComputeWrite)).exists());
}

TEST(HazardTracker, two_reads_need_no_order) {
    HazardTracker tracker;
    tracker.add_access(access(kBufferA, Use::ComputeRead));
    EXPECT_FALSE(tracker.find(access(kBufferA, Use::TraceRead)).exists());
}

TEST(HazardTracker, barriers_chain) {
    HazardTracker tracker;
    tracker.add_access(access(kBufferA, Use::TransferWrite));
    tracker.add_barrier(use_bit(Use::TransferWrite), use_bit(Use::ComputeRead));
    tracker.add_barrier(use_bit(Use::ComputeRead), use_bit(Use::TraceRead));
    EXPECT_FALSE(tracker.find(access(kBufferA, Use::TraceRead)).exists());
}

TEST(HazardTracker, a_read_after_the_barrier_is_not_covered_by_it) {
    HazardTracker tracker;
    tracker.add_access(access(kBufferA, Use::ComputeRead));
    tracker.add_barrier(use_bit(Use::ComputeRead), use_bit(Use::TransferWrite));
    tracker.add_access(access(kBufferA, Use::ComputeRead));
    EXPECT_TRUE(tracker.find(access(kBufferA, Use::TransferWrite)).exists());
}

TEST(HazardTracker, who_comes_after_passes_beside_each_other_waits_for_all_of_them) {
    HazardTracker tracker;
    tracker.add_access(access(kBufferA, Use::TransferWrite));
    tracker.add_barrier(use_bit(Use::TransferWrite), use_bit(Use::ComputeWrite) | use_bit(Use::TraceWrite));
    const Access beside[] = {access(kBufferA, Use::ComputeWrite), access(kBufferB, Use::ComputeRead), access(kBufferA, Use::TraceWrite), access(kBufferA, Use::IndirectRead)};
    tracker.add_accesses(beside);
    EXPECT_EQ(tracker.find(access(kBufferA, Use::ComputeRead)).before, use_bit(Use::ComputeWrite) | use_bit(Use::TraceWrite));
    tracker.add_barrier(use_bit(Use::ComputeWrite), use_bit(Use::ComputeRead));
    EXPECT_TRUE(tracker.find(access(kBufferA, Use::ComputeRead)).exists());
    tracker.add_barrier(use_bit(Use::ComputeWrite) | use_bit(Use::TraceWrite), use_bit(Use::ComputeRead) | use_bit(Use::ComputeWrite));
    EXPECT_FALSE(tracker.find(access(kBufferA, Use::ComputeRead)).exists());
    EXPECT_EQ(tracker.find(access(kBufferA, Use::ComputeWrite)).before, use_bit(Use::IndirectRead)) << "the read of the group, whichever its place in it";
}

TEST(HazardTracker, a_long_run_stays_small_and_right) {
    HazardTracker tracker;
    for (int i = 0; i < 5000; ++i) {
        tracker.add_access(access(kBufferA, Use::ComputeWrite));
        EXPECT_TRUE(tracker.find(access(kBufferA, Use::ComputeRead)).exists());
        tracker.add_barrier(use_bit(Use::ComputeWrite), use_bit(Use::ComputeRead));
        EXPECT_FALSE(tracker.find(access(kBufferA, Use::ComputeRead)).exists());
        tracker.compact();
        EXPECT_FALSE(tracker.find(access(kBufferA, Use::ComputeRead)).exists());
    }
}

}  // namespace parhelion::hazard_test
