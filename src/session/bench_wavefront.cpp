#include "session/bench_wavefront.h"

#include "base/error.h"

namespace parhelion {

std::vector<BenchCase> wavefront_bench_cases(const BenchCase& base, std::span<const gpu::TraceWay> ways, gpu::TraceWay full_way, bool timers) {
    std::vector<BenchCase> cases;
    for (const gpu::TraceWay way : ways) {
        BenchCase what = base;
        what.way = way;
        cases.push_back(what);
        what.in_hit = way == gpu::TraceWay::Pipeline;
        if (what.in_hit) cases.push_back(what);
    }
    for (const gpu::TraceWay way : ways)
        for (const ConnectWhen connect : {ConnectWhen::EachBounce, ConnectWhen::Once})
            for (const WavefrontDispatch dispatch : {WavefrontDispatch::Indirect, WavefrontDispatch::Full})
                for (const bool classes : {true, false}) {
                    const WavefrontOptions standard;
                    const bool usual = connect == standard.connect && dispatch == standard.dispatch && classes == standard.classes;
                    if (way != full_way && !usual) continue;
                    BenchCase what = base;
                    what.way = way;
                    what.wavefront = WavefrontOptions{.connect = connect, .dispatch = dispatch, .classes = classes};
                    what.replay = timers;
                    cases.push_back(what);
                }
    return cases;
}

std::string wavefront_variant(const WavefrontOptions& options) {
    return fmt::format("{} {} {}", connect_name(options.connect), dispatch_name(options.dispatch), options.classes ? "classes" : "one_kernel");
}

std::vector<std::string> wavefront_assignments(const WavefrontOptions& options) {
    return {fmt::format("wavefront.connect={}", connect_name(options.connect)), fmt::format("wavefront.dispatch={}", dispatch_name(options.dispatch)),
            fmt::format("wavefront.classes={}", options.classes ? "on" : "off")};
}

std::optional<double> to_best_reference(const BenchRow& row, const std::vector<BenchRow>& rows) {
    std::optional<double> best;
    for (const BenchRow& other : rows)
        if (!other.what.wavefront && other.what.scene == row.what.scene && other.what.size == row.what.size && other.what.spp == row.what.spp)
            best = std::min(best.value_or(other.drawing_seconds()), other.drawing_seconds());
    if (!best || row.drawing_seconds() <= 0) return std::nullopt;
    return *best / row.drawing_seconds();
}

std::string wavefront_bench_table(const std::vector<BenchRow>& rows) {
    const auto percent = [](const std::optional<double>& share) { return share ? fmt::format("{:.1f} %", *share * 100) : std::string("-"); };
    std::string out = fmt::format("{:<28} {:<9} {:<9} {:<34} {:>11} {:>5} {:>10} {:>10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "scene", "renderer", "trace", "variant", "size",
                                  "spp", "ms", "GPU ms", "Mpaths/s", "Mrays/s", "to best", "occupancy", "extend", "connect");
    for (const BenchRow& row : rows) {
        const std::optional<double> ratio = to_best_reference(row, rows);
        std::optional<double> occupancy, extend, connect;
        if (row.report.wavefront) occupancy = row.report.wavefront->occupancy();
        if (row.wavefront_replay) extend = row.wavefront_replay->extend.share();
        if (row.wavefront_replay && row.wavefront_replay->connect.rays != 0) connect = row.wavefront_replay->connect.share();
        out += fmt::format("{:<28} {:<9} {:<9} {:<34} {:>11} {:>5} {:>10.1f} {:>10.1f} {:>9.3f} {:>9.3f} {:>9} {:>9} {:>9} {:>9}\n", escape_name(row.what.scene),
                           row.report.renderer, trace_way_name(row.what.way), variant_name(row), fmt::format("{}x{}", row.what.size.width, row.what.size.height),
                           row.what.spp, row.seconds() * 1e3, row.report.gpu_seconds * 1e3, row.mega_paths_per_second(), row.report.mega_rays_per_second(),
                           ratio ? fmt::format("x{:.3f}", *ratio) : "-", percent(occupancy), percent(extend), percent(connect));
    }
    return out + "\nextend, connect: shares of these kernels' time that tracing their rays alone takes. to best: speed beside the reference's best row of the scene, by GPU ms.\n";
}

}  // namespace parhelion
