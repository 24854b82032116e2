#pragma once
// What a camera does between two moments, as the shaders see it.
#include "shared/view.h"

namespace parhelion {

// The motion that takes the camera `begin` evenly to `end` (shaders/lib/camera_motion.glsl), turning by the shorter way. Both have
// frames of the same handedness; a lens and the kind of projection stay those of `begin`.
shared::CameraMotion camera_motion(const shared::Camera& begin, const shared::Camera& end);

}  // namespace parhelion
