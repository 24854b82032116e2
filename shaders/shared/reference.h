// Push constants of the reference renderer's passes.
#ifndef PARHELION_SHARED_REFERENCE_H
#define PARHELION_SHARED_REFERENCE_H
#include "shared/view.h"
SHARED_BEGIN

// A slice of work: some rows, some consecutive samples of one block.
struct Slice {
    uint first_row, row_count;
    uint first_sample, sample_count;
};

// What is under a pixel's centre, one plane of 32-bit words each: floats (depth, motion) and whole numbers.
SHARED_CONST uint kFirstHitDepth = 0u;
SHARED_CONST uint kFirstHitInstance = 1u;
SHARED_CONST uint kFirstHitGeometry = 2u;
SHARED_CONST uint kFirstHitPrimitive = 3u;
SHARED_CONST uint kFirstHitMaterial = 4u;
SHARED_CONST uint kFirstHitMotionX = 5u;
SHARED_CONST uint kFirstHitMotionY = 6u;
SHARED_CONST uint kFirstHitPlaneCount = 7u;

// `bench replay`: rays as path_trace met them, kMaxDumpedRays slots an invocation; a slot of zeros is unused.
SHARED_CONST uint kMaxDumpedRays = 48u;
struct DumpedRay {
    vec3 origin_ws;
    float reach;  // t_max; negative: a shadow ray
    vec3 direction_ws;
    uint alpha_key;
};

SHARED_END
#endif
