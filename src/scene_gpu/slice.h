#pragma once
// The work of one update(), and uploads that are cut to it.
#include <cstring>
#include <functional>
#include <span>

#include "scene_gpu/ranges.h"

namespace parhelion {

// What is left of one update().
class Slice {
public:
    Slice(uint64_t bytes, uint64_t triangles) : bytes_(bytes), triangles_(triangles) {}
    uint64_t bytes() const { return bytes_; }
    bool has_bytes() const { return bytes_ > 0; }
    bool has_triangles() const { return triangles_ > 0; }
    void take_bytes(uint64_t bytes) { bytes_ -= std::min(bytes, bytes_); }
    void take_triangles(uint64_t triangles) { triangles_ -= std::min(triangles, triangles_); }

private:
    uint64_t bytes_, triangles_;
};

// An array on its way to the device: rows are made where they are copied from, so that no second array exists on the host.
struct RowSource {
    gpu::Buffer to;
    uint64_t offset = 0, row_bytes = 0, rows = 0;
    std::function<void(std::byte* to, uint64_t first, uint64_t count)> write;
};

// The rows of an array that stays where it is until they are up.
template <class T>
RowSource array_rows(const BufferRange& to, const std::vector<T>& values) {
    return {to.buffer, to.offset, sizeof(T), values.size(),
            [&values](std::byte* out, uint64_t first, uint64_t count) { std::memcpy(out, values.data() + first, count * sizeof(T)); }};
}

// Uploads the sources' rows, one source after the other, from row number `done` of them all on, which it moves on. True: all are up.
bool upload_rows(Frame& frame, Slice& slice, std::span<const RowSource> sources, uint64_t& done);

}  // namespace parhelion
