#pragma once
// What `parhelion --version` says.
#include <string_view>

namespace parhelion {

std::string_view version();  // "0.1.0": the version of the CMake project

}  // namespace parhelion
