#pragma once
// What measures the tracing kernels of the wavefront: the rays that they have just traced, traced once more by a kernel that does
// nothing else.
#include "passes/wavefront/wavefront.h"

namespace parhelion::passes {

enum class WavefrontTraced : uint32_t { Rays, ShadowRays };  // by Extend; by Connect

// Most rays that one of them traces at a time.
uint64_t most_rays(const WavefrontShape& shape, WavefrontTraced what);

// Directly after the kernel: before another one changes its list. `dump`: room for most_rays() of shared::DumpedRay.
void dump_rays(const WavefrontPass& pass, WavefrontTraced what, const gpu::Buffer& dump);
// After that. Shadow rays are replayed as far as the first pane that they pass. `hits`: room for most_rays() of uint32_t.
void replay_rays(const WavefrontPass& pass, WavefrontTraced what, const gpu::Buffer& dump, const gpu::Buffer& hits);

}  // namespace parhelion::passes
