#include "gpu/device_class.h"

#include <algorithm>
#include <initializer_list>

namespace parhelion::gpu {

namespace {

constexpr uint32_t kNvidia = 0x10DE, kAmd = 0x1002, kIntel = 0x8086;

bool named(const DeviceCaps& caps, std::initializer_list<std::string_view> parts) {
    return std::any_of(parts.begin(), parts.end(), [&](std::string_view part) { return caps.name.find(part) != std::string::npos; });
}

// Drivers of NVIDIA offer rays on cards without ray tracing cores too, by shaders of their own. The data-centre ones (H100, H200) have
// pipelines and no queries, and few of the units that draw; of the others the name tells: GTX, and the Pascal and Volta boards without that word.
bool nvidia_for_computing(const DeviceCaps& caps) {
    return caps.vendor_id == kNvidia && ((caps.ray_pipeline && !caps.ray_query) || named(caps, {"A100", "A800", "H100", "H200", "H800", "B100", "B200"}));
}
bool nvidia_without_cores(const DeviceCaps& caps) {
    return caps.vendor_id == kNvidia && (!caps.ray_query || named(caps, {"GTX", "TITAN V", "TITAN X", "V100", "GV100", "Quadro P", "Tesla P"}));
}

constexpr auto kPipeline = TraceWay::Pipeline, kQuery = TraceWay::Query, kCompute = TraceWay::Compute;

// `parhelion bench trace` says for one device, `parhelion devices --measure` stores what is fastest there, and docs/performance.md has
// the numbers of those that were measured: the CPU device and an NVIDIA GPU without ray tracing cores (H200). The other rows are expectations.
//
// Whether drawing finds the triangles under pixels faster than a ray each was measured on an H100, where it takes 4 times as long
// (docs/performance.md). Lavapipe has no times of passes in a frame that draws, so the CPU device traces.
//
// A CPU device gathers what a vector of rays reads word by word: the smallest nodes are the fastest. GPUs are fastest with four float
// boxes a node.
const DeviceClass kClasses[] = {
    {"CPU", [](const DeviceCaps& caps) { return caps.type == DeviceType::Cpu; }, kCompute, NodeLayout::Compact, false, 1u << 15, false},
    {"NVIDIA data centre", nvidia_for_computing, kCompute, NodeLayout::Four, true, 1u << 22, false},
    {"GPU without ray tracing", [](const DeviceCaps& caps) { return !caps.ray_query && !caps.ray_pipeline; }, kCompute, NodeLayout::Four, true, 1u << 22, true},
    {"NVIDIA without ray tracing cores", nvidia_without_cores, kCompute, NodeLayout::Four, true, 1u << 22, true},
    {"NVIDIA", [](const DeviceCaps& caps) { return caps.vendor_id == kNvidia && caps.ray_query; }, kQuery, NodeLayout::Four, true, 1u << 22, true},
    {"AMD", [](const DeviceCaps& caps) { return caps.vendor_id == kAmd && caps.ray_query; }, kQuery, NodeLayout::Four, true, 1u << 22, true},
    {"Intel", [](const DeviceCaps& caps) { return caps.vendor_id == kIntel && caps.ray_query; }, kQuery, NodeLayout::Four, true, 1u << 22, true},
    {"other with ray queries", [](const DeviceCaps& caps) { return caps.ray_query; }, kQuery, NodeLayout::Four, true, 1u << 22, true},
    {"other", [](const DeviceCaps&) { return true; }, kPipeline, NodeLayout::Four, true, 1u << 22, true},
};

}  // namespace

std::string_view node_layout_name(NodeLayout layout) {
    constexpr std::string_view kNames[] = {"auto", "binary", "four", "compact"};
    return kNames[static_cast<size_t>(layout)];
}

std::span<const DeviceClass> device_classes() { return kClasses; }

const DeviceClass& device_class(const DeviceCaps& caps) {
    return *std::find_if(std::begin(kClasses), std::end(kClasses), [&](const DeviceClass& row) { return row.holds(caps); });
}

}  // namespace parhelion::gpu
