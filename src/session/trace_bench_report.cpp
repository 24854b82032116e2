// What `parhelion bench trace` prints.
#include <algorithm>

#include <nlohmann/json.hpp>

#include "session/trace_bench.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

std::string column_name(const TraceBenchReport& report, const TracerRate& tracer) { return tracer.name.empty() ? report.outside : tracer.name; }

// Every tracer of the report, in order of first use: a scene that the outside tracer cannot show lacks it.
std::vector<std::string> columns(const TraceBenchReport& report) {
    std::vector<std::string> names;
    for (const TraceBenchScene& scene : report.scenes)
        for (const RayRates& kind : scene.kinds)
            for (const TracerRate& tracer : kind.tracers)
                if (const std::string name = column_name(report, tracer); std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    return names;
}

const TracerRate* find(const TraceBenchReport& report, const RayRates& kind, const std::string& name) {
    for (const TracerRate& tracer : kind.tracers)
        if (column_name(report, tracer) == name) return &tracer;
    return nullptr;
}

bool is_driver(const std::string& name) { return name == trace_way_name(gpu::TraceWay::Pipeline) || name == trace_way_name(gpu::TraceWay::Query); }

// Our own over theirs: "compute/query".
struct Ratio {
    std::string ours, theirs;
};
std::vector<Ratio> ratios(const TraceBenchReport& report, const std::vector<std::string>& names) {
    std::vector<Ratio> out;
    for (const std::string& ours : names)
        for (const std::string& theirs : names)
            if (!is_driver(ours) && ours != report.outside && (is_driver(theirs) || theirs == report.outside)) out.push_back({ours, theirs});
    return out;
}

std::string rate_text(const TracerRate* tracer) { return tracer ? fmt::format("{:.3f}", tracer->mrays_per_s) : "-"; }

std::string ratio_text(const TracerRate* ours, const TracerRate* theirs) {
    return ours && theirs && theirs->mrays_per_s > 0 ? fmt::format("{:.2f}", ours->mrays_per_s / theirs->mrays_per_s) : "-";
}

}  // namespace

std::string trace_bench_table(const TraceBenchReport& report) {
    const std::vector<std::string> names = columns(report);
    const std::vector<Ratio> quotients = ratios(report, names);
    std::string out = fmt::format("{}, {}x{} rays of each kind, millions of rays a {}\n{:<20} {:<8}", escape_name(report.device), report.size.width, report.size.height,
                                  report.cpu ? "core-second" : "second", "scene", "rays");
    for (const std::string& name : names) out += fmt::format(" {:>9}", name);
    for (const Ratio& ratio : quotients) out += fmt::format(" {:>17}", ratio.ours + "/" + ratio.theirs);
    out += "    differ\n";
    for (const TraceBenchScene& scene : report.scenes)
        for (const RayRates& kind : scene.kinds) {
            out += fmt::format("{:<20} {:<8}", escape_name(scene.name), ray_kind_name(kind.kind));
            double worst = 1;
            for (const TracerRate& tracer : kind.tracers) worst = std::min(worst, tracer.agreement);
            for (const std::string& name : names) out += fmt::format(" {:>9}", rate_text(find(report, kind, name)));
            for (const Ratio& ratio : quotients) out += fmt::format(" {:>17}", ratio_text(find(report, kind, ratio.ours), find(report, kind, ratio.theirs)));
            out += fmt::format(" {:>7.4f} %\n", (1 - worst) * 100);
        }
    if (report.outside.empty()) out += "Embree is not measured: parhelion-bench-embree does it (built with -DPARHELION_EMBREE=ON, needs libembree-dev).\n";
    return out;
}

Json trace_bench_json(const TraceBenchReport& report) {
    Json rows = Json::array();
    for (const TraceBenchScene& scene : report.scenes)
        for (const RayRates& kind : scene.kinds) {
            Json tracers = Json::object();
            for (const TracerRate& tracer : kind.tracers)
                tracers[column_name(report, tracer)] = {{"mrays_per_s", tracer.mrays_per_s}, {"agreement", tracer.agreement}};
            rows.push_back({{"scene", scene.name},
                            {"triangles", scene.triangles},
                            {"instances", scene.instances},
                            {"kind", ray_kind_name(kind.kind)},
                            {"rays", kind.rays},
                            {"hits", kind.hits},
                            {"tracers", tracers}});
        }
    return {{"device", report.device}, {"driver", report.driver}, {"size", {report.size.width, report.size.height}}, {"per", report.cpu ? "core-second" : "second"}, {"rates", rows}};
}

}  // namespace parhelion
