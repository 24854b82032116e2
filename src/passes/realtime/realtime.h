#pragma once
// Passes of the realtime renderer after the G-buffer.
#include "passes/gbuffer/gbuffer.h"

namespace parhelion::passes {

// A frame's light at every pixel, pre-exposed, diffuse and specular divided by the surface's colours (realtime/demodulate.glsl).
struct Signals {
    gpu::Buffer diffuse, specular;  // PackedLight[pixels]; what goes through the first surface counts as specular
    gpu::Buffer emission;           // PackedLight[pixels]: seen straight
    gpu::Buffer distances;          // half2[pixels]: metres to what the path met first, twice
    gpu::Buffer list;               // realtime/listed.glsl: work size, count, uint[pixels]
};
Signals make_signals(const gpu::DevicePtr& device, uint64_t pixels);

// `cache`: LightCache::buffer(), where paths may end in it.
void light(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const Film& film, const GBuffer& gbuffer, const gpu::Buffer& tiles, const gpu::Buffer* cache,
           const Signals& signals, shared::RealtimeFrame settings);

// The picture, as one sample of the film.
void composite(Frame& frame, const Film& film, const GBuffer& gbuffer, const Signals& signals, float exposure);

}  // namespace parhelion::passes
