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
SHARED_CONST uint kGgxAt = 0u;
SHARED_CONST uint kGgxAlbedoAt = kGgxAt;                                // (loss, grazing) over (mu, roughness)
SHARED_CONST uint kGgxAverageAt = kGgxAlbedoAt + kGgxMu * kGgxRoughness;  // floats: loss, grazing averaged over 2 cos, over roughness
SHARED_CONST uint kGgxWords = kGgxMu * kGgxRoughness + 2u * kGgxRoughness;

// ---- bsdf_layers.bin: a clear coat and sheen, and what they turn back of the light that comes up from the surface below ----
// Sheen's roughness is drawn as at least this: fibres that diverge less reflect at grazing angles only. Its axes begin there: a place
// on them is (roughness - kMinSheenRoughness) / (1 - kMinSheenRoughness).
SHARED_CONST float kMinSheenRoughness = 0.1f;
// (albedo, cap) over (mu, roughness): the lobe seen from o is multiplied by cap(o) cap(i), because Charlie sheen alone returns more
// than it gets at grazing angles.
SHARED_CONST uint kSheenMu = 65u, kSheenRoughness = 65u;
SHARED_CONST uint kSheenAlbedoAt = kGgxAt + kGgxWords;
SHARED_CONST uint kSheenAverageAt = kSheenAlbedoAt + kSheenMu * kSheenRoughness;  // floats: albedo averaged over 2 cos, 0; over roughness
// Albedo of a layer averaged over the GGX lobe of the surface below: (int s (1 - F) D V cos, int s F D V cos), F = (1 - cos_h)^5, over
// (mu, roughness below, roughness of the layer); and over the hemisphere: (the layer's albedo averaged with the weight loss(mu) cos,
// its average with grazing(mu) 2 cos), over the two roughnesses.
SHARED_CONST uint kLayerMu = 64u, kLayerBelow = 32u, kLayerRoughness = 24u;
SHARED_CONST uint kCoatOverGgxAt = kSheenAverageAt + 2u * kSheenRoughness;
SHARED_CONST uint kSheenOverGgxAt = kCoatOverGgxAt + kLayerMu * kLayerBelow * kLayerRoughness;
SHARED_CONST uint kCoatOverLossAt = kSheenOverGgxAt + kLayerMu * kLayerBelow * kLayerRoughness;
SHARED_CONST uint kSheenOverLossAt = kCoatOverLossAt + kLayerBelow * kLayerRoughness;
// (int of the coat's albedo over the sheen lobe, 0) over (mu, roughness of the sheen, roughness of the coat).
SHARED_CONST uint kCoatOverSheenAt = kSheenOverLossAt + kLayerBelow * kLayerRoughness;
SHARED_CONST uint kLayersWords = kCoatOverSheenAt + kLayerMu * kLayerRoughness * kLayerRoughness - kSheenAlbedoAt;

// The clear coat's reflectance at normal incidence (KHR_materials_clearcoat: index 1.5).
SHARED_CONST float kCoatF0 = 0.04f;

// ---- bsdf_glass.bin: what rough glass scatters more than once, reflected and refracted light together ----
// 1 - the albedo (without the square of the index): (with all of Fresnel's reflectance, with none but where it is total). Over
//   mu          fourth root of the cosine: towards grazing it is as cos^Lambda(the other side)
//   roughness   square root of the perceptual
//   index       square root of r / kGlassMaxReflection, r = (n - 1) / (n + 1) of the denser over the rarer side
//   side        light from the rarer side, light from the denser one
SHARED_CONST uint kGlassMu = 48u, kGlassRoughness = 48u, kGlassIndices = 32u;
SHARED_CONST float kGlassMaxReflection = 0.5f;  // n = 3
SHARED_CONST uint kGlassLossAt = kGgxAt + kGgxWords + kLayersWords;
SHARED_CONST uint kGlassAverageAt = kGlassLossAt + 2u * kGlassMu * kGlassRoughness * kGlassIndices;  // the same averaged over 2 cos: two floats each
SHARED_CONST uint kGlassWords = 2u * kGlassMu * kGlassRoughness * kGlassIndices + 4u * kGlassRoughness * kGlassIndices;

// ---- bsdf_coated_glass.bin: what layers over rough glass turn back ----
// The layers' albedo over x = sqrt(cosine) is known at kTurnedBasis points and interpolated piecewise by parabolas: the sum of its
// values times functions phi_k(x). A table of each k: the mean of phi_k over a lobe, for whatever lies on top. Values v of -0.2 to 1 are kept as
// (v + 0.2) / 1.2; pairs, axes and sides are those of bsdf_glass.bin, but from the denser side mu is densest around the critical angle's
// cosine c, which is its middle: 1/2 + sqrt((cosine - c) / (1 - c)) / 2 above, acos(1 - 2 cosine / c) / (2 pi) below.
SHARED_CONST uint kTurnedMu = 24u, kTurnedRoughness = 16u, kTurnedIndices = 8u, kTurnedBasis = 13u;
SHARED_CONST uint kTurnedLobe = kTurnedMu * kTurnedRoughness * kTurnedIndices, kTurnedAverage = kTurnedRoughness * kTurnedIndices;
// int phi_k over what crosses once (phi_k of the cosine beyond), and over what is reflected once; over (mu, roughness, index), for each side and k.
SHARED_CONST uint kTurnedCrossingAt = kGlassLossAt + kGlassWords;
SHARED_CONST uint kTurnedReflectedAt = kTurnedCrossingAt + 2u * kTurnedBasis * kTurnedLobe;
// The mean of phi_k weighted by 2 cos loss, the loss being that of bsdf_glass.bin; over (roughness, index), for each side and k.
SHARED_CONST uint kTurnedLossAt = kTurnedReflectedAt + 2u * kTurnedBasis * kTurnedLobe;
// For walls: int phi_k over the white GGX lobe over (mu, roughness), and the mean of phi_k weighted by 2 cos loss over roughness, for each k; 0 in the high half.
SHARED_CONST uint kTurnedMirroredAt = kTurnedLossAt + 2u * kTurnedBasis * kTurnedAverage;
SHARED_CONST uint kTurnedMirroredLossAt = kTurnedMirroredAt + kTurnedBasis * kTurnedMu * kTurnedRoughness;
SHARED_CONST uint kCoatedGlassWords = kTurnedMirroredLossAt + kTurnedBasis * kTurnedRoughness - kTurnedCrossingAt;

SHARED_CONST uint kBsdfTableWords = kGgxWords + kLayersWords + kGlassWords + kCoatedGlassWords;

SHARED_END
#endif
