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
    gpu::Buffer rays;   // uint[2][2]: path and shadow rays traced so far, low and high word
    gpu::Buffer first_hits;  // uint[kFirstHitPlaneCount][height][width]; null where none of them is kept
    uint32_t width = 0, height = 0, channel_count = 0;
};

// Variants of the path tracer, which differ in speed or in what they read, never in what they mean.
struct PathTraceOptions {
    bool ray_cones = false;     // textures are read as finely as the paths see them (lib/ray_cone.glsl), not at full resolution
    bool shade_in_hit = false;  // vertices are shaded by the hit and miss shaders: the pipeline way only, without ray cones
};

// Throws a usage Error if the options do not fit each other or the way to trace.
void check_shading(const PathTraceOptions& options, bool pipeline);

// Traces the slice's samples and adds them to the film's block. The slice must lie inside one block.
// Checks the options.
void path_trace(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const shared::Slice& slice, const PathTraceOptions& options);

// The same, keeping the rays: DumpedRay[row_count * width][kMaxDumpedRays]. Further rays of an invocation are not kept.
void path_trace_dumping(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const shared::Slice& slice, const gpu::Buffer& dump);

// Traces dumped rays in the order in which they were traced and does nothing else: the floor under path_trace's time.
void replay_rays(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const gpu::Buffer& dump, const gpu::Buffer& hits, uint32_t width, uint32_t height);

// What is under the centres of the pixels of some rows; needs film.first_hits.
void first_hit(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, uint32_t first_row, uint32_t row_count);

// Ends the running block for the rows of the slice.
void add_block(Frame& frame, const Film& film, const shared::Slice& slice);

}  // namespace parhelion::passes
