#pragma once
// The moments of samples while a shutter is open.
#include <cstdint>

namespace parhelion::sampling {

// The share of the shutter's time that has passed at this sample, in every pixel: to the bit that of shaders (shaders/lib/camera_motion.glsl).
float shutter_share(uint32_t sample_index, uint32_t seed);

}  // namespace parhelion::sampling
