#include "renderers/renderer.h"

#include <algorithm>
#include <cmath>

namespace parhelion {

Renderer::Renderer(gpu::DevicePtr device, const RendererOptions& options)
    : device_(device), options_(options), frame_(device, {.timers = false, .markers = false}), scene_(device, options.scene) {}

void Renderer::sync(const Scene& scene, const ChangeSet& changes) {
    scene_.sync(scene, changes);
    if (!changes.empty()) ++edits_;
}

uint64_t Renderer::record(VkCommandBuffer commands, View& view, const gpu::Image& ldr) {
    View::Accumulation& done = view.accumulation();
    if (done.scene_edits != edits_) view.clear_film();
    done.scene_edits = edits_;
    const uint32_t first = static_cast<uint32_t>(done.samples), in_block = shared::kSamplesPerBlock - first % shared::kSamplesPerBlock;
    const uint32_t count = std::clamp(options_.samples_per_frame, 1u, in_block);
    const shared::Slice slice{.first_row = 0, .row_count = view.film().height, .first_sample = first, .sample_count = count};
    record_reference(frame_, scene_, options_.way, view, slice, false);
    done.samples += count;
    const passes::Film& film = view.film();
    const gpu::Image hdr = passes::resolve(frame_, film.sums, film.block, film.width, film.height, done.samples);
    passes::tonemap(frame_, hdr, ldr, 1.0f / (1.2f * std::exp2(options_.exposure_ev100)), options_.curve);
    gpu::CommandList list(device_, commands);
    return frame_.record(list);
}

}  // namespace parhelion
