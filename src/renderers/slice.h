#pragma once
// What the path tracers do alike around a slice of work: some samples of some rows, inside one block of 64 samples.
#include "renderers/view.h"

namespace parhelion {

// Uploads what changed in the view, and finds what is under the pixels' centres where that is asked for. Throws for a slice that is not
// inside one block and the film.
void begin_slice(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view, const shared::Slice& slice);
// Adds the block to the film's exact sums if the slice ends it: its last sample is the block's, or the last of the whole job.
void end_slice(Frame& frame, View& view, const shared::Slice& slice, bool ends_range);

// Ends the running block of every row, whatever its number of samples: for a job that stops inside a block. Sums that it was
// called on are those of a picture; more samples of the same block cannot follow.
void end_block(Frame& frame, View& view);

}  // namespace parhelion
