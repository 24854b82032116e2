// Which device to use. Pure functions of what the devices can do.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <tuple>

#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

std::string lower(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return out;
}

std::string joined(const std::vector<std::string>& parts) {
    std::string out;
    for (const std::string& part : parts) out += (out.empty() ? "" : ", ") + part;
    return out;
}

// Larger is better: kind of device, ways to trace, memory. Of equals the first wins.
auto rank(const DeviceCaps& caps) {
    const int kind = caps.type == DeviceType::Discrete ? 4 : caps.type == DeviceType::Integrated ? 3 : caps.type == DeviceType::Virtual ? 2 : caps.type == DeviceType::Cpu ? 1 : 0;
    return std::tuple(caps.usable(), kind, int(caps.ray_pipeline) + int(caps.ray_query), caps.memory_bytes);
}

std::string list_of(const std::vector<DeviceCaps>& devices) {
    std::string out;
    for (const DeviceCaps& caps : devices) out += fmt::format("{}{} {}", out.empty() ? "" : ", ", caps.index, escape_name(caps.name));
    return out.empty() ? "none" : out;
}

[[noreturn]] void fail_unusable(const std::vector<DeviceCaps>& devices) {
    if (devices.empty())
        throw Error(ErrorCode::MissingFeature, "this machine has no Vulkan device", "Vulkan", "install a Vulkan driver; mesa-vulkan-drivers 25 or newer runs on any CPU");
    std::string lacks;
    for (const DeviceCaps& caps : devices) lacks += fmt::format("{}{} lacks {}", lacks.empty() ? "" : "; ", escape_name(caps.name), joined(caps.missing));
    throw Error(ErrorCode::MissingFeature, "no Vulkan device can be used: " + lacks, "Vulkan", "a newer driver may help; mesa-vulkan-drivers 25 or newer runs on any CPU");
}

}  // namespace

std::string_view trace_way_name(TraceWay way) {
    return way == TraceWay::Pipeline ? "pipeline" : way == TraceWay::Query ? "query" : "compute";
}

size_t choose_best(const std::vector<DeviceCaps>& devices) {
    size_t best = 0;
    for (size_t i = 1; i < devices.size(); ++i)
        if (rank(devices[i]) > rank(devices[best])) best = i;
    if (devices.empty() || !devices[best].usable()) fail_unusable(devices);
    return best;
}

size_t choose(const std::vector<DeviceCaps>& devices, std::string_view selector, std::string_view where) {
    if (selector.empty() || devices.empty()) return choose_best(devices);
    std::vector<DeviceCaps> matching;
    uint32_t index = 0;
    const auto [end, error] = std::from_chars(selector.data(), selector.data() + selector.size(), index);
    const bool is_index = error == std::errc() && end == selector.data() + selector.size();
    for (const DeviceCaps& caps : devices)
        if (is_index ? caps.index == index : lower(caps.name).find(lower(selector)) != std::string::npos) matching.push_back(caps);
    if (matching.empty())
        throw Error(ErrorCode::Usage, fmt::format("no device is called '{}'; there are: {}", escape_name(selector), list_of(devices)), std::string(where),
                    "give an index or a part of a name");
    const uint32_t chosen = matching[choose_best(matching)].index;
    for (size_t i = 0; i < devices.size(); ++i)
        if (devices[i].index == chosen) return i;
    fail_unusable(devices);
}

}  // namespace parhelion::gpu
