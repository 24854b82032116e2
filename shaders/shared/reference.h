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
