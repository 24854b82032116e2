#include "scene_gpu/slice.h"

#include <algorithm>

namespace parhelion {

bool upload_rows(Frame& frame, Slice& slice, std::span<const RowSource> sources, uint64_t& done) {
    uint64_t first = 0;  // of the source, among all rows
    for (const RowSource& source : sources) {
        const uint64_t end = first + source.rows;
        if (done < end) {
            if (!slice.has_bytes()) return false;
            const uint64_t row = done - first, count = std::clamp<uint64_t>(slice.bytes() / source.row_bytes, 1, end - done);
            const uint64_t bytes = count * source.row_bytes;
            source.write(frame.upload_in_place(source.to, source.offset + row * source.row_bytes, bytes).data(), row, count);
            slice.take_bytes(bytes);
            done += count;
            if (done < end) return false;
        }
        first = end;
    }
    return true;
}

}  // namespace parhelion
