#include "passes/reference/reference.h"

namespace parhelion::passes {

namespace {

struct AddBlockPush {
    uint64_t block, sums;
    uint32_t first_pixel, pixel_count, plane, channel_count;
};

}  // namespace

void add_block(Frame& frame, const Film& film, const shared::Slice& slice) {
    const uint32_t pixels = slice.row_count * film.width;
    frame.compute("reference/add_block")
        .read_write("block", film.block)
        .read_write("sums", film.sums)
        .push(AddBlockPush{.first_pixel = slice.first_row * film.width, .pixel_count = pixels, .plane = film.width * film.height, .channel_count = film.channel_count})
        .over(pixels);
}

}  // namespace parhelion::passes
