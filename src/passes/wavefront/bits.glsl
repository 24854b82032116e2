// A path's class in the bits that its ray and its vertices carry, and its light by class.
#ifndef PARHELION_WAVEFRONT_BITS_GLSL
#define PARHELION_WAVEFRONT_BITS_GLSL
#include "scene/path_class.glsl"
#include "shared/wavefront.h"

uint pack_bits(PathClass path_class) { return path_class.bounce | (path_class.transmitted ? kPathTransmitted : 0u); }
PathRadiance unpack_classes(WavefrontClassSums kept) {
    return PathRadiance(vec3(0.0), kept.emission, kept.direct_diffuse, kept.direct_specular, kept.indirect_diffuse, kept.indirect_specular, kept.transmission);
}
WavefrontClassSums pack_classes(PathRadiance sums) {
    return WavefrontClassSums(sums.emission, sums.direct_diffuse, sums.direct_specular, sums.indirect_diffuse, sums.indirect_specular, sums.transmission);
}
PathClass unpack_class(uint bits, vec3 diffuse_share) { return PathClass(bits & kPathBounces, (bits & kPathTransmitted) != 0u, diffuse_share); }
#endif
