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

Json play_json(const PlayReport& report) {
    Json frames = Json::array();
    for (const PlayedFrame& frame : report.frames)
        frames.push_back({{"frame", frame.number}, {"written", frame.written}, {"time", frame.time}, {"ms", frame.ms}, {"gpu_ms", frame.gpu_ms}, {"rays", {{"path", frame.rays.path}, {"shadow", frame.rays.shadow}}}});
    return {{"fps", report.play.fps}, {"average", report.play.average}, {"warmup", report.play.warmup}, {"kept", report.kept}, {"drawn", frames}};
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
    const double drawn = play ? double(play->frames.size()) * double(frame_samples) : finished_end > resumed_at ? double(finished_end - resumed_at) : 0;
    const double samples = drawn * size.width * size.height;
    return render_seconds > 0 ? samples / render_seconds / 1e6 : 0;
}

Json report_json(const RenderReport& report) {
    Json passes = Json::array(), memory = Json::object(), files = Json::array();
    for (const PassTime& pass : report.passes)
        passes.push_back({{"name", pass.name}, {"ms", pass.ms}, {"count", pass.count}, {"rays", rays_of(pass, report)}});
    for (const gpu::MemoryUse& use : report.memory) memory[use.group] = use.bytes;
    for (const auto& file : report.written) files.push_back(file.string());
    const bool complete = report.finished_end == report.wanted.end;
    const uint64_t wanted = report.wanted.end - report.wanted.begin;
    Json length = {{"spp", report.sample_count()}, {"spp_wanted", wanted}, {"first_sample", report.wanted.begin}, {"resumed_at", report.resumed_at}};
    if (report.play) length = {{"frames", report.sample_count()}, {"frames_wanted", wanted}, {"first_frame", report.wanted.begin}, {"spp", report.frame_samples}, {"play", play_json(*report.play)}};
    Json out = {{"renderer", report.renderer},
            {"device", report.device},
            {"driver", report.driver},
            {"trace", report.trace},
            {"trace_source", report.trace_source},
            {"shade_in", report.shade_in_hit ? "closest_hit" : "raygen"},
            {"scene", report.scene},
            {"camera", report.camera},
            {"triangles", report.triangles},
            {"traced_triangles", report.traced_triangles},
            {"instances", report.instances},
            {"lights", report.lights},
            {"size", {report.size.width, report.size.height}},
            {"upscale", report.upscale},
            {"max_bounces", report.max_bounces}};
    out.update(length);
    out.update({{"complete", complete},
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
            {"denoise", report.denoiser.empty() ? Json() : Json{{"by", report.denoiser}, {"seconds", report.denoise_seconds}}},
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
            {"outputs", files}});
    return out;
}

}  // namespace parhelion
