#pragma once
// `--exposure scene`: the exposure is metered from a small probe render with a fixed seed.
#include <span>

#include "renderers/reference.h"

namespace parhelion {

// EV100 that brings the log-average of these luminances (nits) to a reflected-light meter's middle (ISO 2720, K = 12.5). Black pixels
// and the brightest and darkest 5 % of the others are left out, so that a lamp or a hole in view does not decide. Rounded to 1/100:
// the number that is printed is the number that is used. All black: 0.
double metered_ev(std::span<const float> luminances);

// Renders the probe: the view's camera at about 2300 pixels and 16 samples, seed 0. The result does not depend on the view's size
// (its aspect aside), seed or samples.
double meter_scene(const gpu::DevicePtr& device, Frame& frame, const SceneGpu& scene, gpu::TraceWay way, const ViewDesc& view);

}  // namespace parhelion
