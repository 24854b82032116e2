#include "session/version.h"

namespace parhelion {

std::string_view version() { return PARHELION_VERSION; }

}  // namespace parhelion
