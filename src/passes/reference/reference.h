#pragma once
// Passes of the reference path tracer.
#include "frame/frame.h"
#include "scene_gpu/scene_gpu.h"
#include "shared/reference.h"

namespace parhelion::passes {

// Device memory of one view's film. `block` holds float sums of the running 64 samples, `sums` the exact ones of all blocks
// before it; planar, see lib/fixed_point.glsl.
struct Film {
    gpu::Buffer view;   // shared::ViewData
    gpu::Buffer block;  // float[channel_count][height][width]
    gpu::Buffer sums;   // uint[channel_count][3][height][width]
    uint32_t width = 0, height = 0, channel_count = 0;
};

// Traces the slice's samples and adds them to the film's block. The slice must lie inside one block.
void path_trace(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const shared::Slice& slice);

// Ends the running block for the rows of the slice.
void add_block(Frame& frame, const Film& film, const shared::Slice& slice);

}  // namespace parhelion::passes
