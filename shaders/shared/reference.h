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

SHARED_END
#endif
