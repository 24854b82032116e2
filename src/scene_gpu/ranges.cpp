#include "scene_gpu/ranges.h"

#include <algorithm>

#include "base/error.h"

namespace parhelion {

namespace {
constexpr uint64_t kAlignment = 16;
}

std::optional<uint64_t> FreeRanges::take(uint64_t count) {
    const auto fits = std::find_if(free_.begin(), free_.end(), [&](const auto& range) { return range.second >= count; });
    if (fits == free_.end()) return std::nullopt;
    const auto [first, size] = *fits;
    free_.erase(fits);
    if (size > count) free_.emplace(first + count, size - count);
    return first;
}

void FreeRanges::give(uint64_t first, uint64_t count) {
    if (count == 0) return;
    const auto after = free_.lower_bound(first);
    if (after != free_.end() && after->first == first + count) {
        count += after->second;
        free_.erase(after);
    }
    const auto next = free_.lower_bound(first);
    if (next != free_.begin()) {
        const auto before = std::prev(next);
        if (before->first + before->second == first) {
            before->second += count;
            return;
        }
    }
    free_.emplace(first, count);
}

BufferRange BufferPool::take(uint64_t bytes) {
    const uint64_t rounded = (std::max<uint64_t>(bytes, 1) + kAlignment - 1) / kAlignment * kAlignment;
    expected_ -= std::min(expected_, rounded);
    for (Block& block : blocks_)
        if (const std::optional<uint64_t> offset = block.free.take(rounded)) {
            block.used += rounded;
            return {block.buffer, *offset, rounded};
        }
    const uint64_t size = std::max(rounded, std::min(rounded + expected_, buffer_bytes_));
    Block block{gpu::Buffer(device_, name_, size), FreeRanges(size), rounded};
    block.free.take(rounded);
    blocks_.push_back(std::move(block));
    return {blocks_.back().buffer, 0, rounded};
}

void BufferPool::give(const BufferRange& range) {
    if (!range.buffer) return;
    const auto block = std::find_if(blocks_.begin(), blocks_.end(), [&](const Block& b) { return b.buffer.id() == range.buffer.id(); });
    PARHELION_CHECK(block != blocks_.end(), "a range of {} is not of pool {}", range.buffer.name(), name_);
    block->free.give(range.offset, range.bytes);
    block->used -= range.bytes;
    if (block->used == 0) blocks_.erase(block);
}

uint64_t RowArray::take(Frame& frame, uint64_t count) {
    if (count == 0) return 0;
    if (const std::optional<uint64_t> first = free_.take(count)) {
        expected_ -= std::min(expected_, count);
        return *first;
    }
    // A quarter more where it was full before, so that rows are seldom copied.
    const uint64_t added = std::max({count, expected_, rows_ / 4});
    const gpu::Buffer larger(device_, name_, (rows_ + added) * row_bytes_);
    if (buffer_) frame.copy(buffer_, 0, larger, 0, rows_ * row_bytes_);
    buffer_ = larger;
    free_.give(rows_, added);
    rows_ += added;
    expected_ -= std::min(expected_, count);
    return *free_.take(count);
}

std::vector<gpu::Buffer> BufferPool::buffers() const {
    std::vector<gpu::Buffer> out;
    for (const Block& block : blocks_) out.push_back(block.buffer);
    return out;
}

}  // namespace parhelion
