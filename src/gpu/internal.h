#pragma once
// What the files of src/gpu share; the only header that includes vulkan.h. Every Vulkan function is called through a table
// that belongs to one instance or one device: no global function pointers, so that several devices live in one process and a
// host program that links the Vulkan loader itself keeps its own symbols (volk's variables would replace them in a static link).
#define VK_NO_PROTOTYPES
#include <vulkan/vulkan_core.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "gpu/command_list.h"
#include "gpu/device.h"
#include "gpu/program.h"
#include "gpu/resources.h"
#include "gpu/shader_table.h"

namespace parhelion::gpu {

#define PARHELION_INSTANCE_FUNCTIONS(X)                                                                                           \
    X(vkDestroyInstance) X(vkEnumeratePhysicalDevices) X(vkEnumerateDeviceExtensionProperties) X(vkGetPhysicalDeviceProperties)   \
    X(vkGetPhysicalDeviceProperties2) X(vkGetPhysicalDeviceFeatures2) X(vkGetPhysicalDeviceMemoryProperties)                      \
    X(vkGetPhysicalDeviceMemoryProperties2) X(vkGetPhysicalDeviceQueueFamilyProperties) X(vkGetPhysicalDeviceFormatProperties2)   \
    X(vkCreateDevice) X(vkGetDeviceProcAddr) X(vkCreateDebugUtilsMessengerEXT) X(vkDestroyDebugUtilsMessengerEXT)                 \
    X(vkDestroySurfaceKHR) X(vkGetPhysicalDeviceSurfaceSupportKHR) X(vkGetPhysicalDeviceSurfaceCapabilitiesKHR)                   \
    X(vkGetPhysicalDeviceSurfaceFormatsKHR) X(vkGetPhysicalDeviceSurfacePresentModesKHR)

// The first lines are core 1.3 and always there; the others are null where their extension is not enabled.
#define PARHELION_DEVICE_FUNCTIONS(X)                                                                                             \
    X(vkDestroyDevice) X(vkGetDeviceQueue) X(vkDeviceWaitIdle) X(vkQueueSubmit2) X(vkAllocateMemory) X(vkFreeMemory)              \
    X(vkMapMemory) X(vkUnmapMemory) X(vkFlushMappedMemoryRanges) X(vkInvalidateMappedMemoryRanges) X(vkBindBufferMemory)          \
    X(vkBindImageMemory) X(vkBindBufferMemory2) X(vkBindImageMemory2) X(vkGetBufferMemoryRequirements)                            \
    X(vkGetImageMemoryRequirements) X(vkGetBufferMemoryRequirements2) X(vkGetImageMemoryRequirements2)                            \
    X(vkGetDeviceBufferMemoryRequirements) X(vkGetDeviceImageMemoryRequirements) X(vkCreateBuffer) X(vkDestroyBuffer)             \
    X(vkGetBufferDeviceAddress) X(vkCreateImage) X(vkDestroyImage) X(vkCreateImageView) X(vkDestroyImageView)                     \
    X(vkCreateSampler) X(vkDestroySampler) X(vkCreateSemaphore) X(vkDestroySemaphore) X(vkGetSemaphoreCounterValue)               \
    X(vkWaitSemaphores) X(vkCreateQueryPool) X(vkDestroyQueryPool) X(vkGetQueryPoolResults) X(vkCreateDescriptorSetLayout)        \
    X(vkDestroyDescriptorSetLayout) X(vkCreateDescriptorPool) X(vkDestroyDescriptorPool) X(vkAllocateDescriptorSets)              \
    X(vkUpdateDescriptorSets) X(vkCreatePipelineLayout) X(vkDestroyPipelineLayout) X(vkCreateShaderModule)                        \
    X(vkDestroyShaderModule) X(vkCreateComputePipelines) X(vkDestroyPipeline) X(vkCreatePipelineCache) X(vkDestroyPipelineCache)  \
    X(vkGetPipelineCacheData) X(vkCreateCommandPool) X(vkDestroyCommandPool) X(vkResetCommandPool) X(vkAllocateCommandBuffers)    \
    X(vkBeginCommandBuffer) X(vkEndCommandBuffer) X(vkCmdPipelineBarrier2) X(vkCmdBindPipeline) X(vkCmdBindDescriptorSets)        \
    X(vkCmdPushConstants) X(vkCmdDispatch) X(vkCmdDispatchIndirect) X(vkCmdCopyBuffer) X(vkCmdCopyBufferToImage)                  \
    X(vkCmdCopyImageToBuffer) X(vkCmdBlitImage) X(vkCmdFillBuffer) X(vkCmdResetQueryPool) X(vkCmdWriteTimestamp2)                 \
    X(vkCreateGraphicsPipelines) X(vkCmdBeginRendering) X(vkCmdEndRendering) X(vkCmdSetViewport) X(vkCmdSetScissor)               \
    X(vkCmdDraw) X(vkCmdDrawIndirect) X(vkCmdDrawIndirectCount)                                                                   \
    X(vkCmdPushDescriptorSetKHR)                                                                                                  \
    X(vkSetDebugUtilsObjectNameEXT) X(vkCmdBeginDebugUtilsLabelEXT) X(vkCmdEndDebugUtilsLabelEXT)                                 \
    X(vkCreateAccelerationStructureKHR) X(vkDestroyAccelerationStructureKHR) X(vkGetAccelerationStructureBuildSizesKHR)           \
    X(vkGetAccelerationStructureDeviceAddressKHR) X(vkCmdBuildAccelerationStructuresKHR) X(vkCreateRayTracingPipelinesKHR)        \
    X(vkGetRayTracingShaderGroupHandlesKHR) X(vkCmdTraceRaysKHR) X(vkCmdTraceRaysIndirectKHR)                                     \
    X(vkCmdCopyAccelerationStructureKHR) X(vkCmdWriteAccelerationStructuresPropertiesKHR)                                         \
    X(vkCreateSwapchainKHR) X(vkDestroySwapchainKHR) X(vkGetSwapchainImagesKHR) X(vkAcquireNextImageKHR) X(vkQueuePresentKHR)

#define PARHELION_FUNCTION_MEMBER(name) PFN_##name name = nullptr;
struct InstanceFunctions {
    PFN_vkGetInstanceProcAddr vkGetInstanceProcAddr = nullptr;
    PARHELION_INSTANCE_FUNCTIONS(PARHELION_FUNCTION_MEMBER)
};
struct DeviceFunctions {
    PARHELION_DEVICE_FUNCTIONS(PARHELION_FUNCTION_MEMBER)
};
#undef PARHELION_FUNCTION_MEMBER

std::string_view result_name(VkResult result);
inline bool contains(const std::vector<std::string>& names, std::string_view name) { return std::find(names.begin(), names.end(), name) != names.end(); }
// Throws Error for every result but VK_SUCCESS; `call` is the source text of the call, `where` the device's name.
void check_result(VkResult result, const char* call, std::string_view where);
#define PARHELION_VK(where, call) ::parhelion::gpu::check_result((call), #call, (where))

// An instance: ours, or a host program's (then nothing is destroyed).
struct Instance {
    InstanceFunctions vk;
    VkInstance handle = nullptr;
    bool owned = false, debug_utils = false;
    VkDebugUtilsMessengerEXT messenger = nullptr;
    std::mutex mutex;
    std::vector<std::string> messages;  // warnings and errors of the validation layers

    Instance() = default;
    ~Instance();
    Instance(const Instance&) = delete;
    Instance& operator=(const Instance&) = delete;
    std::vector<VkPhysicalDevice> physical_devices() const;
};
PFN_vkGetInstanceProcAddr system_loader();  // nullptr: no Vulkan loader on this machine
// Throws Error MissingFeature without loader, driver, (validate) layers or one of the extensions.
std::shared_ptr<Instance> create_instance(bool validate, std::span<const std::string> more_extensions = {});
std::shared_ptr<Instance> borrow_instance(VkInstance handle, PFN_vkGetInstanceProcAddr get);

// Every feature structure that we look at, chained for a query or for vkCreateDevice.
struct FeatureChain {
    VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    VkPhysicalDeviceVulkan11Features v11{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES};
    VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR accel{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
    VkPhysicalDeviceRayTracingPipelineFeaturesKHR pipeline{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_FEATURES_KHR};
    VkPhysicalDeviceRayQueryFeaturesKHR query{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};

    void link(bool with_pipeline, bool with_query);  // sets the pNext pointers; repeat after a copy
};

// What a physical device offers and what we enable on it.
struct PhysicalDevice {
    VkPhysicalDevice handle = nullptr;
    DeviceCaps caps;
    uint32_t queue_family = 0;
    bool queue_has_graphics = false;
    uint32_t timestamp_bits = 0;
    bool trace_indirect = false;
    uint64_t max_buffer_bytes = 0, max_ray_invocations = 0;
    uint32_t max_push_descriptors = 0;
    VkPhysicalDeviceLimits limits{};
    std::array<uint8_t, VK_UUID_SIZE> cache_uuid{};
    FeatureChain enabled;                 // not linked
    std::vector<std::string> extensions;  // to enable
};
// `windows`: it must be able to show pictures in windows.
PhysicalDevice inspect(const Instance& instance, VkPhysicalDevice handle, uint32_t index, bool mask_ray_tracing, bool windows = false);
void use_queue_family(const Instance& instance, uint32_t family, PhysicalDevice& out);
// The device to open. Throws Usage for an unknown selector (`where` says who gave it), MissingFeature if none is usable.
size_t choose(const std::vector<DeviceCaps>& devices, std::string_view selector, std::string_view where = "--device");

// Where memory lies. Mapped memory is always coherent.
enum class Placement { Device, Upload, Readback, MappedDevice };
Placement placement_of(MemoryKind kind);
struct Allocation {
    void* handle = nullptr;
    VkDeviceMemory memory = nullptr;
    uint64_t offset = 0, bytes = 0;
    std::byte* mapped = nullptr;
};
// Memory in blocks, by the Vulkan Memory Allocator; memory.cpp keeps that library's header and symbols to itself.
class MemoryBlocks {
public:
    MemoryBlocks(const Device::Impl& device);
    ~MemoryBlocks();
    MemoryBlocks(const MemoryBlocks&) = delete;
    MemoryBlocks& operator=(const MemoryBlocks&) = delete;
    VkResult allocate(const VkMemoryRequirements& needs, Placement placement, Allocation& out);
    void free(const Allocation& allocation);

private:
    void* allocator_ = nullptr;
};

// A buffer without an owner: Buffer, AccelStruct and Program hold one.
struct RawBuffer {
    VkBuffer handle = nullptr;
    Allocation allocation;
    uint64_t bytes = 0, address = 0;
};

struct CommandSlot {
    VkCommandPool pool = nullptr;
    VkCommandBuffer buffer = nullptr;
};

struct Device::Impl {
    std::shared_ptr<Instance> instance;
    PhysicalDevice physical;
    VkDevice device = nullptr;
    VkQueue queue = nullptr;
    bool owned = false, has_accel = false;
    DeviceFunctions vk;  // tests replace entries to inject failures
    std::unique_ptr<MemoryBlocks> memory;
    VkDescriptorSetLayout scene_layout = nullptr;
    VkPipelineCache pipeline_cache = nullptr;
    uint64_t loaded_cache_hash = 0;

    std::mutex mutex;  // guards everything below
    VkSemaphore timeline = nullptr;
    Ticket submitted = 0;
    std::vector<CommandSlot> free_slots;
    std::vector<std::pair<Ticket, CommandSlot>> busy_slots;
    std::vector<std::pair<SamplerDesc, std::shared_ptr<Sampler::Data>>> samplers;
    std::map<std::pair<uint64_t, std::string>, std::shared_ptr<Program::Data>> programs;
    std::map<std::string, uint64_t, std::less<>> memory_use;
    uint64_t memory_now = 0, memory_peak = 0;  // bytes of all groups

    const std::string& name() const { return physical.caps.name; }
    void start();                   // after `device` is set: functions, memory, set 0, pipeline cache
    void destroy(bool wait_for_all) noexcept;
    void set_name(VkObjectType type, uint64_t handle, std::string_view name) const;
    template <class Handle>
    void set_name(VkObjectType type, Handle* handle, std::string_view text) const {
        set_name(type, reinterpret_cast<uint64_t>(handle), text);
    }
    RawBuffer create_buffer(const std::string& name, uint64_t bytes, Placement placement);
    void destroy_buffer(const std::string& name, RawBuffer& buffer) noexcept;
    void account(std::string_view resource_name, int64_t bytes);
    void make_scene_layout();
    void load_pipeline_cache();
    void save_pipeline_cache() noexcept;
    CommandSlot take_slot();
    Ticket completed();  // throws on device loss
};

struct Buffer::Data {
    DevicePtr device;
    std::string name;
    RawBuffer raw;
    ~Data();
};

struct Image::Data {
    DevicePtr device;
    std::string name;
    ImageDesc desc;
    VkImage handle = nullptr;
    VkImageView sampled = nullptr;  // all mips; null for a borrowed image
    VkImageView storage = nullptr;  // mip 0; null where the format has no storage
    VkImageView attachment = nullptr;  // null for a borrowed image, with mip levels, and where nothing can be drawn to the format
    Allocation allocation;
    bool owned = false;
    std::atomic<bool> initialised{false};  // its transition to GENERAL is recorded
    ~Data();
};
VkFormat vk_format(Format format);
VkImageAspectFlags image_aspect(Format format);

struct Sampler::Data {
    VkSampler handle = nullptr;
};

constexpr VkBuildAccelerationStructureFlagsKHR kTopFlags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
constexpr VkBuildAccelerationStructureFlagsKHR kStaticFlags = kTopFlags | VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_COMPACTION_BIT_KHR;
constexpr VkBuildAccelerationStructureFlagsKHR kDeformingFlags = kTopFlags | VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;

struct AccelStruct::Data {
    DevicePtr device;
    std::string name;
    RawBuffer storage;
    VkAccelerationStructureKHR handle = nullptr;
    uint64_t address = 0, scratch_bytes = 0;
    uint32_t max_instances = 0;                   // top level
    std::vector<std::pair<uint32_t, uint32_t>> sizes;  // bottom level: vertices, triangles of each geometry
    VkBuildAccelerationStructureFlagsKHR flags = kTopFlags;
    ~Data();
};
VkAccelerationStructureGeometryKHR triangle_geometry(const BlasGeometry& geometry);
VkAccelerationStructureGeometryKHR instance_geometry(uint64_t instances_address);

struct AccelSizes::Data {
    DevicePtr device;
    VkQueryPool pool = nullptr;
    uint32_t count = 0;
    ~Data();
};

// Owned by the device's cache: holds no DevicePtr of its own, the handles given out do.
struct Program::Data {
    ShaderCode code;  // of the compute shader or raygen, of both raster shaders; without words
    VkPipelineBindPoint point = VK_PIPELINE_BIND_POINT_COMPUTE;
    bool scene_set = false;
    VkShaderStageFlags push_stages = 0;
    VkDescriptorSetLayout set1 = nullptr;
    VkPipelineLayout layout = nullptr;
    VkPipeline pipeline = nullptr;
    RawBuffer sbt;
    VkStridedDeviceAddressRegionKHR raygen{}, miss{}, hit{};
    void destroy(Device::Impl& device) noexcept;
};

struct SceneSet::Data {
    DevicePtr device;
    std::string name;
    VkDescriptorPool pool = nullptr;
    VkDescriptorSet set = nullptr;
    uint32_t max_textures = 0;
    ~Data();
};

struct TimerPool::Data {
    DevicePtr device;
    VkQueryPool pool = nullptr;
    uint32_t count = 0;
    ~Data();
};

struct CommandList::Impl {
    DevicePtr device;
    VkCommandBuffer buffer = nullptr;
    CommandSlot slot;  // own lists only
    bool own = false;
    const Program::Data* bound = nullptr;
    Extent target;  // of what begin_rendering() began
    std::vector<std::shared_ptr<Image::Data>> first_layouts;  // undone if the list is never submitted
    ~Impl();
    const DeviceFunctions& vk() const { return device->impl().vk; }
    const Program::Data& bound_program(VkPipelineBindPoint point) const;  // the one bound last, which must be of that sort
    void memory_barrier(VkPipelineStageFlags2 before, VkAccessFlags2 before_access, VkPipelineStageFlags2 after, VkAccessFlags2 after_access);
    void blit(const Image& from, VkImage to, const Extent& extent, VkImageLayout layout);  // mip 0
};

struct StageAccess {
    VkPipelineStageFlags2 stages = 0;
    VkAccessFlags2 access = 0;
};
StageAccess stage_access(Use use);

}  // namespace parhelion::gpu
