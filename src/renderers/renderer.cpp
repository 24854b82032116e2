#include "renderers/renderer.h"

#include <algorithm>
#include <cmath>

namespace parhelion {

namespace {

SceneGpuOptions scene_options(const RendererOptions& options) {
    SceneGpuOptions scene = options.scene;
    scene.hardware = scene.hardware && options.way != gpu::TraceWay::Compute;
    scene.own_bvh = options.way == gpu::TraceWay::Compute;
    return scene;
}

}  // namespace

Renderer::Renderer(gpu::DevicePtr device, const RendererOptions& options)
    : device_(device), options_(options), frame_(device, {.timers = Timers::None, .markers = false}), scene_(device, scene_options(options)) {}

void Renderer::sync(const Scene& scene, const ChangeSet& changes) { scene_.sync(scene, changes); }

uint64_t Renderer::record(VkCommandBuffer commands, View& view, const gpu::Image& ldr) {
    progress_ = scene_.update(frame_);
    View::Accumulation& done = view.accumulation();
    if (done.scene_version != scene_.version() || !progress_.drawable) view.clear_film();
    done.scene_version = scene_.version();
    if (progress_.drawable) add_samples(view);
    else view.prepare(frame_);
    const passes::Film& film = view.film();
    const gpu::Image hdr = passes::resolve(frame_, film.sums, film.block, film.width, film.height, {.samples = done.samples});
    passes::tonemap(frame_, hdr, ldr, 1.0f / (1.2f * std::exp2(options_.exposure_ev100)), options_.curve);
    gpu::CommandList list(device_, commands);
    return frame_.record(list);
}

void Renderer::add_samples(View& view) {
    View::Accumulation& done = view.accumulation();
    const uint32_t first = static_cast<uint32_t>(done.samples), in_block = shared::kSamplesPerBlock - first % shared::kSamplesPerBlock;
    const uint32_t count = std::clamp(options_.samples_per_frame, 1u, in_block);
    const shared::Slice slice{.first_row = 0, .row_count = view.film().height, .first_sample = first, .sample_count = count};
    record_reference(frame_, scene_, options_.way, view, slice, false);
    done.samples += count;
}

}  // namespace parhelion
