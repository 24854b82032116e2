#pragma once
// Passes over lists of jobs (shared/chunks.h).
#include <string>
#include <vector>

#include "frame/frame.h"
#include "shared/chunks.h"

namespace parhelion {

inline void add_chunks(std::vector<shared::WorkChunk>& chunks, uint32_t job, uint32_t count) {
    for (uint32_t first = 0; first < count; first += shared::kWorkChunk) chunks.push_back({job, first});
}

// A buffer of at least one element, with the rows in it.
template <class T>
gpu::Buffer upload_list(Frame& frame, std::string name, const std::vector<T>& rows) {
    const gpu::Buffer buffer(frame.device(), "scene/" + std::move(name), std::max<size_t>(rows.size(), 1) * sizeof(T));
    if (!rows.empty()) frame.upload(buffer, 0, std::as_bytes(std::span(rows)));
    return buffer;
}

// A row of the dispatch is as wide as every device allows.
inline void over_chunks(Pass& pass, size_t chunks) {
    const auto rows = static_cast<uint32_t>((chunks + shared::kWorkGroups - 1) / shared::kWorkGroups);
    pass.over(static_cast<uint32_t>(std::min<size_t>(chunks, shared::kWorkGroups)) * shared::kWorkChunk, rows);
}

}  // namespace parhelion
