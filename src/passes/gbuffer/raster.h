#pragma once
// The visibility buffer by raster: which triangle each pixel's centre sees, as the traced one says it.
#include "frame/frame.h"
#include "passes/reference/reference.h"
#include "scene_gpu/scene_gpu.h"

namespace parhelion::passes {

// What a view's raster passes keep from frame to frame. Device memory: per pixel 4 bytes of depth and 4/3 of its pyramid; per geometry of an
// instance 32 bytes of draws.
struct RasterHistory {
    gpu::Image depth;     // of the last frame: reversed, near / z with near = 2^-20 m; orthographic 1 - z / far
    gpu::Buffer pyramid;  // farthest depths of the last frame's first pass
    gpu::Buffer bits, draws, counts;
    bool has_pyramid = false;

    void reset() { has_pyramid = false; }  // the next frame has nothing to do with the last
};

struct RasterOptions {
    bool occlusion = true;  // what the depth hides is not drawn; false: all that the camera may see. The picture is the same
};

// Bytes of raster_depth's pyramid; for tests.
uint64_t depth_pyramid_bytes(gpu::Extent extent);

// Writes `identity` (rgba32ui, of the film's extent): x Hit::instance_bits, y geometry of the mesh, z primitive; x kHitMiss where there is nothing.
// Also history.depth. The film's view has a camera without a lens, whose shutter is taken as closed; its camera_before and the instances'
// previous transforms only help culling. `frame_index` picks which blended surfaces are there: hash_ray(pixel, frame_index, seed, 0, kRayPath).
// Of two triangles of exactly equal depth the one drawn first is seen, by kind and row, what the second pass draws after the first's.
// The scene has SceneGpuOptions::raster, the device DeviceCaps::raster.
void raster_identity(Frame& frame, const SceneGpu& scene, const Film& film, const gpu::Image& identity, RasterHistory& history, uint32_t frame_index,
                     const RasterOptions& options = {});

}  // namespace parhelion::passes
