#include "session/bench_realtime.h"

#include <algorithm>
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "image/tonemap.h"
#include "scene/load.h"
#include "session/bench.h"
#include "session/metering.h"
#include "session/scene_setup.h"
#include "session/view_setup.h"

namespace parhelion {

namespace {

// The camera turns to and fro by some pixels a frame, so that every frame has other pixels and some are new.
CameraView turned(const CameraView& view, uint32_t frame) {
    constexpr double kTurn = 0.15, kPeriod = 96;
    const auto angle = static_cast<float>(kTurn * std::sin(2.0 * 3.14159265358979 * frame / kPeriod));
    CameraView out = view;
    const glm::mat3 turn(glm::rotate(glm::mat4(1.0f), angle, glm::vec3(0.0f, 1.0f, 0.0f)));
    out.right = turn * view.right;
    out.up = turn * view.up;
    out.forward = turn * view.forward;
    return out;
}

constexpr uint32_t kReplayEvery = 4, kWithoutUpdateEvery = 4;  // measured frames

bool is_of_the_film(std::string_view pass) { return pass.starts_with("transfer/") || pass.starts_with("reference/"); }

void add_passes(RealtimeBenchRow& row, const Frame& frame, double share) {
    for (const PassInfo& pass : frame.passes()) {
        if (is_of_the_film(pass.name)) {
            row.frame_ms -= pass.gpu_ms * share;
            continue;
        }
        const auto same = [&](const RealtimeBenchRow::PassMs& known) { return known.name == pass.name && known.variant == pass.variant; };
        auto found = std::ranges::find_if(row.passes, same);
        if (found == row.passes.end()) found = row.passes.insert(row.passes.end(), {.name = pass.name, .variant = pass.variant});
        found->ms += pass.gpu_ms * share;
    }
}

constexpr std::string_view kPixelTracing = "gbuffer/identity", kAntialias = "reconstruction/antialias";

// Milliseconds of tracing the rays of frames bare (RealtimeBenchRow::bare_ms).
class BareTracing {
public:
    BareTracing(gpu::DevicePtr device, Realtime& realtime) : device_(std::move(device)), realtime_(realtime) {}

    // Around the recording of a frame that is to be looked at.
    void begin() {
        realtime_.after_trace = [this](const passes::WavefrontPass& pass, passes::WavefrontTraced what) {
            const uint64_t most = passes::most_rays(pass.state.shape, passes::WavefrontTraced::ShadowRays);
            if (!dump_) dump_ = gpu::Buffer(device_, "replay/dump", most * sizeof(shared::DumpedRay)), hits_ = gpu::Buffer(device_, "replay/hits", most * sizeof(uint32_t));
            passes::dump_rays(pass, what, dump_);
            passes::replay_rays(pass, what, dump_, hits_);
        };
    }
    void end() { realtime_.after_trace = {}; }

    // Of that frame, which has run.
    void add(Frame& frame, const View& view) {
        double path = 0, shadow = 0, identity = 0;
        for (const PassInfo& pass : frame.passes()) {
            if (pass.name == "wavefront/replay_rays") (pass.variant.ends_with("+SHADOWS") ? shadow : path) += pass.gpu_ms;
            if (pass.name == kPixelTracing) identity += pass.gpu_ms;
        }
        const RayCounts rays = view.read_rays(frame);
        const auto scaled = [](double ms, uint64_t of, uint64_t to) { return of == 0 ? 0.0 : ms * double(to) / double(of); };
        sum_ += identity + path + shadow;
        if (realtime_.cache()) {
            const CacheStats cells = realtime_.cache()->read_stats(frame);
            sum_ += scaled(path, rays.path, cells.path_rays) + scaled(shadow, rays.shadow, cells.shadow_rays);
        }
        ++frames_;
    }
    // Of the paths' rays: those of reservoirs are not traced alone.
    double mean_ms() const { return frames_ == 0 ? 0 : sum_ / frames_; }

private:
    gpu::DevicePtr device_;
    Realtime& realtime_;
    gpu::Buffer dump_, hits_;
    double sum_ = 0;
    uint32_t frames_ = 0;
};

}  // namespace

double RealtimeBenchRow::traced_ms() const { return ms(kPixelTracing) + ms("wavefront/extend") + ms("realtime/connect") + ms("cache/extend") + ms("cache/connect"); }

double RealtimeBenchRow::ms(std::string_view prefix) const {
    double sum = 0;
    for (const PassMs& pass : passes)
        if (pass.name.starts_with(prefix)) sum += pass.ms;
    return sum;
}

RealtimeBenchOptions read_realtime_bench_options(const OptionValues& values, const gpu::DeviceCaps& caps) {
    if (values.given("--baseline")) throw Error(ErrorCode::Usage, "does not fit bench realtime", values.where("--baseline"), "leave it out");
    RealtimeBenchOptions options{.scenes = {"builtin:diorama", "builtin:many-lights"}};
    if (values.given("--scene")) options.scenes = values.texts("--scene");
    for (const std::string& scene : values.texts("--also")) options.scenes.push_back(scene);
    if (caps.type == gpu::DeviceType::Cpu) options.size = {320, 180};
    if (values.given("--size")) options.size = parse_size(values.text("--size"), "--size");
    if (values.given("--spp")) options.frames = static_cast<uint32_t>(parse_int(values.text("--spp"), "--spp", 1, 1 << 20));
    options.denoise = values.text("--denoise") == "builtin";
    options.upscale = parse_float(values.text("--upscale"), "--upscale", 1, kMostUpscale);
    if (options.upscale > 1 && !options.denoise) throw Error(ErrorCode::Usage, "builtin puts the picture's pixels together", values.where("--upscale"), "add --denoise builtin, or leave it out");
    const std::vector<gpu::TraceWay> ways = bench_ways(values, caps);
    options.way = std::ranges::find(ways, gpu::TraceWay::Compute) != ways.end() ? gpu::TraceWay::Compute : ways.front();
    for (const std::string& assignment : values.texts("--set")) apply_assignment(options.settings, assignment);
    if (caps.type == gpu::DeviceType::Cpu && may_draw_pixels(options.settings, caps))
        throw Error(ErrorCode::Usage, "the CPU device has no times of passes in a frame that draws", "gbuffer.mode=raster", "leave it out");
    return options;
}

RealtimeBenchRow run_realtime_bench(const std::string& scene, const RealtimeBenchOptions& options, const gpu::DevicePtr& device) {
    LoadedScene loaded = load_scene(scene, {});
    const RenderOptions as_if{.scene = scene, .renderer = RendererKind::Realtime, .size = options.size};
    add_light(loaded.scene, as_if, sky_options(options.settings));
    std::string description;
    const CameraView camera = choose_camera(loaded.scene, as_if, description);
    const float aspect = static_cast<float>(options.size.width) / static_cast<float>(options.size.height);
    // Markers and timers of passes keep passes apart: beside each frame whose passes are timed there is one that is timed as a whole.
    Frame frame(device, {.markers = false}), whole(device, {.timers = Timers::Frame, .markers = false});
    SceneGpu on_device(device, describe_scene_gpu(options.settings, {.way = options.way, .layout = options.settings.node_layout}, may_draw_pixels(options.settings, device->caps())));
    on_device.sync(loaded.scene);
    on_device.finish(frame);
    const ViewDesc desc = describe_view(as_if, options.settings, {.opens = camera});
    View view(device, desc);
    RealtimeOptions realtime_settings = realtime_options(options.settings, device->caps());
    realtime_settings.exposure = static_cast<float>(image::exposure_scale_from_ev100(meter_scene(device, frame, on_device, options.way, desc)));
    if (options.denoise) realtime_settings.reconstruction = options.settings.reconstruction, realtime_settings.upscale = options.upscale;
    Realtime realtime(device, view, realtime_settings);

    RealtimeBenchRow row{.scene = scene};
    BareTracing bare(device, realtime);
    uint32_t place = 0;  // of the camera
    const auto draw_in = [&](Frame& now) {
        view.set_camera(shader_camera(turned(camera, place++), aspect));
        on_device.sync(loaded.scene, loaded.scene.begin_frame());
        on_device.update(now);
        realtime.record(now, on_device, options.way, view, true);
        now.run();
        return now.gpu_ms();
    };
    const auto draw = [&] { draw_in(frame); };
    // A frame of its own, between those that are measured.
    const auto draw_replaying = [&](bool counts) {
        bare.begin();
        draw();
        bare.end();
        if (counts) bare.add(frame, view);
    };
    const gpu::Extent traced = realtime.gbuffer().identity.extent();
    const double share = 1.0 / options.frames, pixels = double(traced.width) * traced.height;
    for (uint32_t i = 0; i < options.warmup; ++i) draw();
    draw_replaying(false);  // compiles
    for (uint32_t i = 0; i < options.frames; ++i) {
        if (i % kReplayEvery == 0) draw_replaying(true);
        const double ms = draw_in(whole);
        row.frame_ms += ms * share;
        if (realtime.cache() && i % kWithoutUpdateEvery == 0) {
            realtime.updates_cells = false;
            row.cache_ms += (ms - draw_in(whole)) / double((options.frames + kWithoutUpdateEvery - 1) / kWithoutUpdateEvery);
            realtime.updates_cells = true;
        }
        draw();
        add_passes(row, frame, share);
        const RayCounts rays = view.read_rays(frame);
        row.rays_per_pixel += double(rays.path + rays.shadow) / pixels * share;
        if (!realtime.cache()) continue;
        const CacheStats cells = realtime.cache()->read_stats(frame);
        row.live_cells += cells.live * share;
        row.updated_cells += cells.updated * share;
        row.cache_rays += double(cells.path_rays + cells.shadow_rays) * share;
    }
    if (realtime.cache()) row.cache_bytes = realtime.cache()->bytes();
    if (row.ms(kPixelTracing) > 0) row.rays_per_pixel += 1;
    row.bare_ms = bare.mean_ms();
    return row;
}

std::string realtime_bench_table(const std::vector<RealtimeBenchRow>& rows, const RealtimeBenchOptions& options) {
    std::string out = fmt::format("{}x{}{}, {} frames after {}, camera turning; GPU milliseconds\n", options.size.width, options.size.height, options.upscale > 1 ? fmt::format(" of frames {} times smaller", options.upscale) : "", options.frames, options.warmup);
    out += fmt::format("{:<28} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>9} {:>7} {:>9} {:>9} {:>10} {:>9} {:>9}\n", "scene", "gbuffer", "tiles", "cache", "light", "reuse", "compose", "denoise", "antialias", "lighting", "traced", "to bare", "rays/px", "live cells", "updated", "its rays");
    for (const RealtimeBenchRow& row : rows)
        out += fmt::format("{:<28} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>5.1f} % {:>9.2f} {:>9.3f} {:>10.0f} {:>9.0f} {:>9.0f}\n", escape_name(row.scene), row.ms("gbuffer/"), row.ms("lights/"), row.cache_ms,
                           row.ms("realtime/") + row.ms("wavefront/") - row.ms("realtime/composite"), row.ms("reuse/"), row.ms("realtime/composite"), row.ms("reconstruction/") - row.ms(kAntialias), row.ms(kAntialias), row.lighting_ms(), row.trace_share() * 100, row.over_bare(), row.rays_per_pixel, row.live_cells, row.updated_cells, row.cache_rays);
    return out;
}

nlohmann::ordered_json realtime_bench_json(const std::vector<RealtimeBenchRow>& rows, const RealtimeBenchOptions& options, const gpu::DeviceCaps& caps) {
    nlohmann::ordered_json out{{"schema", 1}, {"device", caps.name}, {"driver", caps.driver}, {"trace", gpu::trace_way_name(options.way)},
                               {"size", {options.size.width, options.size.height}}, {"frames", options.frames}, {"denoise", options.denoise ? "builtin" : "none"}, {"upscale", options.upscale}, {"rows", nlohmann::ordered_json::array()}};
    for (const RealtimeBenchRow& row : rows) {
        nlohmann::ordered_json entry{{"scene", row.scene}, {"lighting_ms", row.lighting_ms()}, {"frame_ms", row.frame_ms}, {"trace_share", row.trace_share()}, {"bare_ms", row.bare_ms}, {"over_bare", row.over_bare()}, {"rays_per_pixel", row.rays_per_pixel}, {"live_cells", row.live_cells}, {"updated_cells", row.updated_cells}, {"cache_ms", row.cache_ms}, {"cache_alone_ms", row.ms("cache/")}, {"cache_rays", row.cache_rays}, {"cache_bytes", row.cache_bytes}};
        for (const RealtimeBenchRow::PassMs& pass : row.passes) entry["passes"].push_back({{"name", pass.name}, {"variant", pass.variant}, {"ms", pass.ms}});
        out["rows"].push_back(std::move(entry));
    }
    return out;
}

}  // namespace parhelion
