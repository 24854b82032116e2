#pragma once
// A panel for the settings of --set, made from their visitor.
#include "session/render_settings.h"

namespace parhelion::view {

// Widgets for all of them, by group, into the open window. True: one was changed.
bool edit_settings(RenderSettings& settings);

}  // namespace parhelion::view
