#pragma once
// `parhelion bench`: scenes x renderers x ways to trace (and places to shade) on one device, as a table and as JSON.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "session/job.h"
#include "session/options.h"

namespace parhelion {

struct BenchCase {
    std::string scene;
    gpu::TraceWay way;
    Size2 size;
    uint64_t spp;
    bool replay = false;   // also measure the trace share
    bool in_hit = false;   // reference.shade_in=closest_hit
    uint32_t max_bounces = 16;
    bool repeats = false;  // drawn twice, some time apart; the faster counts
    std::optional<WavefrontOptions> wavefront = {};  // drawn by it; else by the reference
};

struct BenchRow {
    BenchCase what;
    RenderReport report;
    std::optional<double> baseline_seconds;  // of the same case in the baseline
    std::optional<TraceShare> replay;        // of the suite `replay`
    std::optional<WavefrontTraceShares> wavefront_replay;  // of the suite `wavefront`
    double seconds() const { return report.render_seconds; }
    // On the GPU where it has timers.
    double drawing_seconds() const { return report.gpu_seconds > 0 ? report.gpu_seconds : report.render_seconds; }
    double mega_paths_per_second() const;  // over that time
};

// The ways of --trace, else all that the device has. Throws MissingFeature for one that it lacks.
std::vector<gpu::TraceWay> bench_ways(const OptionValues& values, const gpu::DeviceCaps& caps);

// The cases of a suite on a device, or of the options' scenes, ways, size and spp; the suites `reference` and `wavefront` also shade in both places. Throws a usage Error for an unknown suite, and
// MissingFeature for a way that the device lacks.
std::vector<BenchCase> bench_cases(const OptionValues& values, const gpu::DeviceCaps& caps);

// Each case runs once to warm up (shaders, caches) and once to be measured. `done` is called after each.
std::vector<BenchRow> run_bench_cases(const std::vector<BenchCase>& cases, const std::vector<std::string>& assignments,
                                      const gpu::DevicePtr& device, const std::function<void(const BenchRow&)>& done);

nlohmann::ordered_json bench_json(const std::vector<BenchRow>& rows, const gpu::DeviceCaps& caps);
std::string variant_name(const BenchRow& row);  // where the reference shades, how the wavefront is built
std::string bench_table(const std::vector<BenchRow>& rows);

// Seconds by case_key from the JSON of an earlier run. Throws Error naming the file if it is no such thing.
std::string case_key(const BenchCase& what);
void add_baseline(std::vector<BenchRow>& rows, const std::filesystem::path& file);

}  // namespace parhelion
