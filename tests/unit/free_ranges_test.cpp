// The free parts of buffers, against a table of what is taken.
#include <random>

#include <gtest/gtest.h>

#include "scene_gpu/ranges.h"

namespace parhelion::free_ranges_test {
namespace {

TEST(FreeRanges, are_first_fit_and_join_their_neighbours) {
    FreeRanges ranges(10);
    EXPECT_EQ(ranges.take(4), 0u);
    EXPECT_EQ(ranges.take(3), 4u);
    EXPECT_EQ(ranges.take(4), std::nullopt);
    EXPECT_EQ(ranges.take(3), 7u);
    ranges.give(0, 4);
    ranges.give(7, 3);
    EXPECT_EQ(ranges.take(5), std::nullopt);  // free, but in two parts
    ranges.give(4, 3);
    EXPECT_EQ(ranges.take(10), 0u);
}

TEST(FreeRanges, never_give_the_same_number_twice) {
    std::mt19937 random(3);
    FreeRanges ranges(1000);
    std::vector<bool> taken(1000, false);
    std::vector<std::pair<uint64_t, uint64_t>> held;
    for (int step = 0; step < 5000; ++step) {
        if (random() % 2 == 0) {
            const uint64_t count = 1 + random() % 40;
            const auto first = ranges.take(count);
            if (!first) continue;
            ASSERT_LE(*first + count, 1000u);
            for (uint64_t i = *first; i < *first + count; ++i) {
                ASSERT_FALSE(taken[i]) << i;
                taken[i] = true;
            }
            held.emplace_back(*first, count);
        } else if (!held.empty()) {
            std::swap(held[random() % held.size()], held.back());
            const auto [first, count] = held.back();
            held.pop_back();
            ranges.give(first, count);
            for (uint64_t i = first; i < first + count; ++i) taken[i] = false;
        }
    }
    for (const auto& [first, count] : held) ranges.give(first, count);
    EXPECT_EQ(ranges.take(1000), 0u);
}

}  // namespace
}  // namespace parhelion::free_ranges_test
