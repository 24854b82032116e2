#pragma once
// The commands of the program, one file each. Each gets checked options and returns an exit code; errors are thrown.
#include "session/options.h"

namespace parhelion::cli {

int run_render(const OptionValues& values);
int run_compare(const OptionValues& values);
int run_merge(const OptionValues& values);
int run_devices(const OptionValues& values);
int run_info(const OptionValues& values);
int run_bench(const OptionValues& values);
int run_settings(const OptionValues& values);
int run_help(const OptionValues& values);

}  // namespace parhelion::cli
