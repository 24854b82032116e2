#pragma once
// The order of an environment table's cells, as shaders have it: shaders/lib/cell_order.glsl compiled as C++.
#include "lib/cell_order.glsl"

namespace parhelion::sampling {

using shared::cell_at;
using shared::cell_place;

}  // namespace parhelion::sampling
