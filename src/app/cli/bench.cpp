// parhelion bench: measures, prints a table.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "base/log.h"
#include "session/bench.h"
#include "session/bench_realtime.h"
#include "session/results.h"
#include "session/trace_bench.h"

namespace parhelion::cli {

namespace {

int bench_realtime(const OptionValues& values, const gpu::DevicePtr& device, const std::string& json) {
    const RealtimeBenchOptions options = read_realtime_bench_options(values, device->caps());
    std::vector<RealtimeBenchRow> rows;
    for (const std::string& scene : options.scenes) {
        if (platform::interrupt_requested() != platform::Interrupt::None) break;
        rows.push_back(run_realtime_bench(scene, options, device));
    }
    if (json != "-") print_result(realtime_bench_table(rows, options));
    write_json(json, realtime_bench_json(rows, options, device->caps()));
    return exit_code(platform::interrupt_requested());
}

}  // namespace

int run_bench(const OptionValues& values) {
    const bool realtime = !values.positionals.empty() && values.positionals.front() == "realtime";
    for (const std::string_view option : {"--denoise", "--upscale"})
        if (values.given(option) && !realtime) throw Error(ErrorCode::Usage, "fits bench realtime alone", values.where(option), "leave it out");
    if (!values.positionals.empty() && values.positionals.front() == "trace") return run_trace_bench_command(values, std::nullopt);
    if (values.flag("--layouts")) throw Error(ErrorCode::Usage, "fits bench trace alone", "--layouts", "leave it out");
    const std::string json = values.given("--json") ? values.text("--json") : "";
    check_json_target(json);
    const gpu::DevicePtr device = gpu::Device::open({.selector = values.given("--device") ? values.text("--device") : ""});
    if (realtime) return bench_realtime(values, device, json);
    const std::vector<BenchCase> cases = bench_cases(values, device->caps());
    log(LogLevel::Info, "{} runs on {}", cases.size(), escape_name(device->caps().name));
    const LogLevel level = log_level();
    if (level == LogLevel::Info) set_log_level(LogLevel::Warn);  // the jobs' own lines
    std::vector<BenchRow> rows = run_bench_cases(cases, values.texts("--set"), device, [&](const BenchRow& row) {
        if (level <= LogLevel::Info) log_line(LogLevel::Info, fmt::format("{}: {:.1f} ms", case_key(row.what), row.seconds() * 1e3));
    });
    set_log_level(level);
    if (values.given("--baseline")) add_baseline(rows, values.text("--baseline"));
    if (json != "-") print_result(bench_table(rows));
    write_json(json, bench_json(rows, device->caps()));
    return exit_code(platform::interrupt_requested());
}

}  // namespace parhelion::cli
