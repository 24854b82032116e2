#pragma once
// Panels for what is drawn and how it is shown, into the open window.
#include <string>

#include "session/interactive.h"

namespace parhelion::view {

void show_picture(Interactive& session);  // renderer, reconstruction, exposure, what of the frame is shown
void show_camera(Interactive& session);   // cameras of the scene, lens, clock
void show_split(Interactive& session);    // the reference beside it, and how far apart they are
// All settings, with presets. True: a file of them is wanted.
bool show_settings(Interactive& session);
// Where the machine has several devices: sets `wanted` to the number of another one that is chosen.
void choose_device(const Interactive& session, std::string& wanted);

}  // namespace parhelion::view
