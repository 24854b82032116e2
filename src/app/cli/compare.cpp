// parhelion compare: measures, prints, exits with 4 over a limit.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "base/log.h"
#include "base/parse.h"
#include "session/compare.h"
#include "session/results.h"

namespace parhelion::cli {

namespace {

std::optional<double> read_limit(const OptionValues& values, std::string_view name) {
    return values.given(name) ? std::optional(parse_float(values.text(name), name)) : std::nullopt;
}

}  // namespace

int run_compare(const OptionValues& values) {
    const CompareLimits limits{.flip = read_limit(values, "--max-flip"), .relmse = read_limit(values, "--max-relmse")};
    const std::string json = values.given("--json") ? values.text("--json") : "",
                      html = values.given("--html") ? values.text("--html") : "";
    check_json_target(json);
    const CompareReport report =
        compare_files(values.positionals[0], values.positionals[1], values.given("--layer") ? values.text("--layer") : "", limits, html);
    if (json != "-") print_result(compare_text(report));
    write_json(json, compare_json(report));
    for (const std::string& line : report.exceeded) log_line(LogLevel::Error, line);
    return report.exceeded.empty() ? EXIT_SUCCESS : static_cast<int>(ErrorCode::ComparisonExceeded);
}

}  // namespace parhelion::cli
