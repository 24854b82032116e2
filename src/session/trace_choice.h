#pragma once
// Which way a job traces and why: asked for, what `parhelion devices --measure` found on this device and driver, or the table of
// device classes (gpu/device_class.h). The choice never depends on anything else: nothing is measured unless asked.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "gpu/device_class.h"
#include "session/render_options.h"

namespace parhelion {

struct TraceDecision {
    gpu::TraceWay way = gpu::TraceWay::Compute;
    gpu::NodeLayout layout = gpu::NodeLayout::Auto;
    std::string_view source;  // of the way: "option", "measured" or "table"
};

// `layout`: of trace.bvh; Auto becomes the measured one or the table's. Throws MissingFeature if the device lacks a way that was asked for.
TraceDecision decide_trace(const gpu::DeviceCaps& caps, TraceChoice choice, gpu::NodeLayout layout);

// ---- what was measured ----

struct MeasuredTrace {
    struct Rate {
        std::string tracer;  // pipeline, query, or a layout of our own structure
        double mrays_per_s;  // geometric mean over scenes and kinds of rays
    };
    std::vector<Rate> rates;
    gpu::TraceWay way() const;          // the fastest
    gpu::NodeLayout layout() const;     // the fastest of our own; Auto: none was measured
};

// In the cache folder, by device and driver version.
std::filesystem::path measured_trace_file(const gpu::DeviceCaps& caps);
// Nothing if there is no file; a broken one, or one of another device or driver, is warned of and left alone.
std::optional<MeasuredTrace> read_measured_trace(const gpu::DeviceCaps& caps);
// Throws Error where the file cannot be written.
void store_measured_trace(const gpu::DeviceCaps& caps, const MeasuredTrace& measured);

// Traces the rooms of 249,600 triangles by every way and node layout that the device has.
MeasuredTrace measure_tracing(const gpu::DevicePtr& device);

}  // namespace parhelion
