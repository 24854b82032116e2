#pragma once
// The commands of the program, one file each. Each gets checked options and returns an exit code; errors are thrown.
#include "base/error.h"
#include "base/platform.h"
#include "session/options.h"

namespace parhelion::cli {

// 0, or 130 and 143 where the work was interrupted (what was finished is written).
inline int exit_code(platform::Interrupt interrupt) {
    if (interrupt == platform::Interrupt::None) return 0;
    return static_cast<int>(interrupt == platform::Interrupt::Terminated ? ErrorCode::Terminated : ErrorCode::Interrupted);
}

int run_render(const OptionValues& values);
int run_view(const OptionValues& values, const std::vector<std::string>& words);
int run_compare(const OptionValues& values);
int run_merge(const OptionValues& values);
int run_devices(const OptionValues& values);
int run_info(const OptionValues& values);
int run_export(const OptionValues& values);
int run_bench(const OptionValues& values);
int run_settings(const OptionValues& values);
int run_help(const OptionValues& values);

}  // namespace parhelion::cli
