#include "renderers/slice.h"

#include "base/error.h"

namespace parhelion {

void begin_slice(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view, const shared::Slice& slice) {
    const uint32_t end = slice.first_sample + slice.sample_count;
    PARHELION_CHECK(slice.sample_count >= 1 && slice.first_sample / shared::kSamplesPerBlock == (end - 1) / shared::kSamplesPerBlock,
                    "samples {} to {} are not inside one block", slice.first_sample, end);
    PARHELION_CHECK(slice.first_row + slice.row_count <= view.film().height, "rows {} + {} are outside the film", slice.first_row, slice.row_count);
    view.prepare(frame);
    if (const RowRange rows = view.take_first_hit_rows(slice.first_row + slice.row_count); rows.count != 0)
        passes::first_hit(frame, scene, way, view.film(), rows.first, rows.count);
}

void end_slice(Frame& frame, View& view, const shared::Slice& slice, bool ends_range) {
    if (ends_range || (slice.first_sample + slice.sample_count) % shared::kSamplesPerBlock == 0) passes::add_block(frame, view.film(), slice);
}

void end_block(Frame& frame, View& view) { passes::add_block(frame, view.film(), {.first_row = 0, .row_count = view.film().height}); }

}  // namespace parhelion
