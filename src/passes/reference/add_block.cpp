#include "passes/reference/reference.h"

namespace parhelion::passes {

namespace {

struct AddBlockPush {
    uint64_t block, sums;
    uint32_t first_row, row_count, width, plane, channel_count;
};

}  // namespace

void add_block(Frame& frame, const Film& film, const shared::Slice& slice) {
    frame.compute("reference/add_block")
        .read_write("block", film.block)
        .read_write("sums", film.sums)
        .push(AddBlockPush{.first_row = slice.first_row, .row_count = slice.row_count, .width = film.width, .plane = film.width * film.height, .channel_count = film.channel_count})
        .over(film.width, slice.row_count);
}

}  // namespace parhelion::passes
