#pragma once
// Where the records of a shader binding table lie: raygen, two miss shaders, one hit group (four groups). No Vulkan.
#include <algorithm>
#include <cstdint>

namespace parhelion::gpu {

constexpr uint64_t align_up(uint64_t value, uint64_t alignment) { return (value + alignment - 1) / alignment * alignment; }

// Stricter than some devices ask (the CPU driver takes any): a table for one is right for all.
constexpr uint64_t kTableAlignment = 64;

// Bytes from the table's address, which must be a multiple of `base`. Records lie `stride` apart, each region (raygen, misses, hit
// group) begins at a multiple of `base`.
struct ShaderTableLayout {
    uint64_t stride = 0, base = 0;
    uint64_t raygen = 0, miss = 0, shadow_miss = 0, hit = 0;
    uint64_t bytes = 0;
};

// Limits as VkPhysicalDeviceRayTracingPipelinePropertiesKHR has them; alignments are powers of two.
constexpr ShaderTableLayout layout_shader_table(uint64_t handle_bytes, uint64_t handle_alignment, uint64_t base_alignment) {
    ShaderTableLayout out;
    out.stride = align_up(handle_bytes, handle_alignment);
    out.base = std::max(base_alignment, kTableAlignment);
    out.miss = align_up(out.stride, out.base);
    out.shadow_miss = out.miss + out.stride;
    out.hit = align_up(out.shadow_miss + out.stride, out.base);
    out.bytes = out.hit + out.stride;
    return out;
}

}  // namespace parhelion::gpu
