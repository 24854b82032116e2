#pragma once
// Passes from radiance to display.
#include "frame/frame.h"

namespace parhelion::passes {

enum class ToneCurve : uint32_t { Linear, Aces, Agx };

// What of a film is shown: mean x gain + bias of three channels, or of one, in grey.
struct Shown {
    uint64_t samples = 1;  // in the sums of every pixel,
    uint32_t rows_ahead = 0;
    uint64_t samples_ahead = 1;  // but so many in those of the first `rows_ahead` rows
    uint32_t first_channel = 0, channel_count = 3;
    float gain = 1.0f, bias = 0.0f;
};

// The film's mean so far, of the beauty in nits, in an image of the Frame's of that name. `sums` and `block` as in passes::Film. Rows without samples are black.
gpu::Image resolve(Frame& frame, const gpu::Buffer& sums, const gpu::Buffer& block, uint32_t width, uint32_t height, const Shown& shown, const std::string& name = "post/resolve.hdr");

// Display values into `ldr` (rgba8): hdr x exposure_scale, tone curve, sRGB transfer.
void tonemap(Frame& frame, const gpu::Image& hdr, const gpu::Image& ldr, float exposure_scale, ToneCurve curve);

// Any image of a frame that can be sampled, into `ldr` (rgba8): size times gain, or whole numbers as a colour each.
void look(Frame& frame, const gpu::Image& image, const gpu::Image& ldr, float gain);

// Into `ldr`: what is to the left of column `line` out of `left`, the rest out of `right` (rgba8, of any size).
void split(Frame& frame, const gpu::Image& left, const gpu::Image& right, const gpu::Image& ldr, uint32_t line);

}  // namespace parhelion::passes
