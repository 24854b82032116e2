// parhelion devices: what each Vulkan device can do.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "base/error.h"
#include "base/log.h"
#include "gpu/device.h"
#include "session/bench.h"
#include "session/results.h"

namespace parhelion::cli {

namespace {

using Json = nlohmann::ordered_json;

constexpr gpu::TraceWay kWays[] = {gpu::TraceWay::Pipeline, gpu::TraceWay::Query, gpu::TraceWay::Compute};

std::string_view type_name(gpu::DeviceType type) {
    switch (type) {
        case gpu::DeviceType::Discrete:
            return "discrete GPU";
        case gpu::DeviceType::Integrated:
            return "integrated GPU";
        case gpu::DeviceType::Virtual:
            return "virtual GPU";
        case gpu::DeviceType::Cpu:
            return "CPU";
        case gpu::DeviceType::Other:
            break;
    }
    return "other";
}

std::string vulkan_version(uint32_t packed) { return fmt::format("{}.{}.{}", packed >> 22 & 0x7F, packed >> 12 & 0x3FF, packed & 0xFFF); }

Json device_json(const gpu::DeviceCaps& caps, bool best) {
    Json ways = Json::array();
    for (const gpu::TraceWay way : kWays)
        if (caps.supports(way)) ways.push_back(trace_way_name(way));
    return {{"index", caps.index},
            {"name", caps.name},
            {"driver", caps.driver},
            {"type", type_name(caps.type)},
            {"vulkan", vulkan_version(caps.api_version)},
            {"memory_bytes", caps.memory_bytes},
            {"best", best},
            {"usable", caps.usable()},
            {"missing", caps.missing},
            {"trace", ways},
            {"shader_float64", caps.shader_float64},
            {"subgroup_size", caps.subgroup_size},
            {"max_textures", caps.max_bindless_textures},
            {"max_storage_buffer_range", caps.max_storage_buffer_range},
            {"max_allocation_bytes", caps.max_allocation_bytes},
            {"timestamps", caps.timestamp_period_ns > 0}};
}

std::string device_text(const gpu::DeviceCaps& caps, bool best) {
    std::string ways;
    for (const gpu::TraceWay way : kWays)
        if (caps.supports(way)) ways += (ways.empty() ? "" : ", ") + std::string(trace_way_name(way));
    std::string out =
        fmt::format("{}  {}{}\n     {}, Vulkan {}, {}\n     memory {:.1f} GiB, traces by {}\n", caps.index, escape_name(caps.name),
                    best ? "  (chosen by default)" : "", type_name(caps.type), vulkan_version(caps.api_version), escape_name(caps.driver),
                    static_cast<double>(caps.memory_bytes) / (1 << 30), ways);
    for (const std::string& missing : caps.missing) out += fmt::format("     lacks {}\n", missing);
    return out;
}

struct Measured {
    gpu::TraceWay way;
    double mega_rays_per_second;
};

// Every way to trace that the device has, on the built-in Cornell box.
std::vector<Measured> measure(const gpu::DeviceCaps& caps) {
    log(LogLevel::Info, "measuring {}", escape_name(caps.name));
    const LogLevel level = log_level();
    if (level == LogLevel::Info) set_log_level(LogLevel::Warn);  // the jobs' own lines
    const gpu::DevicePtr device = gpu::Device::open({.selector = fmt::format("{}", caps.index)});
    std::vector<BenchCase> cases;
    const bool cpu = caps.type == gpu::DeviceType::Cpu;
    for (const gpu::TraceWay way : kWays)
        if (caps.supports(way))
            cases.push_back({.scene = "builtin:cornell", .way = way, .size = cpu ? Size2{160, 90} : Size2{1280, 720}, .spp = 16});
    std::vector<Measured> results;
    run_bench_cases(cases, {}, device, [&](const BenchRow& row) { results.push_back({row.what.way, row.report.mega_rays_per_second()}); });
    set_log_level(level);
    return results;
}

bool any_usable(const std::vector<gpu::DeviceCaps>& devices) {
    for (const gpu::DeviceCaps& caps : devices)
        if (caps.usable()) return true;
    return false;
}

}  // namespace

int run_devices(const OptionValues& values) {
    const std::vector<gpu::DeviceCaps> devices = gpu::enumerate_devices();
    const bool usable = any_usable(devices);
    const size_t best = usable ? gpu::choose_best(devices) : devices.size();
    Json list = Json::array();
    std::string text;
    for (size_t i = 0; i < devices.size(); ++i) {
        list.push_back(device_json(devices[i], i == best));
        text += device_text(devices[i], i == best);
        if (!values.flag("--measure") || !devices[i].usable()) continue;
        for (const Measured& result : measure(devices[i])) {
            list.back()["measured_mrays_per_s"][std::string(trace_way_name(result.way))] = result.mega_rays_per_second;
            text += fmt::format("     {:<9}{:>10.3f} million rays/s\n", trace_way_name(result.way), result.mega_rays_per_second);
        }
    }
    if (values.flag("--require") && !usable)
        throw Error(ErrorCode::MissingFeature, devices.empty() ? "there is no Vulkan device" : "no device has what Parhelion needs",
                    "devices",
                    devices.empty() ? "install a Vulkan driver: mesa-vulkan-drivers has one for the CPU"
                                    : "parhelion devices lists what each lacks");
    if (devices.empty()) text = "There is no Vulkan device. Install a Vulkan driver; mesa-vulkan-drivers has one for the CPU.\n";
    Json result = {{"devices", list}};
    if (values.flag("--require")) {
        result["required"] = gpu::device_requirements();
        text += "Parhelion needs:\n";
        for (const std::string& needed : gpu::device_requirements()) text += fmt::format("     {}\n", needed);
        text += "Ray tracing pipelines and ray queries are used where a device has them.\n";
    }
    if (values.given("--json"))
        write_json(values.text("--json"), result);
    else
        print_result(text);
    return EXIT_SUCCESS;
}

}  // namespace parhelion::cli
