#pragma once
// Light samples that are drawn before anyone needs them (shared/realtime.h).
#include "frame/frame.h"
#include "scene_gpu/scene_gpu.h"
#include "shared/realtime.h"

namespace parhelion::passes {

// TileSample[kTileCount][kTileSamples], 4 MiB.
gpu::Buffer make_light_tiles(const gpu::DevicePtr& device);
// Draws them anew for a frame of a picture's size; before anyone reads them.
void draw_light_tiles(Frame& frame, const SceneGpu& scene, const gpu::Buffer& tiles, uint32_t frame_index, uint32_t seed, glm::uvec2 size);

}  // namespace parhelion::passes
