#pragma once
// A display without a screen, for programs with a window.
#include <string>

namespace parhelion::testing {

// The name of an X server (Xvfb) that runs until the process ends; empty: it is not installed.
const std::string& virtual_display();

}  // namespace parhelion::testing
