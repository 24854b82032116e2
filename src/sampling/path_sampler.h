#pragma once
// The path sampler on the host: shaders/lib/sampler.glsl compiled as C++, so both give the same bits. Addresses are those of
// host memory. Used by tests, and wherever the host must know what a path of the device drew.
#include <cstdint>

#include "lib/sampler.glsl"
#include "sampling/blue_noise.h"
#include "sampling/sobol.h"

namespace parhelion::sampling {

inline shared::PathSampler make_sampler(glm::uvec2 pixel, uint32_t sample_index, uint32_t seed, uint32_t kind) {
    return shared::make_sampler(pixel, sample_index, seed, kind, reinterpret_cast<uint64_t>(sobol_table().data()),
                                reinterpret_cast<uint64_t>(blue_noise_words().data()));
}

}  // namespace parhelion::sampling
