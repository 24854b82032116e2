// Constants of the path sampler (shaders/lib/sampler.glsl).
#ifndef PARHELION_SHARED_SAMPLER_H
#define PARHELION_SHARED_SAMPLER_H
#include "shared/types.h"
SHARED_BEGIN

// ViewData::sampler_kind, in the order of `--set sampler.kind=owen|cranley|pcg|white`.
SHARED_CONST uint kSamplerOwen = 0u;
SHARED_CONST uint kSamplerCranley = 1u;
SHARED_CONST uint kSamplerPcg = 2u;
SHARED_CONST uint kSamplerWhite = 3u;
SHARED_CONST uint kSamplerKindCount = 4u;

// Dimensions are numbered by place, not by use: the camera's first, then a fixed block for each scattering. A renderer that
// consumes fewer leaves the rest of its block unused, so that all renderers see equal numbers at equal places.
SHARED_CONST uint kCameraDimensions = 4u;
SHARED_CONST uint kDimensionsPerBounce = 16u;

// Dimensions of the Sobol table, 32 direction numbers each; kSamplerCranley hashes beyond (eight scatterings).
SHARED_CONST uint kSobolDimensions = 128u;

// The blue-noise tile: kBlueNoiseSize^2 ranks, a permutation of 0 ... kBlueNoiseSize^2 - 1, two 16-bit ranks a word, the left
// one of the two pixels in the low half.
SHARED_CONST uint kBlueNoiseSize = 128u;
SHARED_CONST uint kBlueNoiseRankBits = 14u;

SHARED_END
#endif
