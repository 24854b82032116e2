#pragma once
// One render job: scene, device, slices, progress, interruption, checkpoints, outputs. The command line, tests, the bench and
// embedding programs use this.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "base/platform.h"
#include "gpu/device.h"
#include "renderers/replay.h"
#include "session/render_options.h"
#include "session/wavefront_report.h"

namespace parhelion {

struct PassTime {
    std::string name;  // with the way to trace: "reference/path_trace [compute]"
    double ms = 0;     // on the GPU, all slices together
    uint64_t count = 0;
};

// What a job that plays frames has done.
struct PlayedFrame {
    uint64_t number = 0;
    bool written = false;        // to files of its own
    double time = 0;             // seconds on the scene's clock
    double ms = 0, gpu_ms = 0;   // from the scene's edit to the finished frame; of it the GPU's
    RayCounts rays;
};
struct PlayReport {
    FramePlay play;
    std::vector<PlayedFrame> frames;  // that were drawn, warm-up and frames before the first that is written too
    std::vector<uint64_t> kept;       // --resume: numbers of frames that were there already
};

struct RenderReport {
    std::string renderer = "reference", device, driver, trace, scene, camera;
    std::string trace_source;  // who chose the way: option, measured, table
    bool shade_in_hit = false;  // reference.shade_in=closest_hit
    uint64_t triangles = 0, traced_triangles = 0, instances = 0, lights = 0;
    Size2 size;
    double upscale = 1;         // RenderOptions::upscale
    IndexRange wanted;          // samples that were asked for
    uint64_t finished_end = 0;  // samples [wanted.begin, finished_end) are in every pixel of the outputs
    uint64_t resumed_at = 0;    // first sample of this run
    uint64_t frame_samples = 1; // of each frame that was played
    double load_seconds = 0, setup_seconds = 0, render_seconds = 0;
    double gpu_seconds = 0;  // of render_seconds, what the GPU took for the frames, between their passes too; 0: the device has no timers
    std::string denoiser;        // name and version of a library that took noise out of the pictures; empty: none did
    double denoise_seconds = 0;  // of all pictures
    double exposure_ev = 0;
    bool exposure_metered = false;
    uint32_t max_bounces = 0;
    uint64_t settings_hash = 0;
    std::vector<PassTime> passes;
    RayCounts rays;  // of this run, metering apart
    std::optional<WavefrontReport> wavefront;  // where it drew
    std::optional<PlayReport> play;            // `wanted` and `finished_end` are then frames
    std::vector<gpu::MemoryUse> memory;
    uint64_t peak_host_bytes = 0, peak_device_bytes = 0;
    std::string node_layout;  // of our own acceleration structure; empty: not made
    uint64_t own_bottom_bytes = 0, own_top_bytes = 0;  // with its triangles and instances
    uint64_t bottom_bytes_built = 0, bottom_bytes = 0;  // the driver's bottom levels before and after compaction
    platform::Interrupt interrupt = platform::Interrupt::None;
    bool out_of_time = false;
    std::vector<std::filesystem::path> written;
    std::string listing;  // --list-frame

    uint64_t sample_count() const { return finished_end > wanted.begin ? finished_end - wanted.begin : 0; }
    double trace_seconds() const;            // GPU time of the path tracer: path_trace, or all kernels of the wavefront
    double mega_rays_per_second() const;     // all rays over that time
    double mega_samples_per_second() const;  // pixel-samples of this run over its render time
};
nlohmann::ordered_json report_json(const RenderReport& report);

// Runs the job and writes its outputs (not the JSON). Opens the device that the options name unless one is given.
// Interrupted: writes what is finished and returns with report.interrupt set. Throws Error for everything else that goes wrong;
// then no output exists, except a checkpoint, which stays.
RenderReport run_render_job(const RenderOptions& options, gpu::DevicePtr device = nullptr);

// `bench replay`: sets the job up and measures which share of its tracing pass the rays alone take. Writes nothing.
TraceShare measure_job_trace_share(const RenderOptions& options, gpu::DevicePtr device);
// `bench wavefront`: the same of its tracing kernels, over as many of the job's samples as a slice of it has.
WavefrontTraceShares measure_job_wavefront_trace_shares(const RenderOptions& options, gpu::DevicePtr device);

}  // namespace parhelion
