#pragma once
// A Vulkan device: made by us or borrowed from a host program. Functions go through a per-device table, so several devices
// live in one process. Everything made from a device keeps it alive.
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "gpu/vulkan_handles.h"

namespace parhelion::gpu {

enum class DeviceType { Discrete, Integrated, Virtual, Cpu, Other };

// The three ways to trace (design: Platform).
enum class TraceWay { Pipeline, Query, Compute };
std::string_view trace_way_name(TraceWay way);

struct DeviceCaps {
    std::string name, driver;  // driver: name and version in words
    DeviceType type = DeviceType::Other;
    uint32_t index = 0;        // position in the enumeration, for --device
    uint32_t vendor_id = 0, device_id = 0, api_version = 0;
    uint64_t memory_bytes = 0;  // largest device-local heap
    bool ray_pipeline = false, ray_query = false, shader_float64 = false;
    bool block_compression = false;  // images of the formats BC1 to BC7
    bool raster = false;               // raster programs: the queue draws, dynamic rendering, lists of indirect draws
    bool draw_indirect_count = false;  // their number can come from a buffer too
    bool buffer_int64_atomics = false;  // shaderBufferInt64Atomics
    uint32_t subgroup_size = 0;
    bool subgroup_ballot = false;  // in compute shaders
    uint32_t shader_group_handle_size = 0, shader_group_handle_alignment = 0, shader_group_base_alignment = 0;
    uint32_t max_ray_recursion_depth = 0, scratch_alignment = 0;
    uint32_t max_push_constant_bytes = 0, max_bindless_textures = 0;
    uint64_t max_storage_buffer_range = 0, max_allocation_bytes = 0;
    double timestamp_period_ns = 0;  // 0: no timestamps
    std::vector<std::string> missing;  // needed features and extensions that it lacks, all at once; empty: usable

    bool usable() const { return missing.empty(); }
    bool supports(TraceWay way) const { return way == TraceWay::Compute || (way == TraceWay::Pipeline ? ray_pipeline : ray_query); }
};

struct DeviceRequest {
    std::string selector;       // part of a name (any case) or an index; empty: PARHELION_DEVICE, else the best one
    bool validate = false;      // core and synchronisation validation; any message is counted and logged as an error
    // Instance extensions that a window library asks for; not empty: the device must be able to show pictures (gpu/swapchain.h).
    std::vector<std::string> window_extensions = {};
    bool mask_ray_tracing = false;  // as if the device had no ray tracing extension at all; PARHELION_MASK masks them one by one, everywhere, and rasterisation
};

// Handles of a host program. The device must have been made with the extensions and features listed by
// required_device_extensions() / docs/embedding.md; `enabled_*` say which optional ones are on.
struct BorrowedDevice {
    VkInstance instance = nullptr;
    VkPhysicalDevice physical_device = nullptr;
    VkDevice device = nullptr;
    VkQueue queue = nullptr;  // graphics + compute + transfer
    uint32_t queue_family = 0;
    bool enabled_ray_pipeline = false, enabled_ray_query = false;
    bool enabled_block_compression = false;  // the feature textureCompressionBC
    bool enabled_raster = false;  // dynamicRendering, multiDrawIndirect and drawIndirectFirstInstance
    bool enabled_draw_indirect_count = false;  // drawIndirectCount
    bool enabled_buffer_int64_atomics = false;  // the feature shaderBufferInt64Atomics
    void* (*get_instance_proc_addr)(VkInstance, const char*) = nullptr;  // null: the system loader
};
// Names of the device extensions to enable when making a device for us to borrow; the optional ray tracing ones included
// only if the physical device has them.
std::vector<std::string> device_extensions(VkInstance instance, VkPhysicalDevice physical_device);
// The pNext chain of VkDeviceCreateInfo for such a device (it begins with VkPhysicalDeviceFeatures2): what we need, and what
// we use where the device has it. Valid while the returned object lives.
std::shared_ptr<const void> device_features(VkInstance instance, VkPhysicalDevice physical_device);

// Everything that a device must have, in words: what DeviceCaps::missing is drawn from.
std::vector<std::string> device_requirements();

// Every Vulkan device of the machine, best first is choose_best(). Empty if there is no loader or driver.
std::vector<DeviceCaps> enumerate_devices();
size_t choose_best(const std::vector<DeviceCaps>& devices);  // most capable usable one; throws MissingFeature if none

struct MemoryUse {
    std::string group;  // first part of the resource name: "scene", "film", ...
    uint64_t bytes = 0;
};

class Device : public std::enable_shared_from_this<Device> {
public:
    static std::shared_ptr<Device> open(const DeviceRequest& request);
    static std::shared_ptr<Device> borrow(const BorrowedDevice& handles);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const DeviceCaps& caps() const { return caps_; }
    void wait_idle();
    uint64_t validation_message_count() const;  // errors and warnings of the layers since the device was made
    std::vector<std::string> validation_messages() const;
    std::vector<MemoryUse> memory_use() const;  // bytes now allocated, by group
    uint64_t peak_memory_bytes() const;         // the most that was allocated at any time, all groups together

    struct Impl;  // Vulkan objects, defined in gpu/internal.h
    Impl& impl() { return *impl_; }
    const Impl& impl() const { return *impl_; }

private:
    Device();
    DeviceCaps caps_;
    std::unique_ptr<Impl> impl_;
};

using DevicePtr = std::shared_ptr<Device>;

}  // namespace parhelion::gpu
