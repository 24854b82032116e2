// The Vulkan Memory Allocator, kept inside this file: its C functions are made static and its classes lie in a namespace of
// ours, so that a host program with another version of the same library can link Parhelion.
#include "gpu/internal.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <shared_mutex>
#include <type_traits>

#include <vulkan/vulkan.h>

#define VMA_IMPLEMENTATION
#define VMA_STATIC_VULKAN_FUNCTIONS 0
#define VMA_DYNAMIC_VULKAN_FUNCTIONS 0
#define VMA_VULKAN_VERSION 1003000
#define VMA_STATS_STRING_ENABLED 0
#define VMA_CALL_PRE [[maybe_unused]] static
#define VMA_NULLABLE
#define VMA_NOT_NULL
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-variable"
#pragma GCC diagnostic ignored "-Wparentheses"
#pragma GCC diagnostic ignored "-Wsubobject-linkage"
namespace parhelion::gpu::vma {
#include <vk_mem_alloc.h>
}
#pragma GCC diagnostic pop

namespace parhelion::gpu {

namespace {

struct MemoryFlags {
    VkMemoryPropertyFlags required = 0, preferred = 0, avoided = 0;
};

MemoryFlags memory_flags(Placement placement) {
    constexpr VkMemoryPropertyFlags kMapped = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
    switch (placement) {
        case Placement::Device: return {.preferred = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT};
        case Placement::Upload: return {.required = kMapped, .avoided = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | VK_MEMORY_PROPERTY_HOST_CACHED_BIT};
        case Placement::Readback: return {.required = kMapped, .preferred = VK_MEMORY_PROPERTY_HOST_CACHED_BIT};
        case Placement::MappedDevice: return {.required = kMapped, .preferred = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT};
    }
    return {};
}

vma::VmaVulkanFunctions functions(const Device::Impl& device) {
    vma::VmaVulkanFunctions f{};
    const InstanceFunctions& instance = device.instance->vk;
    f.vkGetPhysicalDeviceProperties = instance.vkGetPhysicalDeviceProperties;
    f.vkGetPhysicalDeviceMemoryProperties = instance.vkGetPhysicalDeviceMemoryProperties;
    f.vkGetPhysicalDeviceMemoryProperties2KHR = instance.vkGetPhysicalDeviceMemoryProperties2;
    const DeviceFunctions& vk = device.vk;
    f.vkAllocateMemory = vk.vkAllocateMemory;
    f.vkFreeMemory = vk.vkFreeMemory;
    f.vkMapMemory = vk.vkMapMemory;
    f.vkUnmapMemory = vk.vkUnmapMemory;
    f.vkFlushMappedMemoryRanges = vk.vkFlushMappedMemoryRanges;
    f.vkInvalidateMappedMemoryRanges = vk.vkInvalidateMappedMemoryRanges;
    f.vkBindBufferMemory = vk.vkBindBufferMemory;
    f.vkBindImageMemory = vk.vkBindImageMemory;
    f.vkGetBufferMemoryRequirements = vk.vkGetBufferMemoryRequirements;
    f.vkGetImageMemoryRequirements = vk.vkGetImageMemoryRequirements;
    f.vkCreateBuffer = vk.vkCreateBuffer;
    f.vkDestroyBuffer = vk.vkDestroyBuffer;
    f.vkCreateImage = vk.vkCreateImage;
    f.vkDestroyImage = vk.vkDestroyImage;
    f.vkCmdCopyBuffer = vk.vkCmdCopyBuffer;
    f.vkGetBufferMemoryRequirements2KHR = vk.vkGetBufferMemoryRequirements2;
    f.vkGetImageMemoryRequirements2KHR = vk.vkGetImageMemoryRequirements2;
    f.vkBindBufferMemory2KHR = vk.vkBindBufferMemory2;
    f.vkBindImageMemory2KHR = vk.vkBindImageMemory2;
    f.vkGetDeviceBufferMemoryRequirements = vk.vkGetDeviceBufferMemoryRequirements;
    f.vkGetDeviceImageMemoryRequirements = vk.vkGetDeviceImageMemoryRequirements;
    return f;
}

}  // namespace

Placement placement_of(MemoryKind kind) {
    return kind == MemoryKind::Device ? Placement::Device : kind == MemoryKind::Upload ? Placement::Upload : Placement::Readback;
}

MemoryBlocks::MemoryBlocks(const Device::Impl& device) {
    const vma::VmaVulkanFunctions table = functions(device);
    vma::VmaAllocatorCreateInfo info{};
    info.flags = vma::VMA_ALLOCATOR_CREATE_BUFFER_DEVICE_ADDRESS_BIT;
    info.instance = device.instance->handle;
    info.physicalDevice = device.physical.handle;
    info.device = device.device;
    info.vulkanApiVersion = VK_API_VERSION_1_3;
    info.pVulkanFunctions = &table;
    vma::VmaAllocator allocator = nullptr;
    PARHELION_VK(device.name(), vma::vmaCreateAllocator(&info, &allocator));
    allocator_ = allocator;
}

MemoryBlocks::~MemoryBlocks() { vma::vmaDestroyAllocator(static_cast<vma::VmaAllocator>(allocator_)); }

VkResult MemoryBlocks::allocate(const VkMemoryRequirements& needs, Placement placement, Allocation& out) {
    const MemoryFlags flags = memory_flags(placement);
    vma::VmaAllocationCreateInfo create{};
    create.requiredFlags = flags.required;
    create.preferredFlags = flags.preferred;
    if (placement != Placement::Device) create.flags = vma::VMA_ALLOCATION_CREATE_MAPPED_BIT;
    // The allocator picks the first type with the fewest missing preferred flags; types to avoid are masked out if others serve.
    if (flags.avoided != 0) {
        const VkPhysicalDeviceMemoryProperties* types = nullptr;
        vma::vmaGetMemoryProperties(static_cast<vma::VmaAllocator>(allocator_), &types);
        for (uint32_t i = 0; i < types->memoryTypeCount; ++i) {
            const VkMemoryPropertyFlags type = types->memoryTypes[i].propertyFlags;
            if ((type & flags.required) == flags.required && (type & flags.avoided) == 0) create.memoryTypeBits |= 1u << i;
        }
        if ((create.memoryTypeBits & needs.memoryTypeBits) == 0) create.memoryTypeBits = 0;
    }
    vma::VmaAllocation allocation = nullptr;
    vma::VmaAllocationInfo info{};
    const VkResult result = vma::vmaAllocateMemory(static_cast<vma::VmaAllocator>(allocator_), &needs, &create, &allocation, &info);
    if (result == VK_SUCCESS) out = {allocation, info.deviceMemory, info.offset, info.size, static_cast<std::byte*>(info.pMappedData)};
    return result;
}

void MemoryBlocks::free(const Allocation& allocation) {
    vma::vmaFreeMemory(static_cast<vma::VmaAllocator>(allocator_), static_cast<vma::VmaAllocation>(allocation.handle));
}

}  // namespace parhelion::gpu
