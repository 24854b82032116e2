#pragma once
// Trace share: how much of a tracing pass's time its rays alone take.
#include "renderers/reference.h"
#include "renderers/wavefront.h"

namespace parhelion {

struct TraceShare {
    double pass_ms = 0;    // path_trace: one sample of every pixel; or a kernel of the wavefront
    double replay_ms = 0;  // the very same rays, in the same order, traced by a kernel that does nothing else
    uint64_t rays = 0;
    double share() const { return pass_ms > 0 ? replay_ms / pass_ms : 0; }
};

// Median of `repeats` after one warm-up each. The view's film is cleared. Needs GPU timestamps; memory for 48 rays a pixel.
TraceShare measure_trace_share(const gpu::DevicePtr& device, SceneGpu& scene, gpu::TraceWay way, View& view, uint32_t repeats = 5);

// The same of the wavefront's tracing kernels, summed over the iterations of a slice.
struct WavefrontTraceShares {
    TraceShare extend, connect;  // of shadow rays that pass panes only the first part is replayed
};

// The average of `repeats` slices of every pixel and `samples` samples (at most 64), after one to warm up. The view's film is cleared. Needs GPU
// timestamps; memory for a DumpedRay and a word for each ray that waits.
WavefrontTraceShares measure_wavefront_trace_shares(const gpu::DevicePtr& device, SceneGpu& scene, gpu::TraceWay way, View& view, const WavefrontOptions& options,
                                                    uint32_t samples, uint32_t repeats = 3);

}  // namespace parhelion
