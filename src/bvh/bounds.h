#pragma once
// Boxes for inner loops, of four floats that fit a register: compilers make one instruction of each of these functions, and six of glm's
// on vec3.
#include <glm/glm.hpp>

#include "bvh/wide_tree.h"

namespace parhelion::bvh {

struct alignas(16) Four {
    float v[4];
};

inline Four all_four(float x) { return {{x, x, x, x}}; }
inline Four operator+(const Four& a, const Four& b) {
    Four out;
    for (int i = 0; i < 4; ++i) out.v[i] = a.v[i] + b.v[i];
    return out;
}
inline Four operator-(const Four& a, const Four& b) {
    Four out;
    for (int i = 0; i < 4; ++i) out.v[i] = a.v[i] - b.v[i];
    return out;
}
inline Four operator*(const Four& a, const Four& b) {
    Four out;
    for (int i = 0; i < 4; ++i) out.v[i] = a.v[i] * b.v[i];
    return out;
}
inline Four lower(const Four& a, const Four& b) {
    Four out;
    for (int i = 0; i < 4; ++i) out.v[i] = a.v[i] < b.v[i] ? a.v[i] : b.v[i];
    return out;
}
inline Four higher(const Four& a, const Four& b) {
    Four out;
    for (int i = 0; i < 4; ++i) out.v[i] = a.v[i] > b.v[i] ? a.v[i] : b.v[i];
    return out;
}

// Of all four.
inline float lowest(const Four& a) {
    const Four pairs = lower(a, {{a.v[2], a.v[3], a.v[0], a.v[1]}});
    return lower(pairs, {{pairs.v[1], pairs.v[0], pairs.v[3], pairs.v[2]}}).v[0];
}
inline float highest(const Four& a) {
    const Four pairs = higher(a, {{a.v[2], a.v[3], a.v[0], a.v[1]}});
    return higher(pairs, {{pairs.v[1], pairs.v[0], pairs.v[3], pairs.v[2]}}).v[0];
}

// The fourth float means nothing.
struct Bounds {
    Four low{{3e38f, 3e38f, 3e38f, 3e38f}}, high{{-3e38f, -3e38f, -3e38f, -3e38f}};  // empty
    void add(const Bounds& b) { low = lower(low, b.low), high = higher(high, b.high); }
    void add(const Four& p) { low = lower(low, p), high = higher(high, p); }
    float extent(int axis) const { return high.v[axis] - low.v[axis]; }
    float half_area() const { return extent(0) * extent(1) + extent(1) * extent(2) + extent(2) * extent(0); }  // not if it is empty
    int widest() const { return extent(0) >= extent(1) && extent(0) >= extent(2) ? 0 : extent(1) >= extent(2) ? 1 : 2; }
    float center(int axis) const { return low.v[axis] + high.v[axis]; }  // twice: saves a product
    Four center() const { return low + high; }
};

inline Bounds to_bounds(const Box& box) { return {{{box.min.x, box.min.y, box.min.z, 0}}, {{box.max.x, box.max.y, box.max.z, 0}}}; }
inline Box to_box(const Bounds& b) { return {{b.low.v[0], b.low.v[1], b.low.v[2]}, {b.high.v[0], b.high.v[1], b.high.v[2]}}; }

// The four boxes' coordinates along an axis.
inline glm::vec4 lows(const Bounds (&b)[4], int axis) { return {b[0].low.v[axis], b[1].low.v[axis], b[2].low.v[axis], b[3].low.v[axis]}; }
inline glm::vec4 highs(const Bounds (&b)[4], int axis) { return {b[0].high.v[axis], b[1].high.v[axis], b[2].high.v[axis], b[3].high.v[axis]}; }

}  // namespace parhelion::bvh
