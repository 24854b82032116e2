#pragma once
// Passes of the realtime renderer after the G-buffer. A frame's paths live in slots, one a pixel, a band of rows at a time; they are traced
// by the wavefront's kernels, and sorted, shaded and lit by their own.
#include "passes/gbuffer/gbuffer.h"
#include "passes/wavefront/wavefront.h"

namespace parhelion::passes {

// A frame's light at every pixel, pre-exposed, diffuse and specular divided by the surface's colours (realtime/demodulate.glsl).
struct Signals {
    gpu::Buffer diffuse, specular;  // PackedLight[pixels]; what goes through the first surface counts as specular
    gpu::Buffer emission;           // PackedLight[pixels]: seen straight
    gpu::Buffer distances;          // half2[pixels]: metres to what the path met first after the surface, by its diffuse lobe and by others; 0: it took the other
};
Signals make_signals(const gpu::DevicePtr& device, uint64_t pixels);

// Paths of a band: 192 bytes a slot, 20 more in scenes of layered materials, 128 more with reservoirs.
struct LightPaths {
    WavefrontState machine;             // its control, sizes, lists, rays, hits, shadow_rays and shadow_list
    gpu::Buffer paths, pending, sums;   // LightPath, LightPending, LightSums [slots]
    gpu::Buffer inside;                 // LightPathInside[slots]; one without layers
    gpu::Buffer reuse, offers;          // LightReuse, PackedReservoir (what shadow rays offer; after that ChosenSample) [slots]; one without reservoirs,
    gpu::Buffer brings, offered;        // and LightSums: of shadow rays whose light is the path's own too, and of all that it was offered
};
struct LightPathNeeds {
    bool layers = false, reservoirs = false;
};
uint32_t usual_light_paths(const gpu::DeviceCaps& caps);  // a picture of 1920x1080 at once, in a sixteenth of the memory at most
LightPaths make_light_paths(const gpu::DevicePtr& device, uint32_t slots, const LightPathNeeds& needs);

// What the passes of a band have in common.
struct LightPass {
    Frame& frame;
    const SceneGpu& scene;
    gpu::TraceWay way;
    const Film& film;
    const GBuffer& gbuffer;
    const LightPaths& paths;
    const Signals& signals;
    const gpu::Buffer& tiles;
    const gpu::Buffer* cache;  // LightCache::buffer(), where paths may end in it
    const gpu::Buffer* reservoirs;  // PackedReservoir[sets * pixels], where light is shared by them
    shared::RealtimeFrame settings;
    shared::Slice band;        // one sample, of the frame's index, of as many pixels as there are slots at most
    uint32_t round = 0;        // rays that each path has traced
    bool adds = false;         // gather_paths adds to what the signals are already
    bool keeps_offered = false;  // and the first time it keeps beside each what the path was offered, for choose_samples (realtime/offered.glsl)

    WavefrontPass tracing() const;  // for prepare_wavefront and extend
};

void begin_band(const LightPass& pass);    // whose pixels they are, and no list has entries
void sort_pixels(const LightPass& pass);   // its paths by what their pixels see
void sort_paths(const LightPass& pass);    // by what they met
void shade_paths(const LightPass& pass);   // a kernel for plain materials, and one for the rest
void connect_paths(const LightPass& pass);
void gather_paths(const LightPass& pass);  // the band's signals

// The picture, as one sample of the film.
void composite(Frame& frame, const Film& film, const GBuffer& gbuffer, const Signals& signals, float exposure);

// The world cache at what pixels see, into the film's debug layers.
void show_cache(Frame& frame, const SceneGpu& scene, const Film& film, const GBuffer& gbuffer, const gpu::Buffer& cache, uint32_t frame_index);

}  // namespace parhelion::passes
