#pragma once
// The reference path tracer: unbiased, accumulates to ground truth. Document 002.
#include "renderers/slice.h"

namespace parhelion {

// Which variant of the path tracer draws the view.
passes::PathTraceOptions trace_options(const ViewDesc& view);
// Throws a usage Error if the view asks for what its way to trace (the pipeline or another) cannot do.
void check_reference(const ViewDesc& view, bool pipeline);

// Records one slice: some samples of some rows. A slice must lie inside one block of 64 samples; it ends the block for its rows
// when its last sample is the block's last, or when `ends_range` (the last sample of the whole job). Only records: no submit, no
// wait. The scene must be drawable (SceneGpu::update). Pictures do not depend on how a job is cut into slices.
void record_reference(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view, const shared::Slice& slice, bool ends_range);

}  // namespace parhelion
