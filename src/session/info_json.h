#pragma once
// `parhelion info --json`.
#include <nlohmann/json_fwd.hpp>

#include "scene/info.h"

namespace parhelion {

nlohmann::ordered_json info_json(const SceneInfo& info);

}  // namespace parhelion
