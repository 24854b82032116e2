// Invocations of a compute kernel over a list, numbered along the rows of its work groups: a device may take only 65,535 along one.
#ifndef PARHELION_WAVEFRONT_LINEAR_GLSL
#define PARHELION_WAVEFRONT_LINEAR_GLSL
#include "shared/wavefront.h"

layout(local_size_x = kWavefrontGroup) in;
uint invocation_index() { return gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * kWavefrontGroup) + gl_GlobalInvocationID.x; }
#endif
