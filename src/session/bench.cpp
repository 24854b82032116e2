#include "session/bench.h"

#include <algorithm>
#include <iterator>
#include <map>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "session/bench_wavefront.h"
#include "session/scene_setup.h"
#include "session/trace_choice.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

struct Suite {
    std::string_view name;
    std::vector<std::string> scenes;
    Size2 size;
    uint64_t spp;
    uint32_t max_bounces = 16;
    std::optional<Size2> cpu_size = {};  // on CPU devices
};

const std::vector<Suite>& suites() {
    static const std::vector<Suite> all = {
        {"quick", {"builtin:cornell", "builtin:spheres"}, {320, 180}, 16},
        {"replay", {"builtin:cornell", "builtin:spheres", "builtin:textured"}, {640, 360}, 4},
        {"full", {"builtin:cornell", "builtin:diffuse-box", "builtin:spheres", "builtin:textured"}, {1280, 720}, 64},
        {"reference", {"builtin:cornell", "builtin:diorama", "builtin:many-lights"}, {1920, 1080}, 64},
        {"wavefront", {"builtin:cornell", "builtin:diorama", "builtin:spheres", "builtin:many-lights"}, {1920, 1080}, 16, 8, Size2{320, 180}},
    };
    return all;
}

const Suite& find_suite(const OptionValues& values) {
    const std::string name = values.positionals.empty() ? "quick" : values.positionals.front();
    std::string names;
    for (const Suite& suite : suites()) {
        if (suite.name == name) return suite;
        names += std::string(suite.name) + " or ";
    }
    throw Error(ErrorCode::Usage, fmt::format("there is no suite '{}'", escape_name(name)), "bench", "use " + names + "trace");
}

RenderOptions job_options(const BenchCase& what, const std::vector<std::string>& assignments) {
    RenderOptions options;
    options.scene = what.scene;
    options.size = what.size;
    options.samples = {0, what.spp};
    options.max_bounces = what.max_bounces;
    options.exposure_ev = 0;
    options.trace = what.way == gpu::TraceWay::Pipeline ? TraceChoice::Pipeline
                    : what.way == gpu::TraceWay::Query  ? TraceChoice::Query
                                                        : TraceChoice::Compute;
    options.assignments = assignments;
    if (what.in_hit) options.assignments.emplace_back("reference.shade_in=closest_hit");
    if (!what.wavefront) return options;
    options.renderer = RendererKind::Wavefront;
    for (std::string& assignment : wavefront_assignments(*what.wavefront)) options.assignments.push_back(std::move(assignment));
    return options;
}

}  // namespace

std::vector<gpu::TraceWay> bench_ways(const OptionValues& values, const gpu::DeviceCaps& caps) {
    std::vector<gpu::TraceWay> ways;
    for (const std::string& name : values.texts("--trace"))
        ways.push_back(choose_trace_way(caps, name == "pipeline" ? TraceChoice::Pipeline
                                              : name == "query"  ? TraceChoice::Query
                                                                 : TraceChoice::Compute));
    if (!ways.empty()) return ways;
    for (const gpu::TraceWay way : {gpu::TraceWay::Pipeline, gpu::TraceWay::Query, gpu::TraceWay::Compute})
        if (caps.supports(way)) ways.push_back(way);
    return ways;
}

std::vector<BenchCase> bench_cases(const OptionValues& values, const gpu::DeviceCaps& caps) {
    const Suite& suite = find_suite(values);
    std::vector<std::string> scenes = values.given("--scene") ? values.texts("--scene") : suite.scenes;
    for (const std::string& scene : values.texts("--also")) scenes.push_back(scene);
    const Size2 size = values.given("--size") ? parse_size(values.text("--size"), "--size")
                       : caps.type == gpu::DeviceType::Cpu && suite.cpu_size ? *suite.cpu_size
                                                                             : suite.size;
    const uint64_t spp = values.given("--spp") ? static_cast<uint64_t>(parse_int(values.text("--spp"), "--spp")) : suite.spp;
    const std::vector<gpu::TraceWay> ways = bench_ways(values, caps);
    std::vector<BenchCase> cases;
    for (const std::string& scene : scenes) {
        const BenchCase base{.scene = scene, .way = ways.front(), .size = size, .spp = spp, .max_bounces = suite.max_bounces, .repeats = suite.name == "wavefront"};
        if (suite.name == "wavefront") {
            const gpu::TraceWay best = decide_trace(caps, TraceChoice::Auto, NodeLayout::Auto).way;
            const gpu::TraceWay full = std::ranges::find(ways, best) != ways.end() ? best : ways.front();
            std::ranges::move(wavefront_bench_cases(base, ways, full, caps.timestamp_period_ns > 0), std::back_inserter(cases));
            continue;
        }
        for (const gpu::TraceWay way : ways) {
            BenchCase what = base;
            what.way = way;
            what.replay = suite.name == "replay";
            cases.push_back(what);
            what.in_hit = suite.name == "reference" && way == gpu::TraceWay::Pipeline;
            if (what.in_hit) cases.push_back(what);
        }
    }
    return cases;
}

std::vector<BenchRow> run_bench_cases(const std::vector<BenchCase>& cases, const std::vector<std::string>& assignments,
                                      const gpu::DevicePtr& device, const std::function<void(const BenchRow&)>& done) {
    std::vector<BenchRow> rows;
    for (const BenchCase& what : cases) {
        RenderOptions options = job_options(what, assignments);
        options.samples.end = 1;
        run_render_job(options, device);
        options.samples.end = what.spp;
        BenchRow row{what, run_render_job(options, device), std::nullopt, std::nullopt, std::nullopt};
        if (row.report.interrupt != platform::Interrupt::None) break;
        if (what.replay && what.wavefront) row.wavefront_replay = measure_job_wavefront_trace_shares(options, device);
        else if (what.replay) row.replay = measure_job_trace_share(options, device);
        done(row);
        rows.push_back(std::move(row));
    }
    // Once more those that are set beside each other: a device that was slow for some seconds was so for some of them only.
    for (BenchRow& row : rows) {
        if (!row.what.repeats) continue;
        RenderOptions options = job_options(row.what, assignments);
        options.samples.end = row.what.spp;
        BenchRow again = row;
        again.report = run_render_job(options, device);
        if (again.report.interrupt != platform::Interrupt::None) break;
        if (again.drawing_seconds() < row.drawing_seconds()) row = std::move(again);
    }
    return rows;
}

std::string case_key(const BenchCase& what) {
    const std::string variant = what.wavefront ? " " + wavefront_variant(*what.wavefront) : what.in_hit ? " closest_hit" : "";
    return fmt::format("{} {} {}{} {}x{} {}", what.scene, what.wavefront ? "wavefront" : "reference", trace_way_name(what.way), variant, what.size.width, what.size.height, what.spp);
}

double BenchRow::mega_paths_per_second() const {
    const double paths = double(what.size.width) * what.size.height * double(report.sample_count());
    return drawing_seconds() > 0 ? paths / drawing_seconds() / 1e6 : 0;
}

namespace {

Json share_json(const TraceShare& share) { return {{"pass_ms", share.pass_ms}, {"replay_ms", share.replay_ms}, {"rays", share.rays}, {"trace_share", share.share()}}; }

}  // namespace

Json bench_json(const std::vector<BenchRow>& rows, const gpu::DeviceCaps& caps) {
    Json list = Json::array();
    for (const BenchRow& row : rows) {
        Json entry = report_json(row.report);
        entry["case"] = case_key(row.what);
        if (row.baseline_seconds) entry["baseline_seconds"] = *row.baseline_seconds;
        if (row.replay) entry["replay"] = share_json(*row.replay);
        if (row.wavefront_replay) entry["replay"] = {{"extend", share_json(row.wavefront_replay->extend)}, {"connect", share_json(row.wavefront_replay->connect)}};
        entry["mpaths_per_s"] = row.mega_paths_per_second();
        if (const std::optional<double> ratio = to_best_reference(row, rows)) entry["to_best_reference"] = *ratio;
        list.push_back(std::move(entry));
    }
    return {{"device", caps.name}, {"driver", caps.driver}, {"runs", list}};
}

std::string variant_name(const BenchRow& row) {
    if (row.what.wavefront) return wavefront_variant(*row.what.wavefront);
    if (row.report.trace != trace_way_name(gpu::TraceWay::Pipeline)) return "compute";
    return row.report.shade_in_hit ? "closest hit" : "raygen";
}

std::string bench_table(const std::vector<BenchRow>& rows) {
    if (std::ranges::any_of(rows, [](const BenchRow& row) { return row.what.wavefront.has_value(); })) return wavefront_bench_table(rows);
    std::string out = fmt::format("{:<28} {:<9} {:<11} {:>11} {:>6} {:>10} {:>12} {:>10} {:>12}  {}\n", "scene", "trace", "shade in", "size", "spp", "ms",
                                  "Msamples/s", "Mrays/s", "trace share", "to baseline");
    for (const BenchRow& row : rows) {
        const std::string size = fmt::format("{}x{}", row.what.size.width, row.what.size.height);
        const std::string ratio = row.baseline_seconds ? fmt::format("x{:.3f}", row.seconds() / *row.baseline_seconds) : "-";
        const std::string share = row.replay ? fmt::format("{:.1f} %", row.replay->share() * 100) : "-";
        out += fmt::format("{:<28} {:<9} {:<11} {:>11} {:>6} {:>10.1f} {:>12.3f} {:>10.3f} {:>12}  {}\n", escape_name(row.what.scene),
                           trace_way_name(row.what.way), variant_name(row), size, row.what.spp, row.seconds() * 1e3, row.report.mega_samples_per_second(),
                           row.report.mega_rays_per_second(), share, ratio);
    }
    return out;
}

void add_baseline(std::vector<BenchRow>& rows, const std::filesystem::path& file) {
    constexpr uint64_t kMaxBytes = 64 << 20;
    const Json root = Json::parse(read_text_file(file, kMaxBytes), nullptr, false);
    std::map<std::string, double> seconds;
    try {
        for (const Json& run : root.at("runs")) seconds[run.at("case").get<std::string>()] = run.at("seconds").get<double>();
    } catch (const nlohmann::json::exception&) {
        throw Error(ErrorCode::Failed, "is not the JSON of parhelion bench", escape_name(file.string()),
                    "write one with parhelion bench --json F");
    }
    for (BenchRow& row : rows)
        if (const auto found = seconds.find(case_key(row.what)); found != seconds.end()) row.baseline_seconds = found->second;
}

}  // namespace parhelion
