// Slices cover a job exactly once, whatever the machine's speed, and never cross a block of 64 samples.
#include "session/slicer.h"

#include <gtest/gtest.h>

namespace parhelion::slicer_test {
namespace {

// A machine that needs `seconds_per_work` for a pixel-sample. Returns the longest slice after the first.
double run_all(Size2 size, IndexRange samples, double seconds_per_work) {
    Slicer slicer(size, samples);
    std::vector<uint64_t> next(size.height, samples.begin);  // each row takes its samples in order
    double longest = 0;
    while (const auto slice = slicer.next()) {
        EXPECT_GE(slice->row_count, 1u);
        EXPECT_GE(slice->sample_count, 1u);
        EXPECT_EQ(slice->first_sample / 64, (slice->first_sample + slice->sample_count - 1) / 64) << "a slice crosses a block";
        for (uint32_t row = slice->first_row; row < slice->first_row + slice->row_count; ++row) {
            EXPECT_EQ(next.at(row), slice->first_sample);
            next[row] += slice->sample_count;
        }
        EXPECT_EQ(slicer.samples_of_rows(), next);
        EXPECT_EQ(slicer.whole_samples(), *std::min_element(next.begin(), next.end()));
        const double seconds = double(size.width) * slice->row_count * slice->sample_count * seconds_per_work;
        slicer.measured(*slice, seconds);
        longest = std::max(longest, seconds);
    }
    for (const uint64_t count : next) EXPECT_EQ(count, samples.end);
    EXPECT_DOUBLE_EQ(slicer.done_work(), slicer.total_work());
    return longest;
}

}  // namespace

TEST(Slicer, slices_cover_everything_once_on_fast_and_slow_machines) {
    for (const double speed : {1e-9, 1e-7, 1e-6, 3e-6})
        for (const Size2 size : {Size2{1, 1}, Size2{64, 64}, Size2{1280, 720}, Size2{3, 999}})
            for (const IndexRange samples : {IndexRange{0, 1}, IndexRange{0, 100}, IndexRange{64, 192}})
                EXPECT_LE(run_all(size, samples, speed), 0.1);
}

TEST(Slicer, a_fast_machine_gets_few_slices) {
    Slicer slicer({64, 64}, {0, 1024});
    int count = 0;
    while (const auto slice = slicer.next()) {
        slicer.measured(*slice, 1e-4);
        ++count;
    }
    EXPECT_LE(count, 24);  // 16 blocks, and a few small slices at the start
}

TEST(Slicer, rows_that_miss_their_block_are_known) {
    Slicer slicer({100, 100}, {0, 128}, 0.06, 1);
    bool seen = false;
    while (const auto slice = slicer.next()) {
        slicer.measured(*slice, 0.06);
        const auto counts = slicer.samples_of_rows();
        bool same_blocks = true;
        for (const uint64_t count : counts) same_blocks &= count / 64 == counts[0] / 64;
        EXPECT_EQ(same_blocks, !slicer.inside_block_end());
        seen |= !same_blocks;
    }
    EXPECT_TRUE(seen);
}

}  // namespace parhelion::slicer_test
