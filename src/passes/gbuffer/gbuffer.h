#pragma once
// What lies under the pixels of a view: which triangle (identity), and a summary of its surface for who does not shade it.
// shared/realtime.h says what the images hold.
#include "frame/frame.h"
#include "passes/reference/reference.h"
#include "scene_gpu/scene_gpu.h"
#include "shared/realtime.h"

namespace parhelion::passes {

struct GBuffer {
    gpu::Image identity;  // RGBA32UI
    gpu::Image summary;   // RGBA32UI
    gpu::Image motion;    // RG32F: previous minus current position, pixels; +infinity for what was not in front of the previous camera
    gpu::Image depth;     // R32F: reversed-Z
};
GBuffer make_gbuffer(const gpu::DevicePtr& device, gpu::Extent extent);

// By one ray a pixel through its centre, and the lens.
void trace_identity(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const GBuffer& gbuffer, uint32_t frame_index);

// All the others from the identity, and the film's layers of what is seen first (albedo, normal, emission, roughness). `exposure` is what the summary's emission is multiplied by.
void summarise_surfaces(Frame& frame, const SceneGpu& scene, const Film& film, const GBuffer& gbuffer, uint32_t frame_index, float exposure);

// Where pixels see exact mirrors or panes, all but the identity's triangle becomes that of the surface that is seen through them.
void follow_mirrors(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const GBuffer& gbuffer, uint32_t frame_index, float exposure);

}  // namespace parhelion::passes
