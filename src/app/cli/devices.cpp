// parhelion devices: what each Vulkan device can do.
#include <cstdlib>

#include <nlohmann/json.hpp>

#include "app/cli/commands.h"
#include "base/error.h"
#include "base/log.h"
#include "gpu/device.h"
#include "image/denoise.h"
#include "session/render_settings.h"
#include "session/results.h"
#include "session/trace_choice.h"

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

Json automatic_json(const gpu::DeviceCaps& caps) {
    const TraceDecision decision = decide_trace(caps, TraceChoice::Auto, gpu::NodeLayout::Auto);
    return {{"trace", trace_way_name(decision.way)}, {"node_layout", node_layout_name(decision.layout)}, {"source", decision.source},
            {"gbuffer", may_draw_pixels({}, caps) ? "raster" : "trace"}};
}

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
            {"class", gpu::device_class(caps).name},
            {"auto", automatic_json(caps)},
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
    const TraceDecision decision = decide_trace(caps, TraceChoice::Auto, gpu::NodeLayout::Auto);
    out += fmt::format("     --trace auto takes {} ({})\n", trace_way_name(decision.way),
                       decision.source == "table" ? fmt::format("device class: {}", gpu::device_class(caps).name) : "measured here");
    out += fmt::format("     gbuffer.mode=auto takes {} (device class: {})\n", may_draw_pixels({}, caps) ? "raster" : "trace", gpu::device_class(caps).name);
    for (const std::string& missing : caps.missing) out += fmt::format("     lacks {}\n", missing);
    return out;
}

// Measures every way to trace and keeps the result for `--trace auto`.
MeasuredTrace measure(const gpu::DeviceCaps& caps) {
    log(LogLevel::Info, "measuring {}", escape_name(caps.name));
    const MeasuredTrace measured = measure_tracing(gpu::Device::open({.selector = fmt::format("{}", caps.index)}));
    store_measured_trace(caps, measured);
    return measured;
}

std::string measured_text(const gpu::DeviceCaps& caps, const MeasuredTrace& measured) {
    std::string out;
    for (const MeasuredTrace::Rate& rate : measured.rates) out += fmt::format("     {:<9}{:>10.3f} million rays/s\n", rate.tracer, rate.mrays_per_s);
    const bool compute = measured.way() == gpu::TraceWay::Compute;
    return out + fmt::format("     --trace auto takes {}{} from now on: {}\n", trace_way_name(measured.way()),
                             compute ? fmt::format(" with {} nodes", node_layout_name(measured.layout())) : "", escape_name(measured_trace_file(caps).string()));
}

Json measured_json(const gpu::DeviceCaps& caps, const MeasuredTrace& measured) {
    Json rates = Json::object();
    for (const MeasuredTrace::Rate& rate : measured.rates) rates[rate.tracer] = rate.mrays_per_s;
    return {{"mrays_per_s", rates}, {"trace", trace_way_name(measured.way())}, {"node_layout", node_layout_name(measured.layout())}, {"file", measured_trace_file(caps).string()}};
}

bool any_usable(const std::vector<gpu::DeviceCaps>& devices) {
    for (const gpu::DeviceCaps& caps : devices)
        if (caps.usable()) return true;
    return false;
}

// What --denoise oidn would take: {"version", "library"} or {"missing"}.
Json denoiser_json() {
    try {
        const image::Denoiser denoiser;
        return {{"version", denoiser.version()}, {"library", denoiser.library()}};
    } catch (const Error& error) {
        return {{"missing", fmt::format("{} ({})", error.problem, error.hint)}};
    }
}

std::string denoiser_text(const Json& denoiser) {
    if (denoiser.contains("missing")) return fmt::format("--denoise oidn has no library: {}\n", denoiser["missing"].get<std::string>());
    return fmt::format("--denoise oidn takes Open Image Denoise {} ({})\n", denoiser["version"].get<std::string>(), escape_name(denoiser["library"].get<std::string>()));
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
        const MeasuredTrace measured = measure(devices[i]);
        list.back()["measured"] = measured_json(devices[i], measured);
        text += measured_text(devices[i], measured);
    }
    if (values.flag("--require") && !usable)
        throw Error(ErrorCode::MissingFeature, devices.empty() ? "there is no Vulkan device" : "no device has what Parhelion needs",
                    "devices",
                    devices.empty() ? "install a Vulkan driver: mesa-vulkan-drivers has one for the CPU"
                                    : "parhelion devices lists what each lacks");
    if (devices.empty()) text = "There is no Vulkan device. Install a Vulkan driver; mesa-vulkan-drivers has one for the CPU.\n";
    const Json denoiser = denoiser_json();
    text += denoiser_text(denoiser);
    Json result = {{"devices", list}, {"oidn", denoiser}};
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
