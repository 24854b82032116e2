#pragma once
// Blue noise by void and cluster (Ulichney 1993, "The Void-and-Cluster Method for Dither Array Generation"): a tile of ranks in
// which the pixels of any rank range are spread evenly and which has no low frequencies; it repeats without seams.
#include <cstdint>
#include <vector>

#include "shared/sampler.h"

namespace parhelion::sampling {

// size x size ranks, row by row: a permutation of 0 ... size^2 - 1, a function of size and seed alone on any machine.
// `size` is a power of two from 16 to 256.
std::vector<uint16_t> make_blue_noise(uint32_t size, uint32_t seed);

// The tile that the samplers use, as the device reads it (shared/sampler.h): made at the first call, in tens of milliseconds.
const std::vector<uint32_t>& blue_noise_words();

}  // namespace parhelion::sampling
