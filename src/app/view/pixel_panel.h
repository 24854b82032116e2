#pragma once
// The panel of a pixel that was looked into, and its path over the picture.
#include "session/interactive.h"

namespace parhelion::view {

// Nothing, where none has been. `left`: where its window begins, in pixels.
void show_pixel(Interactive& session, float left);

}  // namespace parhelion::view
