#pragma once
// `parhelion bench realtime`: what a frame of the realtime renderer costs, pass by pass, while the camera moves.
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "session/options.h"
#include "session/render_settings.h"

namespace parhelion {

struct RealtimeBenchOptions {
    std::vector<std::string> scenes;
    Size2 size{1920, 1080};
    gpu::TraceWay way = gpu::TraceWay::Compute;
    uint32_t warmup = 32, frames = 64;
    bool denoise = false;  // with the built-in reconstruction
    double upscale = 1;    // of the picture, whose size `size` is
    RenderSettings settings;
};

// Means over the measured frames.
struct RealtimeBenchRow {
    std::string scene;
    struct PassMs {
        std::string name, variant;
        double ms = 0;  // of all its launches
    };
    std::vector<PassMs> passes;  // of the frame, in its order; those of the film's upkeep left out
    double ms(std::string_view prefix) const;
    double frame_ms = 0;         // of whole frames, less the film's upkeep: passes run side by side, so it is less than their sum
    double lighting_ms() const { return frame_ms - ms("gbuffer/"); }
    double cache_ms = 0;         // what a frame takes longer than one that leaves the cells as they are
    double traced_ms() const;    // of the kernels that trace
    double trace_share() const { return frame_ms > 0 ? traced_ms() / frame_ms : 0; }
    // The rays of some of the frames, traced once more by a kernel that does nothing else: those of paths and to lights as the frame asked
    // for them. Pixels' own rays count what their kernel takes, where they are traced; the cache's what as many rays of paths and to lights take.
    double bare_ms = 0;
    double over_bare() const { return bare_ms > 0 ? frame_ms / bare_ms : 0; }
    double rays_per_pixel = 0;   // of the identity where it is traced, of the paths and of their light
    double cache_rays = 0;       // of the cache's update, a frame
    double live_cells = 0, updated_cells = 0;
    uint64_t cache_bytes = 0;
};

// From `bench realtime ...`: frames by --spp. Throws a usage Error for options that other suites have.
RealtimeBenchOptions read_realtime_bench_options(const OptionValues& values, const gpu::DeviceCaps& caps);
RealtimeBenchRow run_realtime_bench(const std::string& scene, const RealtimeBenchOptions& options, const gpu::DevicePtr& device);
std::string realtime_bench_table(const std::vector<RealtimeBenchRow>& rows, const RealtimeBenchOptions& options);
nlohmann::ordered_json realtime_bench_json(const std::vector<RealtimeBenchRow>& rows, const RealtimeBenchOptions& options, const gpu::DeviceCaps& caps);

}  // namespace parhelion
