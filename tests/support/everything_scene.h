#pragma once
// A scene with some of everything that Scene holds.
#include "scene/scene.h"

namespace parhelion::testing {

Scene everything_scene();
// A skinned, morphed mesh, with an animation of every path and interpolation.
Scene moving_scene();

}  // namespace parhelion::testing
