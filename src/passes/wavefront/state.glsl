// The wavefront's buffers as its kernels see them (shared/wavefront.h).
#ifndef PARHELION_WAVEFRONT_STATE_GLSL
#define PARHELION_WAVEFRONT_STATE_GLSL
#include "shared/wavefront.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Rays { WavefrontRay v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Paths { WavefrontPath v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Extras { WavefrontExtra v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Slots { WavefrontSlot v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Status { uint v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Samples { vec3 v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Firsts { WavefrontFirst v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Vertices { WavefrontVertex v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Splits { WavefrontSplit v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer ClassSums { WavefrontClassSums v[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Control { WavefrontControl v; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer ViewBlock { ViewData data; };
#endif
