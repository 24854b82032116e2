#pragma once
// How a range of references may be split in two: by object or in space. Used by the builder of the binary tree.
#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <span>
#include <vector>

#include "base/parallel.h"
#include "bvh/binary_tree.h"

namespace parhelion::bvh {

constexpr uint32_t kBins = 16;
constexpr uint32_t kSweep = 32;        // references up to which every position is tried
constexpr uint32_t kChunk = 1u << 13;  // larger ranges are scanned in chunks of this size, so that sums do not show the threads

// Twice the center of a box: saves a product.
inline glm::vec3 center(const Reference& reference) { return reference.min + reference.max; }

// A box in two rows of four numbers, of which the last means nothing: one instruction each.
struct Lanes {
    using Four [[gnu::vector_size(16)]] = float;
    Lanes() = default;
    explicit Lanes(const Reference& r) { std::memcpy(&low, &r.min, sizeof(Four)), std::memcpy(&high, &r.max, sizeof(Four)); }
    void add(const Lanes& b) { low = b.low < low ? b.low : low, high = b.high > high ? b.high : high; }
    void add(Four p) { low = p < low ? p : low, high = p > high ? p : high; }
    void limit(const Lanes& b) { low = b.low > low ? b.low : low, high = b.high < high ? b.high : high; }
    Box box() const { return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}}; }
    float half_area() const { return box().half_area(); }
    Four low = {3e38f, 3e38f, 3e38f, 3e38f}, high = {-3e38f, -3e38f, -3e38f, -3e38f};  // empty
};
static_assert(sizeof(Reference) == 2 * sizeof(Lanes::Four) && offsetof(Reference, max) == sizeof(Lanes::Four));

// Who scans a range: one thread, or all.
struct Team {
    bool all_threads = false;

    // body(chunk, first, last) for every chunk of [0, count).
    template <class Body>
    void for_each_chunk(size_t count, Body&& body) const {
        const size_t chunks = (count + kChunk - 1) / kChunk;
        const auto run = [&](size_t begin, size_t end) {
            for (size_t c = begin; c < end; ++c) body(c, c * kChunk, std::min<size_t>(count, (c + 1) * kChunk));
        };
        if (all_threads) parallel_for(chunks, 1, run);
        else run(0, chunks);
    }

    // Adds up references chunk by chunk: add(sum, reference).
    template <class Sum, class Add>
    Sum sum(std::span<const Reference> references, Add&& add) const {
        Sum total{};
        if (references.size() <= kChunk) {
            for (const Reference& r : references) add(total, r);
            return total;
        }
        std::vector<Sum> parts((references.size() + kChunk - 1) / kChunk);
        for_each_chunk(references.size(), [&](size_t c, size_t first, size_t last) {
            for (size_t i = first; i < last; ++i) add(parts[c], references[i]);
        });
        for (const Sum& part : parts) total.add(part);
        return total;
    }
};

// Box of a range's references, and of (twice) their centers.
struct Extent {
    Lanes box, centers;
    void add(const Lanes& b) { box.add(b), centers.add(b.low + b.high); }
    void add(const Extent& e) { box.add(e.box), centers.add(e.centers); }
};

// A way to split; none if the axis is -1. The cost is in triangle tests times half surfaces, without the node's own.
struct Split {
    float cost = 3e38f;
    int axis = -1;
    uint32_t left_count = 0, right_count = 0;
    Box left, right;
};

// Maps references to bins: by their centers along three axes, and by size, so that what is as large as the whole range can be set apart
// from what is small (a room's walls from what is in it).
constexpr int kBySize = 3;
struct Binning {
    explicit Binning(const Extent& e) : low(e.centers.box().min), area(e.box.half_area()) {
        const glm::vec3 extent = e.centers.box().max - low;
        for (int axis = 0; axis < 3; ++axis) scale[axis] = extent[axis] > 0.0f ? float(kBins) * (1.0f - 1e-6f) / extent[axis] : 0.0f;
    }
    uint32_t bin(const Reference& r, int axis) const {
        if (axis == kBySize) {  // halvings of the surface: the exponent of a float
            const float ratio = area / r.box().half_area();
            return ratio >= 1.0f ? std::min((std::bit_cast<uint32_t>(ratio) >> 23) - 127u, kBins - 1) : 0;
        }
        const float scaled = (r.min[axis] + r.max[axis] - low[axis]) * scale[axis];
        return scaled > 0.0f ? std::min(static_cast<uint32_t>(scaled), kBins - 1) : 0;
    }
    bool can_split(int axis) const { return axis == kBySize || scale[axis] > 0.0f; }
    glm::vec3 low, scale;
    float area;
};

struct ObjectSplit : Split {
    uint32_t bin = 0;  // first bin of the second half
};

ObjectSplit best_binned_split(std::span<const Reference> references, const Binning& binning, const Team& team);

// At most kSweep references. Orders them so that the first left_count are the first half.
Split best_sweep_split(std::span<Reference> references, const Box& centers);

// ---- in space ----

struct Parts {
    Box left, right;  // empty: nothing there
};

// Boxes of the parts of a triangle within `box` on both sides of a plane, rounded outwards: what of the triangle is in `box` is in
// the two together.
Parts cut(const shared::BvhTriangle& triangle, const Box& box, int axis, float plane);

struct SpatialSplit : Split {
    float plane = 0.0f;
};

// One that costs less than `limit`, if there is any: the axis is chosen by references cut as boxes, and only then triangles are cut.
SpatialSplit best_spatial_split(std::span<const Reference> references, std::span<const shared::BvhTriangle> triangles, const Box& box, float limit, const Team& team);

// Where a reference goes when its range is split in space: to one side whole, or a part to each.
Parts part_reference(const Reference& reference, std::span<const shared::BvhTriangle> triangles, const SpatialSplit& split);

}  // namespace parhelion::bvh
