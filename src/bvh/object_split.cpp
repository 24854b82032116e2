#include "bvh/split.h"

namespace parhelion::bvh {

namespace {

// A split by size has to be that much better: its halves overlap, and large things are tested by nearly every ray that comes near.
// Chosen on rooms, a church, a flat and a car: 1 makes some of them worse, 1.5 makes nearly all of them better.
constexpr float kSizePenalty = 1.5f;

struct Bin {
    Lanes box;
    uint32_t count = 0;
};

struct Bins {
    std::array<std::array<Bin, kBins>, 4> bins;  // along x, y, z, by size
    void add(const Bins& other) {
        for (int axis = 0; axis <= kBySize; ++axis)
            for (uint32_t b = 0; b < kBins; ++b) bins[axis][b].box.add(other.bins[axis][b].box), bins[axis][b].count += other.bins[axis][b].count;
    }
};

// Whether `cost` is to be preferred. Costs that rounding alone tells apart count as equal: then the more even split is better.
bool is_better(float cost, uint32_t left_count, const Split& best, uint32_t count) {
    if (cost < best.cost * (1.0f - 1e-6f)) return true;
    return cost <= best.cost * (1.0f + 1e-6f) && std::min(left_count, count - left_count) > std::min(best.left_count, count - best.left_count);
}

// A float as an integer of the same order.
uint32_t sortable(float x) {
    const uint32_t bits = std::bit_cast<uint32_t>(x + 0.0f);  // -0 becomes 0
    return (bits & 0x80000000u) != 0 ? ~bits : bits | 0x80000000u;
}

}  // namespace

ObjectSplit best_binned_split(std::span<const Reference> references, const Binning& binning, const Team& team) {
    const Bins sum = team.sum<Bins>(references, [&](Bins& s, const Reference& r) {
        const Lanes box(r);
        for (int axis = 0; axis <= kBySize; ++axis) {
            Bin& bin = s.bins[axis][binning.bin(r, axis)];
            bin.box.add(box);
            ++bin.count;
        }
    });
    const auto count = static_cast<uint32_t>(references.size());
    ObjectSplit best;
    for (int axis = 0; axis <= kBySize; ++axis) {
        if (!binning.can_split(axis)) continue;
        const auto& bins = sum.bins[axis];
        std::array<Lanes, kBins> right_box;
        Lanes right;
        for (uint32_t b = kBins - 1; b > 0; --b) {
            right.add(bins[b].box);
            right_box[b] = right;
        }
        Bin left;
        for (uint32_t b = 1; b < kBins; ++b) {
            left.box.add(bins[b - 1].box);
            left.count += bins[b - 1].count;
            if (left.count == 0 || left.count == count) continue;
            float cost = left.box.half_area() * float(left.count) + right_box[b].half_area() * float(count - left.count);
            if (axis == kBySize) cost *= kSizePenalty;
            if (!is_better(cost, left.count, best, count)) continue;
            static_cast<Split&>(best) = {cost, axis, left.count, count - left.count, left.box.box(), right_box[b].box()};
            best.bin = b;
        }
    }
    return best;
}

Split best_sweep_split(std::span<Reference> references, const Box& centers) {
    const auto count = static_cast<uint32_t>(references.size());
    std::array<std::array<uint64_t, kSweep>, 3> keys;
    std::array<float, kSweep> right_cost;
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(centers.max[axis] > centers.min[axis]) && (axis < 2 || best.axis >= 0)) continue;  // the last axis serves if all centers are equal
        for (uint32_t i = 0; i < count; ++i) keys[axis][i] = uint64_t(sortable(center(references[i])[axis])) << 32 | i;
        std::sort(keys[axis].begin(), keys[axis].begin() + count);
        Lanes right;
        for (uint32_t i = count - 1; i > 0; --i) {
            right.add(Lanes(references[static_cast<uint32_t>(keys[axis][i])]));
            right_cost[i] = right.half_area() * float(count - i);
        }
        Lanes left;
        for (uint32_t i = 1; i < count; ++i) {
            left.add(Lanes(references[static_cast<uint32_t>(keys[axis][i - 1])]));
            const float cost = left.half_area() * float(i) + right_cost[i];
            if (is_better(cost, i, best, count)) best.cost = cost, best.axis = axis, best.left_count = i;
        }
    }
    if (best.axis < 0) return best;
    std::array<Reference, kSweep> sorted;
    for (uint32_t i = 0; i < count; ++i) {
        sorted[i] = references[static_cast<uint32_t>(keys[best.axis][i])];
        (i < best.left_count ? best.left : best.right).add(sorted[i].box());
    }
    std::copy_n(sorted.begin(), count, references.begin());
    best.right_count = count - best.left_count;
    return best;
}

}  // namespace parhelion::bvh
