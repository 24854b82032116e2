#pragma once
// Random numbers of built-in scenes: the same on every machine, unlike the distributions of the standard library.
#include <cstdint>

#include <glm/glm.hpp>

namespace parhelion::builtin {

// The 32-bit hash "pcg" of Jarzynski and Olano, "Hash Functions for GPU Rendering", 2020.
inline uint32_t hash_u32(uint32_t x) {
    const uint32_t state = x * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
inline uint32_t hash_u32(uint32_t x, uint32_t y) { return hash_u32(x ^ hash_u32(y)); }

// A stream of numbers that depends on (seed, stream) alone.
class Random {
public:
    explicit Random(uint32_t seed, uint32_t stream = 0) : key_(hash_u32(seed, hash_u32(stream + 0x9e3779b9u))) {}
    uint32_t bits() { return hash_u32(key_, counter_++); }
    float unit() { return float(bits() >> 8) * 0x1p-24f; }  // [0, 1)
    float range(float low, float high) { return low + (high - low) * unit(); }
    uint32_t below(uint32_t n) { return uint32_t((uint64_t(bits()) * n) >> 32); }

private:
    uint32_t key_, counter_ = 0;
};

}  // namespace parhelion::builtin
