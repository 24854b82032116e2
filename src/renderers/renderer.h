#pragma once
// The reference renderer for a host program's own loop: it only records into the host's command buffer, never submits or waits,
// and draws into the host's image. See examples/embed and docs/embedding.md.
#include "passes/post/post.h"
#include "renderers/reference.h"

namespace parhelion {

struct RendererOptions {
    gpu::TraceWay way = gpu::TraceWay::Compute;
    SceneGpuOptions scene;  // of the acceleration structures only those that `way` needs are made
    uint32_t samples_per_frame = 1;  // at most 64
    float exposure_ev100 = 0.0f;
    passes::ToneCurve curve = passes::ToneCurve::Agx;
};

class Renderer {
public:
    Renderer(gpu::DevicePtr device, const RendererOptions& options);

    // What changed in the scene before this frame (the result of Scene::apply or Scene::begin_frame; call it every frame, also when
    // nothing did). When it shows, every view's film starts anew. `scene` must outlive the next record().
    void sync(const Scene& scene, const ChangeSet& changes);

    // Records one frame of a view; several views may look at the scene. Brings in a slice of what changed in the scene, adds samples
    // to the view's film and writes display values to `ldr` (rgba8, the view's size, in GENERAL; written by compute shaders). What is
    // drawn is the last scene that is complete on the device, before there is any, black. Returns the frame's serial.
    uint64_t record(VkCommandBuffer commands, View& view, const gpu::Image& ldr);

    // The GPU has finished this frame and those before it: what they used may go.
    void retire(uint64_t serial) { frame_.retire(serial); }

    // How far the scene has come, as of the last record(): `complete` once it is drawn as it was at the last sync().
    const SceneProgress& progress() const { return progress_; }
    std::string listing() const { return frame_.listing(); }

private:
    void add_samples(View& view);

    gpu::DevicePtr device_;
    RendererOptions options_;
    Frame frame_;
    SceneGpu scene_;
    SceneProgress progress_;
};

}  // namespace parhelion
