#pragma once
// A recorded frame as text.
#include <span>
#include <string>

#include "frame/frame.h"

namespace parhelion {

// A row a pass. Rows that follow one another again and again, alike but for their times, are printed once, under how often they come,
// numbered as the first time and with the sum of their times.
std::string list_passes(std::span<const PassInfo> passes, bool with_times);

}  // namespace parhelion
