#pragma once
// Parts of buffers: what a mesh occupies, and what is free.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace parhelion {

// The free numbers of [0, size), first fit.
class FreeRanges {
public:
    explicit FreeRanges(uint64_t size = 0) { give(0, size); }
    std::optional<uint64_t> take(uint64_t count);
    void give(uint64_t first, uint64_t count);  // joins its neighbours

private:
    std::map<uint64_t, uint64_t> free_;  // first -> count; neither empty nor touching
};

struct BufferRange {
    gpu::Buffer buffer;
    uint64_t offset = 0, bytes = 0;
    uint64_t address() const { return buffer.address() + offset; }
};

// Memory for arrays of any size in few buffers. An array that is larger than a buffer gets one of its own; what the device cannot
// hold in one buffer is an Error of gpu::Buffer, which names the limit.
class BufferPool {
public:
    BufferPool(gpu::DevicePtr device, std::string name, uint64_t buffer_bytes) : device_(std::move(device)), name_(std::move(name)), buffer_bytes_(buffer_bytes) {}
    // So much is going to be taken: buffers need not be made larger.
    void expect(uint64_t bytes) { expected_ = bytes; }
    BufferRange take(uint64_t bytes);
    void give(const BufferRange& range);
    std::vector<gpu::Buffer> buffers() const;

private:
    struct Block {
        gpu::Buffer buffer;
        FreeRanges free;
        uint64_t used = 0;
    };
    gpu::DevicePtr device_;
    std::string name_;
    uint64_t buffer_bytes_, expected_ = 0;
    std::vector<Block> blocks_;
};

// Rows of one kind in one buffer, named by their number. The buffer grows: its rows are copied on the device and keep their numbers.
class RowArray {
public:
    RowArray(gpu::DevicePtr device, std::string name, uint64_t row_bytes) : device_(std::move(device)), name_(std::move(name)), row_bytes_(row_bytes) {}
    // So many rows are about to be taken: room is made for them at once.
    void expect(uint64_t rows) { expected_ = rows; }
    uint64_t take(Frame& frame, uint64_t count);  // the first of `count` rows that follow one another
    void give(uint64_t first, uint64_t count) { free_.give(first, count); }
    const gpu::Buffer& buffer() const { return buffer_; }

private:
    gpu::DevicePtr device_;
    std::string name_;
    uint64_t row_bytes_, rows_ = 0, expected_ = 0;
    FreeRanges free_;
    gpu::Buffer buffer_;
};

}  // namespace parhelion
