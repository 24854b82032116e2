#pragma once
// The reference renderer for a host program's own loop: it only records into the host's command buffer, never submits or waits,
// and draws into the host's image. See examples/embed and docs/embedding.md.
#include "passes/post/post.h"
#include "renderers/reference.h"

namespace parhelion {

struct RendererOptions {
    gpu::TraceWay way = gpu::TraceWay::Compute;
    SceneGpuOptions scene;
    uint32_t samples_per_frame = 1;  // at most 64
    float exposure_ev100 = 0.0f;
    passes::ToneCurve curve = passes::ToneCurve::Agx;
};

class Renderer {
public:
    Renderer(gpu::DevicePtr device, const RendererOptions& options);

    // What changed in the scene before this frame (the result of Scene::apply or Scene::begin_frame; call it every frame, also when
    // nothing did). A change starts every view's film anew. `scene` must outlive the next record().
    void sync(const Scene& scene, const ChangeSet& changes);

    // Records one frame of a view; several views may look at the scene. Brings the scene up to date, adds samples to the view's film and writes display values to `ldr` (rgba8,
    // the view's size, in GENERAL; written by compute shaders). Returns the frame's serial.
    uint64_t record(VkCommandBuffer commands, View& view, const gpu::Image& ldr);

    // The GPU has finished this frame and those before it: what they used may go.
    void retire(uint64_t serial) { frame_.retire(serial); }

    std::string listing() const { return frame_.listing(); }

private:
    gpu::DevicePtr device_;
    RendererOptions options_;
    Frame frame_;
    SceneGpu scene_;
    uint64_t edits_ = 0;  // scene changes so far
};

}  // namespace parhelion
