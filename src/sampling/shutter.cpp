#include "sampling/shutter.h"

#include "lib/camera_motion.glsl"

namespace parhelion::sampling {

float shutter_share(uint32_t sample_index, uint32_t seed) { return shared::shutter_share(sample_index, seed); }

}  // namespace parhelion::sampling
