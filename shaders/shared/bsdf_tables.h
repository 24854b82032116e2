// Directional albedos that the BSDF looks up: one array of 32-bit words, section after section. tools/bsdf_tables writes a file for
// each section (src/scene_gpu/bsdf_*.bin, little endian), once, by hand: every machine has the very same numbers.
//
// A table has a point on both ends of each axis; the first axis named lies closest in memory. Axes are uniform in
//   mu          sqrt(cosine to the normal): albedos of narrow lobes fall off within a cosine of about alpha = roughness^2
//   roughness   perceptual
// A word is two numbers of 16 bits in [0, 1] (unpackUnorm2x16, the first in the low half), or one float where it says so.
#ifndef PARHELION_SHARED_BSDF_TABLES_H
#define PARHELION_SHARED_BSDF_TABLES_H
#include "shared/types.h"
SHARED_BEGIN

// ---- bsdf_ggx.bin: reflection by GGX with height-correlated masking, Fresnel reflectance by Schlick ----
// The albedo for any f0, f90 is f0 (1 - loss - grazing) + f90 grazing: loss = 1 - int D V cos, what a white microfacet scatters
// more than once; grazing = int D V (1 - cos_h)^5 cos.
SHARED_CONST uint kGgxMu = 128u, kGgxRoughness = 128u;
SHARED_CONST uint kGgxAlbedoAt = 0u;                                    // (loss, grazing) over (mu, roughness)
SHARED_CONST uint kGgxAverageAt = kGgxAlbedoAt + kGgxMu * kGgxRoughness;  // floats: loss, grazing averaged over 2 cos, over roughness
SHARED_CONST uint kGgxWords = kGgxMu * kGgxRoughness + 2u * kGgxRoughness;

SHARED_CONST uint kBsdfTableWords = kGgxWords;

SHARED_END
#endif
