// A path's class in the bits that its ray and its vertices carry.
#ifndef PARHELION_WAVEFRONT_BITS_GLSL
#define PARHELION_WAVEFRONT_BITS_GLSL
#include "scene/path_class.glsl"
#include "shared/wavefront.h"

uint pack_bits(PathClass path_class, uint sample_offset) {
    return path_class.bounce | (path_class.transmitted ? kPathTransmitted : 0u) | (sample_offset << kPathSampleShift);
}
PathClass unpack_class(uint bits, vec3 diffuse_share) { return PathClass(bits & kPathBounces, (bits & kPathTransmitted) != 0u, diffuse_share); }
#endif
