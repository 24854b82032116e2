#include <cmath>

#include "bvh/split.h"

namespace parhelion::bvh {

namespace {

// How much cutting triangles, not boxes only, is expected to bring at most: only those that are cut get smaller. Where there are few,
// nearly all of them are cut.
constexpr float kHopefulCut = 0.5f;

struct LooseBin {
    Lanes enter_box, leave_box;     // of the references that begin and that end here
    uint32_t enter = 0, leave = 0;  // their numbers
};
struct LooseBins {
    std::array<std::array<LooseBin, kBins>, 3> bins;
    void add(const LooseBins& other) {
        for (int axis = 0; axis < 3; ++axis)
            for (uint32_t b = 0; b < kBins; ++b) {
                LooseBin& bin = bins[axis][b];
                const LooseBin& more = other.bins[axis][b];
                bin.enter_box.add(more.enter_box), bin.leave_box.add(more.leave_box);
                bin.enter += more.enter, bin.leave += more.leave;
            }
    }
};

// What of the triangles lies between two planes of the chosen axis.
struct CutBins {
    std::array<Lanes, kBins> boxes, parts;  // the latter of one triangle at a time
    void add(const CutBins& other) {
        for (uint32_t b = 0; b < kBins; ++b) boxes[b].add(other.boxes[b]);
    }
};

Box common(const Box& a, const Box& b) { return {glm::max(a.min, b.min), glm::min(a.max, b.max)}; }

bool is_empty(const Box& b) { return !(b.min.x <= b.max.x && b.min.y <= b.max.y && b.min.z <= b.max.z); }

// Adds a box around the point where an edge crosses a plane. Computed in double: the point is off by less than 2^-48 of the larger
// corner, and is then rounded outwards to float.
void add_crossing(glm::vec3 a, glm::vec3 b, int axis, float plane, Parts& parts) {
    const double t = (double(plane) - a[axis]) / (double(b[axis]) - a[axis]);
    Box box;
    for (int k = 0; k < 3; ++k) {
        const double x = a[k] + t * (double(b[k]) - a[k]);
        const double margin = 0x1p-48 * std::max(std::abs(a[k]), std::abs(b[k])) + 0x1p-23 * std::abs(x) + 0x1p-149;
        box.min[k] = k == axis ? plane : static_cast<float>(x - margin);
        box.max[k] = k == axis ? plane : static_cast<float>(x + margin);
    }
    parts.left.add(box), parts.right.add(box);
}

// A small range gets few bins: cutting its triangles into more would take longer than it brings.
struct Planes {
    Planes(const Box& box, size_t count) : bins(std::clamp(static_cast<uint32_t>(count) / 2, 4u, kBins)), low(box.min), width((box.max - box.min) / float(bins)) {
        for (int axis = 0; axis < 3; ++axis) scale[axis] = width[axis] > 0.0f ? 1.0f / width[axis] : 0.0f;
    }
    uint32_t bin(float x, int axis) const {
        const float scaled = (x - low[axis]) * scale[axis];
        return scaled > 0.0f ? std::min(static_cast<uint32_t>(scaled), bins - 1) : 0;
    }
    float plane(uint32_t bin, int axis) const { return low[axis] + float(bin) * width[axis]; }  // below it
    uint32_t bins;
    glm::vec3 low, width, scale;
};

// Cuts what of a triangle is in `box` at the planes of some bins. Good enough for costs: its crossings are not rounded outwards.
void add_cut(const shared::BvhTriangle& triangle, const Lanes& box, int axis, const Planes& planes, uint32_t first, uint32_t last, CutBins& sum) {
    std::array<Lanes::Four, 3> corners;
    std::array<uint32_t, 3> bins;
    for (size_t k = 0; k < 3; ++k) {
        std::memcpy(&corners[k], &(&triangle.p0)[k], sizeof(Lanes::Four));
        bins[k] = std::clamp(planes.bin(corners[k][axis], axis), first, last);
        sum.parts[bins[k]].add(corners[k]);
    }
    for (size_t k = 0; k < 3; ++k) {
        const size_t next = k < 2 ? k + 1 : 0, low = bins[k] < bins[next] ? k : next, high = k + next - low;
        if (bins[low] == bins[high]) continue;
        const Lanes::Four a = corners[low], d = corners[high] - a;
        const float scale = 1.0f / d[axis];
        for (uint32_t b = bins[low] + 1; b <= bins[high]; ++b) {
            const Lanes::Four crossing = a + d * ((planes.plane(b, axis) - a[axis]) * scale);
            sum.parts[b - 1].add(crossing), sum.parts[b].add(crossing);
        }
    }
    for (uint32_t b = first; b <= last; ++b) {
        sum.parts[b].limit(box);
        if (!is_empty(sum.parts[b].box())) sum.boxes[b].add(sum.parts[b]);
        sum.parts[b] = {};
    }
}

}  // namespace

Parts cut(const shared::BvhTriangle& triangle, const Box& box, int axis, float plane) {
    const glm::vec3 corners[3] = {triangle.p0, triangle.p1, triangle.p2};
    Parts parts;
    for (int k = 0; k < 3; ++k) {
        const glm::vec3 a = corners[k], b = corners[(k + 1) % 3];
        if (a[axis] <= plane) parts.left.add(a);
        if (a[axis] >= plane) parts.right.add(a);
        if ((a[axis] < plane && b[axis] > plane) || (a[axis] > plane && b[axis] < plane)) add_crossing(a, b, axis, plane, parts);
    }
    parts.left = common(parts.left, box), parts.right = common(parts.right, box);
    if (is_empty(parts.left)) parts.left = {};
    if (is_empty(parts.right)) parts.right = {};
    return parts;
}

SpatialSplit best_spatial_split(std::span<const Reference> references, std::span<const shared::BvhTriangle> triangles, const Box& box, float limit, const Team& team) {
    const Planes planes(box, references.size());
    const LooseBins loose = team.sum<LooseBins>(references, [&](LooseBins& s, const Reference& r) {
        const Lanes whole(r);
        for (int axis = 0; axis < 3; ++axis) {
            LooseBin& first = s.bins[axis][planes.bin(r.min[axis], axis)];
            ++first.enter, first.enter_box.add(whole);
            LooseBin& last = s.bins[axis][planes.bin(r.max[axis], axis)];
            ++last.leave, last.leave_box.add(whole);
        }
    });
    const auto count = static_cast<uint32_t>(references.size());
    // Visits the planes of an axis, left_box(b) and right_box(b) being what lies on both sides of plane b.
    const auto try_planes = [&](int axis, auto&& left_box, auto&& right_box, SpatialSplit& best) {
        uint32_t left_count = 0, right_count = count;
        for (uint32_t b = 1; b < planes.bins; ++b) {
            left_count += loose.bins[axis][b - 1].enter, right_count -= loose.bins[axis][b - 1].leave;
            if (left_count == 0 || right_count == 0) continue;
            const Box left = left_box(b), right = right_box(b);
            const float cost = left.half_area() * float(left_count) + right.half_area() * float(right_count);
            if (!(cost < best.cost)) continue;
            static_cast<Split&>(best) = {cost, axis, left_count, right_count, left, right};
            best.plane = planes.plane(b, axis);
        }
    };
    SpatialSplit guess;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(planes.scale[axis] > 0.0f)) continue;
        const auto& bins = loose.bins[axis];
        std::array<Lanes, kBins> left, right;
        for (uint32_t b = 1; b < planes.bins; ++b) left[b] = left[b - 1], left[b].add(bins[b - 1].enter_box);
        for (uint32_t b = planes.bins - 1; b > 0; --b) {
            if (b + 1 < planes.bins) right[b] = right[b + 1];
            right[b].add(bins[b].leave_box);
        }
        const auto left_box = [&](uint32_t b) {
            Box cut_box = left[b].box();
            cut_box.max[axis] = std::min(cut_box.max[axis], planes.plane(b, axis));
            return cut_box;
        };
        const auto right_box = [&](uint32_t b) {
            Box cut_box = right[b].box();
            cut_box.min[axis] = std::max(cut_box.min[axis], planes.plane(b, axis));
            return cut_box;
        };
        try_planes(axis, left_box, right_box, guess);
    }
    if (guess.axis < 0) return {};
    const float cut_share = float(guess.left_count + guess.right_count - count) / float(count);
    if (!(guess.cost < (1.0f + kHopefulCut * cut_share) * limit)) return {};

    const int axis = guess.axis;
    const CutBins cuts = team.sum<CutBins>(references, [&](CutBins& s, const Reference& r) {
        const uint32_t first = planes.bin(r.min[axis], axis), last = planes.bin(r.max[axis], axis);
        if (first == last) s.boxes[first].add(Lanes(r));
        else add_cut(triangles[r.index], Lanes(r), axis, planes, first, last, s);
    });
    std::array<Lanes, kBins> left, right;
    for (uint32_t b = 1; b < planes.bins; ++b) left[b] = left[b - 1], left[b].add(cuts.boxes[b - 1]);
    for (uint32_t b = planes.bins - 1; b > 0; --b) {
        if (b + 1 < planes.bins) right[b] = right[b + 1];
        right[b].add(cuts.boxes[b]);
    }
    SpatialSplit best;
    best.cost = limit;
    try_planes(axis, [&](uint32_t b) { return left[b].box(); }, [&](uint32_t b) { return right[b].box(); }, best);
    return best;
}

Parts part_reference(const Reference& r, std::span<const shared::BvhTriangle> triangles, const SpatialSplit& split) {
    const Box box = r.box();
    if (r.max[split.axis] <= split.plane) return {.left = box, .right = {}};
    if (r.min[split.axis] >= split.plane) return {.left = {}, .right = box};
    const Parts parts = cut(triangles[r.index], box, split.axis, split.plane);
    if (parts.left.empty() || parts.right.empty()) return parts;
    // A reference stays whole where that costs less than two parts (Stich et al. 2009, section 4.4).
    const auto grown = [](Box a, const Box& b) {
        a.add(b);
        return a.half_area();
    };
    const float left = split.left.half_area(), right = split.right.half_area(), both = left * float(split.left_count) + right * float(split.right_count);
    const float only_left = grown(split.left, box) * float(split.left_count) + right * float(split.right_count - 1);
    const float only_right = left * float(split.left_count - 1) + grown(split.right, box) * float(split.right_count);
    if (only_left < both && only_left <= only_right) return {.left = box, .right = {}};
    if (only_right < both) return {.left = {}, .right = box};
    return parts;
}

}  // namespace parhelion::bvh
