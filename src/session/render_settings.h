#pragma once
// The settings of `--set group.field=value`: what a picture depends on and seldom needs an option of its own.
#include "base/error.h"
#include "base/settings.h"
#include "gpu/device_class.h"
#include "renderers/realtime.h"
#include "renderers/view.h"
#include "renderers/wavefront.h"
#include "scene/sky.h"

namespace parhelion {

enum class LightSampling : uint32_t { Mis, Light, Bsdf };
enum class Switch : uint32_t { Off, On };
enum class Culling : uint32_t { None, Gltf };

struct RenderSettings {
    SamplerKind sampler = SamplerKind::Owen;
    uint32_t roulette_start = 2;
    LightSampling light_sampling = LightSampling::Mis;
    ShadeIn shade_in = ShadeIn::Raygen;
    Culling culling = Culling::Gltf;
    float proxy_ratio = 1.0f, proxy_error = 0.001f;
    NodeLayout node_layout = NodeLayout::Auto;
    BvhLoop bvh_loop = BvhLoop::Auto;
    float infinite_share = 0.5f;
    float sun_elevation = 40.0f, sun_azimuth = 45.0f;  // degrees
    TextureLod texture_lod = TextureLod::Full;
    Switch energy_compensation = Switch::On, normal_correction = Switch::On;
    SpawnOffset spawn_offset = SpawnOffset::ErrorBounds;
    float firefly_clamp = 0.0f;
    uint32_t wavefront_slots = 0;
    ConnectWhen wavefront_connect = ConnectWhen::Once;
    WavefrontDispatch wavefront_dispatch = WavefrontDispatch::Indirect;
    Switch wavefront_classes = Switch::On;
    uint32_t wavefront_memory_mb = 512;
    RealtimeReuse realtime_reuse = RealtimeReuse::None;
    ReuseOptions reuse;
    GBufferMode gbuffer_mode = GBufferMode::Auto;
    Switch realtime_cache = Switch::On, realtime_tiles = Switch::On;
    uint32_t realtime_candidates = 8, realtime_later_candidates = 4, realtime_path_bounces = 3, realtime_slots = 0;
    CacheOptions cache;
    ReconstructionOptions reconstruction;
};

template <class V>
void visit_cache(V&& v, CacheOptions& s) {
    v.field("cache.cells", s.cells, range(LightCache::kLeastCells, LightCache::kMostCells), "cells that the world cache has room for, 40 bytes each; made a power of two");
    v.field("cache.life", s.life, range(1, shared::kCacheMostLife), "frames that a cell lives on after the camera's paths asked for it");
    v.field("cache.budget", s.budget, range(1, LightCache::kMostCells), "cells that a frame updates, at most a quarter of cache.cells");
    v.field("cache.samples", s.samples, range(1, shared::kCacheMostSamples), "samples that a cell's running mean is worth at most");
    v.field("cache.candidates", s.candidates, range(1, 64), "light samples that a cell's one shadow ray is chosen among");
    v.field("cache.cell_scale", s.cell_scale, range(0.01, 4), "size of a cell over the width of the path's cone there");
    v.field("cache.cell_pixels", s.cell_pixels, range(1, 256), "least size of a cell, in pixels of the camera that looks there");
    v.field("cache.jitter", s.jitter, range(0, 1), "how far look-ups are moved along the surface, in cells: blends neighbours");
    v.field("cache.change_frames", s.change_frames, range(0, 256), "frames after a change of the lights in which cells forget fast");
}

template <class V>
void visit_reuse(V&& v, ReuseOptions& s) {
    v.field("realtime.reservoirs", s.sets, choices({"unified", "split"}), "one reservoir a pixel, or one for direct and one for indirect light");
    v.field("realtime.confidence", s.confidence, range(0, shared::kMostConfidence / 2), "frames that what the last frame knew counts for at most; 0: no temporal reuse");
    v.field("realtime.adapt_confidence", s.adapt_confidence, on_off(), "at most log2 of the lights that there are for each candidate, and nothing below 3: where few lights are, what frames repeat of each other is noise that their means keep");
    v.field("realtime.adapt_offers", s.adapt_offers, on_off(), "where lights are many reservoirs are made of more: eight times realtime.candidates, four times realtime.later_candidates, and two neighbours");
    v.field("realtime.neighbours", s.neighbours, range(0, 8), "pixels around whose samples are taken; 0: no spatial reuse");
    v.field("realtime.radius", s.radius, range(1, 256), "pixels that these are off at most, along each axis");
    v.field("realtime.permutation", s.permutation, on_off(), "near pixels of the last frame are exchanged, so that what is repeated does not stay in place; with realtime.reuse=full edges of shadows darken by it");
}

template <class V>
void visit_reconstruction(V&& v, ReconstructionOptions& s) {
    v.field("reconstruction.history", s.history, range(1, shared::kMostFrames), "frames that a pixel's light is the running mean of, at most");
    v.field("reconstruction.fast_history", s.fast_history, range(1, shared::kMostFrames), "those of the fast mean that the slow one is held against");
    v.field("reconstruction.steps", s.steps, range(0, 8), "steps of the spatial filter, each twice as wide as the one before; 0: none");
    v.field("reconstruction.sigmas", s.sigmas, range(0.01, 100), "standard deviations that the tones of neighbours may differ by in the spatial filter");
    v.field("reconstruction.firefly", s.firefly, range(0, 1e6), "times its brightest neighbour's light: what a pixel has more is shared with them; 0: fireflies stay");
    v.field("reconstruction.antilag", s.antilag, range(0, 1000), "standard errors by which a drift of light must stand out to shorten histories; 0: they never shorten");
    v.field("reconstruction.clamp_width", s.clamp_width, range(0, 1000), "standard deviations around that the slow mean may lie off the fast one's; 0: any");
    v.field("reconstruction.follow", s.follow, on_off(), "what is seen through exact mirrors and panes is filtered as what it is, not as part of them");
    v.field("reconstruction.virtual_motion", s.virtual_motion, on_off(), "look for reflections where they were seen, not only where the surface was");
    v.field("reconstruction.antialias", s.antialias, on_off(), "look elsewhere through pixels in every frame, and put these together");
    v.field("reconstruction.picture_history", s.picture_history, range(1, 1024), "frames that anti-aliasing puts together, at most");
    v.field("reconstruction.kernel", s.kernel, range(0.05, 2), "pixels (with --upscale, of the frame in motion, of the picture at rest): how far off a frame's rays count for a pixel of the picture (standard deviation)");
    v.field("reconstruction.deviations", s.deviations, range(0.1, 100), "standard deviations of the colours around that the picture's history may lie off; twice as many where it stands still");
}

template <class V>
void visit(V&& v, RenderSettings& s) {
    v.field("sampler.kind", s.sampler, choices({"owen", "cranley", "pcg", "white"}),
            "sample points: Owen-scrambled Sobol, Sobol shifted by blue noise, PCG, white noise");
    v.field("reference.roulette_start", s.roulette_start, range(1, 65535), "bounce from which paths may end by Russian roulette");
    v.field("reference.light_sampling", s.light_sampling, choices({"mis", "light", "bsdf"}),
            "direct light by both samplings weighted, by light sampling alone, or by the BSDF's alone");
    v.field("reference.shade_in", s.shade_in, choices({"raygen", "closest_hit"}),
            "which shaders of the ray tracing pipeline shade; closest_hit needs --trace pipeline and texture.lod=full");
    v.field("scene.culling", s.culling, choices({"none", "gltf"}), "gltf: single-sided surfaces are invisible from behind");
    v.field("scene.proxy_ratio", s.proxy_ratio, range(0.001, 1), "share of a mesh's triangles that its proxy keeps, which rays meet in its place; 1: no proxies. What gbuffer.mode=raster draws stays whole");
    v.field("scene.proxy_error", s.proxy_error, range(0, 1), "most that a proxy may deviate (root mean square), in lengths of its mesh: it keeps more triangles rather");
    v.field("light.infinite_share", s.infinite_share, range(0.01, 0.99),
            "share of light samples for sky and directional lights where other lights exist too");
    v.field("trace.bvh", s.node_layout, choices({"auto", "binary", "four", "compact"}),
            "nodes of our own acceleration structure; auto: the fastest for devices of this class");
    v.field("trace.bvh_loop", s.bvh_loop, choices({"auto", "descend", "rounds"}),
            "loop over them: rays wait for each other before leaves, or look at leaves in every round");
    v.field("texture.lod", s.texture_lod, choices({"full", "cone"}),
            "how finely textures are read: full resolution, or as finely as a pixel sees them (ray cones)");
    v.field("bsdf.energy_compensation", s.energy_compensation, choices({"off", "on"}),
            "light that rough surfaces scatter more than once between microfacets: lost, or added");
    v.field("shading.normal_correction", s.normal_correction, choices({"off", "on"}),
            "bend shading normals so that reflections stay above the real surface");
    v.field("reference.spawn_offset", s.spawn_offset, choices({"error_bounds", "integer"}),
            "how rays leave surfaces: moved by bounds of the rounding errors, or by fixed numbers of roundings (document 002)");
    v.field("reference.firefly_clamp", s.firefly_clamp, range(0, 1e30),
            "most nits that one contribution after the first scattering may add to a sample (biased); 0: no limit");
    v.field("wavefront.slots", s.wavefront_slots, range(0, kMaxWavefrontSlots), "paths that are traced at a time; 0: as fits devices of this class");
    v.field("wavefront.connect", s.wavefront_connect, choices({"each_bounce", "once"}),
            "when shadow rays are traced: in every bounce, or once after as many as wavefront.memory_mb allows");
    v.field("wavefront.dispatch", s.wavefront_dispatch, choices({"indirect", "full"}),
            "work sizes from the GPU, or every kernel over all slots (document 003)");
    v.field("wavefront.classes", s.wavefront_classes, choices({"off", "on"}),
            "one kernel of Shade for all materials, or one for each class of them");
    v.field("wavefront.memory_mb", s.wavefront_memory_mb, range(1, 1 << 20), "most that what waits for wavefront.connect=once may take, and as much for finished samples");
    v.field("realtime.reuse", s.realtime_reuse, choices({"full", "none", "unbiased"}),
            "reservoirs that share samples between pixels and frames: fast, none, or weighed with what hides samples so that the mean is the reference's (needs realtime.cache=off)");
    visit_reuse(v, s.reuse);
    v.field("gbuffer.mode", s.gbuffer_mode, choices({"auto", "raster", "trace"}), "what the realtime renderer finds the triangles under pixels with; auto: as suits devices of this class, and trace for a lens or a shutter");
    v.field("realtime.cache", s.realtime_cache, choices({"off", "on"}), "paths end in the world cache, or go to their full depth (--max-bounces)");
    v.field("realtime.tiles", s.realtime_tiles, choices({"off", "on"}), "the first surface's light is chosen among candidates out of light tiles, or sampled as by the reference");
    v.field("realtime.candidates", s.realtime_candidates, range(1, 64), "light samples that the first surface's one is chosen from");
    v.field("realtime.later_candidates", s.realtime_later_candidates, range(0, 64), "light samples that one at later vertices is chosen from where there are at least 64 lights; 0, or fewer lights: one of all lights");
    v.field("realtime.path_bounces", s.realtime_path_bounces, range(1, 64), "reflections after which a path ends in the cache whatever it meets, but for glass");
    v.field("realtime.slots", s.realtime_slots, range(0, 1 << 24), "paths at a time, in bands of whole rows; 0: as suits the device. Pictures do not depend on it");
    visit_cache(v, s.cache);
    visit_reconstruction(v, s.reconstruction);
    v.field("sky.sun_elevation", s.sun_elevation, range(-18, 90), "degrees of the clear sky's sun above the horizon");
    v.field("sky.sun_azimuth", s.sun_azimuth, range(-360, 360), "degrees of the clear sky's sun from +Z towards +X");
}

inline WavefrontOptions wavefront_options(const RenderSettings& s) {
    return {.slots = s.wavefront_slots,
            .connect = s.wavefront_connect,
            .dispatch = s.wavefront_dispatch,
            .classes = s.wavefront_classes == Switch::On,
            .memory_bytes = uint64_t{s.wavefront_memory_mb} << 20,
            .sample_bytes = uint64_t{s.wavefront_memory_mb} << 20};
}

// Throws a usage Error for what the realtime renderer cannot do.
inline void check_realtime(const RenderSettings& s) {
    if (s.realtime_reuse != RealtimeReuse::None && s.firefly_clamp > 0)
        throw Error(ErrorCode::Usage, "samples that are shared are not clamped", "reference.firefly_clamp", "leave it 0, or use realtime.reuse=none");
    if (s.texture_lod != TextureLod::Full || s.shade_in != ShadeIn::Raygen)
        throw Error(ErrorCode::Usage, "the realtime renderer reads textures at full resolution, and shades where it traces", "--renderer realtime", "leave texture.lod and reference.shade_in as they are");
}

// Whether the realtime renderer may draw the triangles under pixels: auto is the table of device classes.
inline bool may_draw_pixels(const RenderSettings& s, const gpu::DeviceCaps& caps) {
    return s.gbuffer_mode == GBufferMode::Raster || (s.gbuffer_mode == GBufferMode::Auto && caps.raster && gpu::device_class(caps).draws_pixels);
}

inline RealtimeOptions realtime_options(const RenderSettings& s, const gpu::DeviceCaps& caps) {
    return {.reuse = s.realtime_reuse,
            .reuse_options = s.reuse,
            .gbuffer = s.gbuffer_mode,
            .auto_draws = may_draw_pixels(s, caps),
            .candidates = s.realtime_candidates,
            .later_candidates = s.realtime_later_candidates,
            .tiles = s.realtime_tiles == Switch::On,
            .cache = s.realtime_cache == Switch::On,
            .path_bounces = s.realtime_path_bounces,
            .slots = s.realtime_slots,
            .cache_options = s.cache};
}

inline SkyOptions sky_options(const RenderSettings& s) {
    return {.sun_elevation = glm::radians(s.sun_elevation), .sun_azimuth = glm::radians(s.sun_azimuth)};
}

}  // namespace parhelion
