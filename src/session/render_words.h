#pragma once
// What a window shows as a command line: `parhelion render` with these words draws the very picture.
#include <string>
#include <vector>

#include "session/interactive.h"
#include "session/options.h"

namespace parhelion {

// Words after `parhelion`. `given`: the options that the window was opened with; what the session has changed since wins over them. The
// picture has as many samples as the session's: in every pixel, and at least one. Of the realtime renderer it is the mean of its frames
// since it began anew (Interactive::begin_anew).
std::vector<std::string> render_words(const OptionValues& given, const Interactive& session);

// A line for a POSIX shell.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace parhelion
