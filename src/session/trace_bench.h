#pragma once
// `parhelion bench trace`: how many rays a second each way to trace manages when a pass does nothing else.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "renderers/ray_rates.h"
#include "scene/scene.h"
#include "session/options.h"
#include "session/render_options.h"
#include "session/render_settings.h"

namespace parhelion {

struct TraceBenchOptions {
    std::vector<std::string> scenes;  // trace_bench_scenes(), files, built-in scenes
    std::optional<Size2> size;        // rays of each kind; none: 1920x1080, on a CPU device 480x270
    std::vector<gpu::TraceWay> ways;
    bool each_layout = false;  // our own acceleration structure in each of its node layouts, not only in that of the settings
    RenderSettings settings;
};

// A tracer outside this program, such as Embree: `build` takes the scene and returns nothing if it cannot show it.
struct OutsideTracer {
    std::string name;
    std::function<TraceOutside(const Scene&)> build;
};

struct TraceBenchScene {
    std::string name;
    uint64_t triangles = 0, instances = 0;
    std::vector<RayRates> kinds;  // empty names in RayRates::tracers are the outside tracer's
};

struct TraceBenchReport {
    std::string device, driver;
    Size2 size{};
    bool cpu = false;  // rates are per core-second
    std::vector<TraceBenchScene> scenes;
    std::string outside;  // name; empty: none
};

// room-s, room-s-instanced, ...: what the suite measures unless --scene names others.
std::vector<std::string> trace_bench_scenes();

// From `bench trace ...`. Throws a usage Error for options that other suites have, and MissingFeature for a way that the device lacks.
TraceBenchOptions read_trace_bench_options(const OptionValues& values, const gpu::DeviceCaps& caps);

// `done` is called after each scene. Ends early when interrupted.
TraceBenchReport run_trace_bench(const TraceBenchOptions& options, const gpu::DevicePtr& device, const std::optional<OutsideTracer>& outside,
                                 const std::function<void(const TraceBenchScene&)>& done);

std::string trace_bench_table(const TraceBenchReport& report);
nlohmann::ordered_json trace_bench_json(const TraceBenchReport& report);

// At least this share of the rays must be answered alike by all ways, and by the outside tracer. Two rays are always forgiven. Embree's
// answers and ours were held against long double on 691,200 rays of an instanced room: 29 distances differed, all to the same triangle,
// which the ray meets at less than 1.4 degrees, so that a rounding of the position counts 40 to 500 times (ours lay nearer in 23 of them;
// both within 6e-7 across the triangle); one ray passes a silhouette's edge by less than a rounding and met it for us, not for Embree.
constexpr double kTraceAgreement = 0.99999, kOutsideAgreement = 0.9995;
// Throws Error naming scene, rays and tracer where that does not hold.
void check_agreement(const TraceBenchReport& report);

// The command, from opening the device to printing. Returns the exit code.
int run_trace_bench_command(const OptionValues& values, const std::optional<OutsideTracer>& outside);

}  // namespace parhelion
