// parhelion compare: measures, prints, exits with 4 over a limit.
#include "app/cli/commands.h"
#include "base/error.h"

namespace parhelion::cli {

int run_compare(const OptionValues&) { throw Error(ErrorCode::Failed, "is not built yet", "compare"); }

}  // namespace parhelion::cli
