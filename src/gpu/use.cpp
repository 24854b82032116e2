// How each Use maps to Vulkan's stages and access.
#include <array>

#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

struct UseInfo {
    Use use;
    std::string_view name;
    bool reads, writes;
    StageAccess vulkan;
};

constexpr VkAccessFlags2 kShaderRead = VK_ACCESS_2_SHADER_STORAGE_READ_BIT | VK_ACCESS_2_UNIFORM_READ_BIT;
constexpr VkAccessFlags2 kShaderWrite = VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT;
constexpr VkAccessFlags2 kAccelRead = VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR, kAccelWrite = VK_ACCESS_2_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
constexpr VkPipelineStageFlags2 kCompute = VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, kTrace = VK_PIPELINE_STAGE_2_RAY_TRACING_SHADER_BIT_KHR;
constexpr VkPipelineStageFlags2 kRaster = VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
constexpr VkPipelineStageFlags2 kBuild = VK_PIPELINE_STAGE_2_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
constexpr VkPipelineStageFlags2 kTransfer = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, kHost = VK_PIPELINE_STAGE_2_HOST_BIT;

// In the order of the enumeration. Builds read their inputs as shader reads (Vulkan 1.3, "Acceleration Structure Building").
constexpr std::array<UseInfo, 23> kUses = {{
    {Use::ComputeRead, "compute_read", true, false, {kCompute, kShaderRead}},
    {Use::ComputeWrite, "compute_write", false, true, {kCompute, kShaderWrite}},
    {Use::ComputeReadWrite, "compute_read_write", true, true, {kCompute, kShaderRead | kShaderWrite}},
    {Use::TraceRead, "trace_read", true, false, {kTrace, kShaderRead}},
    {Use::TraceWrite, "trace_write", false, true, {kTrace, kShaderWrite}},
    {Use::TraceReadWrite, "trace_read_write", true, true, {kTrace, kShaderRead | kShaderWrite}},
    {Use::ComputeSample, "compute_sample", true, false, {kCompute, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT}},
    {Use::TraceSample, "trace_sample", true, false, {kTrace, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT}},
    {Use::ComputeAccel, "compute_accel", true, false, {kCompute, kAccelRead}},
    {Use::TraceAccel, "trace_accel", true, false, {kTrace, kAccelRead}},
    {Use::RasterRead, "raster_read", true, false, {kRaster, kShaderRead}},
    {Use::RasterSample, "raster_sample", true, false, {kRaster, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT}},
    {Use::ColorAttachment, "color_attachment", true, true,
     {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT}},
    {Use::DepthAttachment, "depth_attachment", true, true,
     {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
      VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT}},
    {Use::IndirectRead, "indirect_read", true, false, {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT}},
    {Use::TransferRead, "transfer_read", true, false, {kTransfer, VK_ACCESS_2_TRANSFER_READ_BIT}},
    {Use::TransferWrite, "transfer_write", false, true, {kTransfer, VK_ACCESS_2_TRANSFER_WRITE_BIT}},
    {Use::BuildInput, "build_input", true, false, {kBuild, VK_ACCESS_2_SHADER_READ_BIT}},
    {Use::BuildWrite, "build_write", false, true, {kBuild, kAccelWrite}},
    {Use::BuildRead, "build_read", true, false, {kBuild, kAccelRead}},
    {Use::BuildScratch, "build_scratch", true, true, {kBuild, kAccelRead | kAccelWrite}},
    {Use::HostRead, "host_read", true, false, {kHost, VK_ACCESS_2_HOST_READ_BIT}},
    {Use::HostWrite, "host_write", false, true, {kHost, VK_ACCESS_2_HOST_WRITE_BIT}},
}};

constexpr bool in_order() {
    for (size_t i = 0; i < kUses.size(); ++i)
        if (static_cast<size_t>(kUses[i].use) != i) return false;
    return static_cast<size_t>(Use::HostWrite) + 1 == kUses.size();
}
static_assert(in_order());

const UseInfo& info(Use use) { return kUses.at(static_cast<size_t>(use)); }

}  // namespace

bool use_writes(Use use) { return info(use).writes; }
bool use_reads(Use use) { return info(use).reads; }
std::string_view use_name(Use use) { return info(use).name; }
StageAccess stage_access(Use use) { return info(use).vulkan; }

}  // namespace parhelion::gpu
