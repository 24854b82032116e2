// The numbers of a job as JSON.
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "session/job.h"

namespace parhelion {

using Json = nlohmann::ordered_json;

namespace {

bool draws_paths(const PassTime& pass) { return pass.name.starts_with("reference/path_trace") || pass.name.starts_with("wavefront/"); }

uint64_t rays_of(const PassTime& pass, const RenderReport& report) {
    if (pass.name.starts_with("reference/first_hit")) return uint64_t(report.size.width) * report.size.height;
    if (pass.name.starts_with("reference/path_trace")) return report.rays.path + report.rays.shadow;
    if (pass.name.starts_with("wavefront/extend")) return report.rays.path;
    return pass.name.starts_with("wavefront/connect [") ? report.rays.shadow : 0;
}

}  // namespace

double RenderReport::trace_seconds() const {
    double ms = 0;
    for (const PassTime& pass : passes)
        if (draws_paths(pass)) ms += pass.ms;
    return ms / 1000;
}

double RenderReport::mega_rays_per_second() const {
    const double seconds = trace_seconds();
    return seconds > 0 ? double(rays.path + rays.shadow) / seconds / 1e6 : 0;
}

double RenderReport::mega_samples_per_second() const {
    const double samples = finished_end > resumed_at ? double(finished_end - resumed_at) * size.width * size.height : 0;
    return render_seconds > 0 ? samples / render_seconds / 1e6 : 0;
}

Json report_json(const RenderReport& report) {
    Json passes = Json::array(), memory = Json::object(), files = Json::array();
    for (const PassTime& pass : report.passes)
        passes.push_back({{"name", pass.name}, {"ms", pass.ms}, {"count", pass.count}, {"rays", rays_of(pass, report)}});
    for (const gpu::MemoryUse& use : report.memory) memory[use.group] = use.bytes;
    for (const auto& file : report.written) files.push_back(file.string());
    const bool complete = report.finished_end == report.wanted.end;
    return {{"renderer", report.renderer},
            {"device", report.device},
            {"driver", report.driver},
            {"trace", report.trace},
            {"trace_source", report.trace_source},
            {"shade_in", report.shade_in_hit ? "closest_hit" : "raygen"},
            {"scene", report.scene},
            {"camera", report.camera},
            {"triangles", report.triangles},
            {"instances", report.instances},
            {"lights", report.lights},
            {"size", {report.size.width, report.size.height}},
            {"max_bounces", report.max_bounces},
            {"spp", report.sample_count()},
            {"spp_wanted", report.wanted.end - report.wanted.begin},
            {"first_sample", report.wanted.begin},
            {"resumed_at", report.resumed_at},
            {"complete", complete},
            {"interrupted", report.interrupt != platform::Interrupt::None},
            {"out_of_time", report.out_of_time},
            {"exposure_ev100", report.exposure_ev},
            {"exposure_metered", report.exposure_metered},
            {"settings_hash", fmt::format("{:016x}", report.settings_hash)},
            {"load_seconds", report.load_seconds},
            {"setup_seconds", report.setup_seconds},
            {"seconds", report.render_seconds},
            {"gpu_seconds", report.gpu_seconds},
            {"trace_seconds", report.trace_seconds()},
            {"rays", {{"path", report.rays.path}, {"shadow", report.rays.shadow}}},
            {"mrays_per_s", report.mega_rays_per_second()},
            {"mega_samples_per_s", report.mega_samples_per_second()},
            {"passes", passes},
            {"wavefront", report.wavefront ? wavefront_json(*report.wavefront) : Json()},
            {"memory", memory},
            {"own_bvh", {{"nodes", report.node_layout}, {"bottom_bytes", report.own_bottom_bytes}, {"top_bytes", report.own_top_bytes}}},
            {"bottom_levels", {{"bytes_built", report.bottom_bytes_built}, {"bytes", report.bottom_bytes}}},
            {"peak_host_bytes", report.peak_host_bytes},
            {"peak_device_bytes", report.peak_device_bytes},
            {"outputs", files}};
}

}  // namespace parhelion
