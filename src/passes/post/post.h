#pragma once
// Passes from radiance to display.
#include "frame/frame.h"

namespace parhelion::passes {

enum class ToneCurve : uint32_t { Linear, Aces, Agx };

// The film's mean so far in nits. `sums` and `block` as in passes::Film, `sample_count` samples of every pixel.
gpu::Image resolve(Frame& frame, const gpu::Buffer& sums, const gpu::Buffer& block, uint32_t width, uint32_t height, uint64_t sample_count);

// Display values into `ldr` (rgba8): hdr x exposure_scale, tone curve, sRGB transfer.
void tonemap(Frame& frame, const gpu::Image& hdr, const gpu::Image& ldr, float exposure_scale, ToneCurve curve);

}  // namespace parhelion::passes
