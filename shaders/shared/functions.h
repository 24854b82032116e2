// Lets a pure function be written once and compiled as GLSL and as C++20, so that the host computes the very same bits.
// Such a file keeps to what both languages know: SHARED_FN before each function, SHARED_INOUT(T) for an `inout T` parameter,
// functional casts, float literals with f, members instead of swizzles, SHARED_ARRAY(Name, T) to read T[] at an address as
// Name(address).v[i] (in C++ an address of host memory; SHARED_ARRAY_16: the address is a multiple of 16), SHARED_PRECISE before
// a variable whose roundings matter (GLSL's precise). Only operations that are exact (integers, conversions
// of at most 24 bits, products with powers of two) are promised to agree between devices.
#ifndef PARHELION_SHARED_FUNCTIONS_H
#define PARHELION_SHARED_FUNCTIONS_H
#include "shared/types.h"
#ifdef __cplusplus
#include <bit>
#include <cmath>

#define SHARED_FN inline
#define SHARED_INOUT(T) T&
#define SHARED_ARRAY(Name, T) using Name = HostArray<T>;
#define SHARED_ARRAY_16(Name, T) using Name = HostArray<T>;
#define SHARED_PRECISE
namespace parhelion::shared {

template <class T>
struct HostArray {
    explicit HostArray(uint64_t address) : v(reinterpret_cast<const T*>(address)) {}
    const T* v;
};

// GLSL's built-in functions that such files use.
using glm::abs;
using glm::ceil;
using glm::cross;
using glm::dot;
using glm::floatBitsToUint;
using glm::floor;
using glm::max;
using glm::min;
using glm::uintBitsToFloat;
inline float fma(float a, float b, float c) { return std::fma(a, b, c); }  // rounds once; glm's does not
constexpr int findMSB(uint v) { return 31 - std::countl_zero(v); }
constexpr int findLSB(uint v) { return v == 0u ? -1 : std::countr_zero(v); }
constexpr uint bitfieldReverse(uint v) {
    v = ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
    v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
    v = ((v >> 4) & 0x0F0F0F0Fu) | ((v & 0x0F0F0F0Fu) << 4);
    v = ((v >> 8) & 0x00FF00FFu) | ((v & 0x00FF00FFu) << 8);
    return (v >> 16) | (v << 16);
}

}  // namespace parhelion::shared
#else
#define SHARED_FN
#define SHARED_INOUT(T) inout T
#define SHARED_ARRAY(Name, T) layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Name { T v[]; };
#define SHARED_ARRAY_16(Name, T) layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Name { T v[]; };
#define SHARED_PRECISE precise
#endif
#endif
