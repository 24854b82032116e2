// parhelion merge: parts to one picture.
#include <cstdlib>
#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "base/log.h"
#include "session/merge.h"
#include "session/results.h"

namespace parhelion::cli {

int run_merge(const OptionValues& values) {
    const OutputOptions output = read_output_options(values);
    const std::string json = values.given("--json") ? values.text("--json") : "";
    check_json_target(json);
    const std::vector<std::filesystem::path> parts(values.positionals.begin(), values.positionals.end());
    const uint64_t samples = merge_to_pictures(parts, output);
    log(LogLevel::Info, "{} parts with {} samples in all", parts.size(), samples);
    write_json(json, {{"parts", parts.size()}, {"spp", samples}});
    return EXIT_SUCCESS;
}

}  // namespace parhelion::cli
