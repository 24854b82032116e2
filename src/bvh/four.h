#pragma once
// Four floats that fit a register. Compilers make one instruction of each of these functions, and six of glm's on vec3.

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

}  // namespace parhelion::bvh
