#include "session/view_setup.h"

#include <algorithm>

#include "session/pictures.h"
#include "session/scene_setup.h"

namespace parhelion {

namespace {

std::vector<std::string> layers_of(const RenderOptions& options) {
    std::vector<std::string> layers = options.aovs;
    if (options.denoise != DenoiseKind::Oidn) return layers;
    for (const std::string_view guide : kGuideLayers)
        if (std::ranges::find(layers, guide) == layers.end()) layers.emplace_back(guide);
    return layers;
}

}  // namespace

ViewDesc describe_view(const RenderOptions& options, const RenderSettings& settings, const MovingCamera& camera) {
    const float aspect = static_cast<float>(options.size.width) / static_cast<float>(options.size.height);
    return {.width = options.size.width,
            .height = options.size.height,
            .camera = shader_camera(camera.opens, aspect),
            .camera_at_close = camera.closes ? std::optional(shader_camera(*camera.closes, aspect)) : std::nullopt,
            .seed = options.seed,
            .max_bounces = options.max_bounces == 0 ? 0xFFFFFFFFu : options.max_bounces,
            .sampler = settings.sampler,
            .filter = options.point_filter || options.renderer == RendererKind::Realtime ? PixelFilter::Point : PixelFilter::Box,
            .roulette_start = settings.roulette_start,
            .light_sampling = static_cast<uint32_t>(settings.light_sampling),
            .texture_lod = settings.texture_lod,
            .shade_in = settings.shade_in,
            .energy_compensation = settings.energy_compensation == Switch::On,
            .normal_correction = settings.normal_correction == Switch::On,
            .spawn_offset = settings.spawn_offset,
            .firefly_clamp = settings.firefly_clamp,
            .aovs = layers_of(options)};
}

SceneGpuOptions describe_scene_gpu(const RenderSettings& settings, const TraceDecision& trace, bool draws_pixels) {
    const bool hardware = trace.way != gpu::TraceWay::Compute;
    return {.culling = settings.culling == Culling::Gltf,
            .infinite_share = settings.infinite_share,
            .hardware = hardware,
            .own_bvh = !hardware,
            .raster = draws_pixels,
            .node_layout = trace.layout,
            .bvh_loop = settings.bvh_loop,
            .proxy_ratio = settings.proxy_ratio,
            .proxy_error = settings.proxy_error};
}

}  // namespace parhelion
