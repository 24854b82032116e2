// Work of one pass over many jobs of different sizes, cut into equal pieces.
#ifndef PARHELION_SHARED_CHUNKS_H
#define PARHELION_SHARED_CHUNKS_H
#include "shared/types.h"
SHARED_BEGIN

// What a work group does: kWorkChunk items of a job, from `first` on. kWorkGroups groups lie in a row of the dispatch.
SHARED_CONST uint kWorkChunk = 64u;
SHARED_CONST uint kWorkGroups = 1024u;
struct WorkChunk {
    uint job, first;
};

SHARED_END
#endif
