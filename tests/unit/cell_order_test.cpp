// The order of a grid's cells (shaders/lib/cell_order.glsl).
#include <gtest/gtest.h>

#include "sampling/cell_order.h"

namespace parhelion::testing {
namespace {

TEST(CellOrder, every_cell_has_one_place_in_grids_of_any_shape) {
    for (const glm::uvec2 size : {glm::uvec2(1, 1), glm::uvec2(8, 8), glm::uvec2(16, 4), glm::uvec2(2, 64), glm::uvec2(1, 32), glm::uvec2(1024, 512)})
        for (uint32_t place = 0; place < size.x * size.y; ++place) {
            const glm::uvec2 cell = sampling::cell_at(place, size);
            ASSERT_LT(cell.x, size.x);
            ASSERT_LT(cell.y, size.y);
            ASSERT_EQ(sampling::cell_place(cell, size), place);
        }
}

// Places in equal steps are a grid of their own: one in each block of cells.
TEST(CellOrder, equal_steps_are_spread_in_both_directions) {
    const glm::uvec2 size(64, 32);
    for (const uint32_t offset : {0u, 5u, 31u}) {
        std::vector<int> blocks(8 * 8);
        for (uint32_t k = 0; k < 64; ++k) {
            const glm::uvec2 cell = sampling::cell_at(32 * k + offset, size);
            ++blocks[cell.y / 4 * 8 + cell.x / 8];
        }
        for (const int count : blocks) EXPECT_EQ(count, 1);
    }
}

}  // namespace
}  // namespace parhelion::testing
