#pragma once
// The tables of directional albedos that the BSDF looks up (shaders/shared/bsdf_tables.h).
#include <cstdint>
#include <vector>

namespace parhelion {

// All sections in their order, kBsdfTableWords words.
std::vector<uint32_t> bsdf_table_words();

}  // namespace parhelion
