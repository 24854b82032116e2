#pragma once
// Direction numbers of a Sobol sequence (Sobol 1967) of shared::kSobolDimensions dimensions. The initial numbers are our own:
// tools/make_sobol.cpp searches them and writes sobol_data.cpp.
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "shared/sampler.h"

namespace parhelion::sampling {

constexpr uint32_t kSobolMaxDegree = 10;

// One dimension: a primitive polynomial over GF(2), bit k being the coefficient of x^k, and as many initial numbers m_1, m_2, ...
// as its degree says, m_k odd and below 2^k. The first dimension, the van der Corput sequence, is polynomial 1 with none.
struct SobolDimension {
    uint32_t polynomial = 1;
    std::array<uint16_t, kSobolMaxDegree> initial{};
};

using SobolDirections = std::array<uint32_t, 32>;

// Direction number k is what bit k of the index adds (by exclusive or) to the coordinate, a 32-bit fixed point fraction.
inline SobolDirections expand_directions(const SobolDimension& dimension) {
    SobolDirections v{};
    const uint32_t degree = static_cast<uint32_t>(std::bit_width(dimension.polynomial)) - 1;
    for (uint32_t k = 0; k < 32; ++k) {
        if (degree == 0) {
            v[k] = 1u << (31 - k);
        } else if (k < degree) {
            v[k] = static_cast<uint32_t>(dimension.initial[k]) << (31 - k);
        } else {
            // Sobol 1967: the recurrence of the polynomial, the lowest term shifted by the degree.
            v[k] = v[k - degree] ^ (v[k - degree] >> degree);
            for (uint32_t i = 1; i < degree; ++i)
                if ((dimension.polynomial >> (degree - i)) & 1u) v[k] ^= v[k - i];
        }
    }
    return v;
}

extern const std::array<SobolDimension, shared::kSobolDimensions> kSobolData;

// The table as the device reads it: uint[kSobolDimensions * 32], dimension by dimension.
const std::vector<uint32_t>& sobol_table();

}  // namespace parhelion::sampling
