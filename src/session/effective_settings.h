#pragma once
// `render --print-settings`.
#include <nlohmann/json_fwd.hpp>

#include "session/options.h"

namespace parhelion {

// All options and settings as they would be used, as a preset: read back by --preset it gives the same picture. Options that
// have no value (no camera was named, say) are left out.
nlohmann::ordered_json effective_settings(const OptionValues& values);

}  // namespace parhelion
