// What a physical device can do, what it lacks, and what we enable on it.
#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

DeviceType device_type(VkPhysicalDeviceType type) {
    switch (type) {
        case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return DeviceType::Discrete;
        case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return DeviceType::Integrated;
        case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return DeviceType::Virtual;
        case VK_PHYSICAL_DEVICE_TYPE_CPU: return DeviceType::Cpu;
        default: return DeviceType::Other;
    }
}

std::vector<std::string> device_extension_names(const Instance& instance, VkPhysicalDevice device) {
    uint32_t count = 0;
    std::vector<std::string> names;
    if (instance.vk.vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr) < VK_SUCCESS) return names;
    std::vector<VkExtensionProperties> properties(count);
    if (instance.vk.vkEnumerateDeviceExtensionProperties(device, nullptr, &count, properties.data()) < VK_SUCCESS) return names;
    for (uint32_t i = 0; i < count; ++i) names.emplace_back(properties[i].extensionName);
    return names;
}

// The features that every device must have (noted in `missing` otherwise) and those that are switched on where they exist.
void pick_features(const FeatureChain& has, FeatureChain& enabled, std::vector<std::string>& missing) {
    const auto need = [&](VkBool32 supported, VkBool32& out, const char* name) {
        if (supported) out = VK_TRUE;
        else missing.emplace_back(name);
    };
#define PARHELION_NEED(part, name) need(has.part.name, enabled.part.name, #name)
#define PARHELION_WANT(part, name) enabled.part.name = has.part.name
    PARHELION_NEED(core.features, shaderInt64);
    PARHELION_NEED(core.features, shaderStorageImageExtendedFormats);
    PARHELION_NEED(core.features, shaderSampledImageArrayDynamicIndexing);
    PARHELION_NEED(v12, bufferDeviceAddress);
    PARHELION_NEED(v12, descriptorIndexing);
    PARHELION_NEED(v12, runtimeDescriptorArray);
    PARHELION_NEED(v12, descriptorBindingPartiallyBound);
    PARHELION_NEED(v12, descriptorBindingVariableDescriptorCount);
    PARHELION_NEED(v12, descriptorBindingSampledImageUpdateAfterBind);
    PARHELION_NEED(v12, shaderSampledImageArrayNonUniformIndexing);
    PARHELION_NEED(v12, scalarBlockLayout);
    PARHELION_NEED(v12, timelineSemaphore);
    PARHELION_NEED(v13, synchronization2);
    PARHELION_NEED(v13, maintenance4);
    PARHELION_WANT(core.features, shaderFloat64);
    PARHELION_WANT(core.features, shaderInt16);
    PARHELION_WANT(core.features, shaderStorageImageReadWithoutFormat);
    PARHELION_WANT(core.features, shaderStorageImageWriteWithoutFormat);
    PARHELION_WANT(core.features, textureCompressionBC);
    PARHELION_WANT(v11, storageBuffer16BitAccess);
    PARHELION_WANT(v12, storageBuffer8BitAccess);
    PARHELION_WANT(v12, shaderFloat16);
    PARHELION_WANT(v12, shaderInt8);
    PARHELION_WANT(v12, shaderBufferInt64Atomics);
    PARHELION_WANT(v12, vulkanMemoryModel);
    PARHELION_WANT(v12, vulkanMemoryModelDeviceScope);
    PARHELION_WANT(core.features, multiDrawIndirect);
    PARHELION_WANT(core.features, drawIndirectFirstInstance);
    PARHELION_WANT(v12, drawIndirectCount);
    PARHELION_WANT(v13, dynamicRendering);
#undef PARHELION_NEED
#undef PARHELION_WANT
}

struct Properties {
    VkPhysicalDeviceProperties2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    VkPhysicalDeviceVulkan11Properties v11{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_PROPERTIES};
    VkPhysicalDeviceVulkan12Properties v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES};
    VkPhysicalDeviceVulkan13Properties v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES};
    VkPhysicalDevicePushDescriptorPropertiesKHR push{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PUSH_DESCRIPTOR_PROPERTIES_KHR};
    VkPhysicalDeviceAccelerationStructurePropertiesKHR accel{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
    VkPhysicalDeviceRayTracingPipelinePropertiesKHR pipeline{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_TRACING_PIPELINE_PROPERTIES_KHR};

    Properties(bool with_push, bool with_accel, bool with_pipeline) {
        core.pNext = &v11;
        v11.pNext = &v12;
        v12.pNext = &v13;
        void** end = &v13.pNext;
        const auto add = [&](auto& part) { *end = &part, end = &part.pNext; };
        if (with_push) add(push);
        if (with_accel) add(accel);
        if (with_pipeline) add(pipeline);
    }
};

void note_limits(const Properties& p, PhysicalDevice& out) {
    DeviceCaps& caps = out.caps;
    out.max_push_descriptors = p.push.maxPushDescriptors;
    out.max_buffer_bytes = std::min(p.v13.maxBufferSize, p.v11.maxMemoryAllocationSize);
    caps.driver = fmt::format("{} {}", p.v12.driverName, p.v12.driverInfo);
    caps.subgroup_size = p.v11.subgroupSize;
    caps.subgroup_ballot = (p.v11.subgroupSupportedOperations & VK_SUBGROUP_FEATURE_BALLOT_BIT) != 0 &&
                           (p.v11.subgroupSupportedStages & VK_SHADER_STAGE_COMPUTE_BIT) != 0;
    caps.max_allocation_bytes = p.v11.maxMemoryAllocationSize;
    caps.max_push_constant_bytes = out.limits.maxPushConstantsSize;
    caps.max_storage_buffer_range = out.limits.maxStorageBufferRange;
    if (caps.ray_pipeline) {
        caps.shader_group_handle_size = p.pipeline.shaderGroupHandleSize;
        caps.shader_group_handle_alignment = p.pipeline.shaderGroupHandleAlignment;
        caps.shader_group_base_alignment = p.pipeline.shaderGroupBaseAlignment;
        caps.max_ray_recursion_depth = p.pipeline.maxRayRecursionDepth;
        out.max_ray_invocations = p.pipeline.maxRayDispatchInvocationCount;
    }
    if (caps.ray_pipeline || caps.ray_query) caps.scratch_alignment = p.accel.minAccelerationStructureScratchOffsetAlignment;
    // Leaves room for what else a stage binds; more textures than 65536 no scene of ours has.
    constexpr uint32_t kOtherResources = 64, kMostTextures = 65536;
    const uint32_t textures = std::min({p.v12.maxPerStageDescriptorUpdateAfterBindSampledImages, p.v12.maxPerStageDescriptorUpdateAfterBindSamplers,
                                        p.v12.maxDescriptorSetUpdateAfterBindSampledImages, p.v12.maxDescriptorSetUpdateAfterBindSamplers,
                                        p.v12.maxPerStageUpdateAfterBindResources, kMostTextures + kOtherResources});
    caps.max_bindless_textures = textures > kOtherResources ? textures - kOtherResources : 0;
}

std::vector<VkQueueFamilyProperties> queue_families(const Instance& instance, VkPhysicalDevice handle) {
    uint32_t count = 0;
    instance.vk.vkGetPhysicalDeviceQueueFamilyProperties(handle, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    instance.vk.vkGetPhysicalDeviceQueueFamilyProperties(handle, &count, families.data());
    families.resize(count);
    return families;
}

// Prefers a family that also draws (blits need it); any that computes serves.
bool pick_queue(const Instance& instance, PhysicalDevice& out) {
    const std::vector<VkQueueFamilyProperties> families = queue_families(instance, out.handle);
    for (const int wanted : {VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT, int(VK_QUEUE_COMPUTE_BIT)})
        for (uint32_t i = 0; i < families.size(); ++i) {
            if ((families[i].queueFlags & static_cast<VkQueueFlags>(wanted)) != static_cast<VkQueueFlags>(wanted)) continue;
            use_queue_family(instance, i, out);
            return true;
        }
    return false;
}

void note_basics(const Instance& instance, PhysicalDevice& out) {
    VkPhysicalDeviceProperties basics{};
    instance.vk.vkGetPhysicalDeviceProperties(out.handle, &basics);
    DeviceCaps& caps = out.caps;
    caps.name = basics.deviceName;
    caps.type = device_type(basics.deviceType);
    caps.vendor_id = basics.vendorID;
    caps.device_id = basics.deviceID;
    caps.api_version = basics.apiVersion;
    std::memcpy(out.cache_uuid.data(), basics.pipelineCacheUUID, VK_UUID_SIZE);
    VkPhysicalDeviceMemoryProperties memory{};
    instance.vk.vkGetPhysicalDeviceMemoryProperties(out.handle, &memory);
    for (uint32_t i = 0; i < memory.memoryHeapCount; ++i)
        if (memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) caps.memory_bytes = std::max(caps.memory_bytes, memory.memoryHeaps[i].size);
    out.limits = basics.limits;
    if (!pick_queue(instance, out)) caps.missing.emplace_back("a queue for compute");
}

// What devices are taken not to have.
struct Mask {
    bool pipeline = false, query = false, raster = false, draw_count = false;
};

// PARHELION_MASK, a list of `pipeline`, `query`, `raster` and `draw_count`: for tests. Throws Error for another word.
Mask mask_of_environment() {
    Mask mask;
    const char* environment = std::getenv("PARHELION_MASK");
    for (std::string_view rest = environment ? environment : ""; !rest.empty();) {
        const std::string_view word = rest.substr(0, rest.find(','));
        rest.remove_prefix(std::min(rest.size(), word.size() + 1));
        if (word == "pipeline") mask.pipeline = true;
        else if (word == "query") mask.query = true;
        else if (word == "raster") mask.raster = true;
        else if (word == "draw_count") mask.draw_count = true;
        else throw Error(ErrorCode::Usage, fmt::format("'{}' cannot be masked", escape_name(word)), "PARHELION_MASK", "use some of pipeline,query,raster,draw_count");
    }
    return mask;
}

// Which of the two ray tracing ways is there, with extension and feature. Also picks the extensions to enable.
void pick_ray_tracing(const FeatureChain& has, const std::vector<std::string>& available, PhysicalDevice& out) {
    DeviceCaps& caps = out.caps;
    caps.ray_pipeline = has.pipeline.rayTracingPipeline && has.accel.accelerationStructure;
    caps.ray_query = has.query.rayQuery && has.accel.accelerationStructure;
    if (caps.ray_pipeline || caps.ray_query) {
        out.extensions.emplace_back(VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME);
        out.extensions.emplace_back(VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME);
        out.enabled.accel.accelerationStructure = VK_TRUE;
    }
    if (caps.ray_pipeline) {
        out.extensions.emplace_back(VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME);
        out.enabled.pipeline.rayTracingPipeline = VK_TRUE;
        out.trace_indirect = has.pipeline.rayTracingPipelineTraceRaysIndirect;
        out.enabled.pipeline.rayTracingPipelineTraceRaysIndirect = has.pipeline.rayTracingPipelineTraceRaysIndirect;
    }
    if (caps.ray_query) {
        out.extensions.emplace_back(VK_KHR_RAY_QUERY_EXTENSION_NAME);
        out.enabled.query.rayQuery = VK_TRUE;
    }
    if (contains(available, "VK_KHR_portability_subset")) out.extensions.emplace_back("VK_KHR_portability_subset");
}

}  // namespace

void use_queue_family(const Instance& instance, uint32_t family, PhysicalDevice& out) {
    const std::vector<VkQueueFamilyProperties> families = queue_families(instance, out.handle);
    PARHELION_CHECK(family < families.size() && (families[family].queueFlags & VK_QUEUE_COMPUTE_BIT), "queue family {} of {} does not compute", family, out.caps.name);
    out.queue_family = family;
    out.queue_has_graphics = (families[family].queueFlags & VK_QUEUE_GRAPHICS_BIT) != 0;
    out.timestamp_bits = families[family].timestampValidBits;
    out.caps.timestamp_period_ns = out.timestamp_bits != 0 ? out.limits.timestampPeriod : 0;
}

void FeatureChain::link(bool with_pipeline, bool with_query) {
    core.pNext = &v11;
    v11.pNext = &v12;
    v12.pNext = &v13;
    v13.pNext = accel.pNext = pipeline.pNext = query.pNext = nullptr;
    void** end = &v13.pNext;
    const auto add = [&](auto& part) { *end = &part, end = &part.pNext; };
    if (with_pipeline || with_query) add(accel);
    if (with_pipeline) add(pipeline);
    if (with_query) add(query);
}

std::vector<std::string> device_requirements() {
    std::vector<std::string> needed = {"Vulkan 1.3", "a queue for compute", VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME};
    FeatureChain enabled;
    pick_features({}, enabled, needed);  // a device without anything lacks all that is needed
    return needed;
}

PhysicalDevice inspect(const Instance& instance, VkPhysicalDevice handle, uint32_t index, bool mask_ray_tracing, bool windows) {
    PhysicalDevice out;
    out.handle = handle;
    out.caps.index = index;
    note_basics(instance, out);
    DeviceCaps& caps = out.caps;
    if (caps.api_version < VK_API_VERSION_1_3) {
        caps.missing.push_back(fmt::format("Vulkan 1.3 (it has {}.{})", VK_API_VERSION_MAJOR(caps.api_version), VK_API_VERSION_MINOR(caps.api_version)));
        return out;
    }
    const std::vector<std::string> available = device_extension_names(instance, handle);
    const bool push = contains(available, VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
    if (push) out.extensions.emplace_back(VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
    else caps.missing.emplace_back(VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
    if (windows && contains(available, VK_KHR_SWAPCHAIN_EXTENSION_NAME)) out.extensions.emplace_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
    else if (windows) caps.missing.emplace_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
    Mask mask = mask_of_environment();
    if (mask_ray_tracing) mask.pipeline = mask.query = true;
    const bool accel = contains(available, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME) && contains(available, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME);
    FeatureChain has;
    has.link(accel && !mask.pipeline && contains(available, VK_KHR_RAY_TRACING_PIPELINE_EXTENSION_NAME),
             accel && !mask.query && contains(available, VK_KHR_RAY_QUERY_EXTENSION_NAME));
    instance.vk.vkGetPhysicalDeviceFeatures2(handle, &has.core);
    pick_features(has, out.enabled, caps.missing);
    pick_ray_tracing(has, available, out);
    caps.block_compression = has.core.features.textureCompressionBC;
    caps.raster = !mask.raster && out.queue_has_graphics && has.v13.dynamicRendering && has.core.features.multiDrawIndirect && has.core.features.drawIndirectFirstInstance;
    caps.draw_indirect_count = !mask.draw_count && caps.raster && has.v12.drawIndirectCount;
    caps.buffer_int64_atomics = has.v12.shaderBufferInt64Atomics;
    caps.shader_float64 = has.core.features.shaderFloat64;
    Properties properties(push, caps.ray_pipeline || caps.ray_query, caps.ray_pipeline);
    instance.vk.vkGetPhysicalDeviceProperties2(handle, &properties.core);
    note_limits(properties, out);
    return out;
}

std::vector<std::string> device_extensions(VkInstance instance, VkPhysicalDevice physical_device) {
    return inspect(*borrow_instance(instance, nullptr), physical_device, 0, false).extensions;
}

std::shared_ptr<const void> device_features(VkInstance instance, VkPhysicalDevice physical_device) {
    PhysicalDevice physical = inspect(*borrow_instance(instance, nullptr), physical_device, 0, false);
    const auto chain = std::make_shared<FeatureChain>(physical.enabled);
    chain->link(physical.caps.ray_pipeline, physical.caps.ray_query);
    return {chain, &chain->core};
}

std::vector<DeviceCaps> enumerate_devices() {
    std::vector<DeviceCaps> devices;
    try {
        const std::shared_ptr<Instance> instance = create_instance(false);
        for (const VkPhysicalDevice handle : instance->physical_devices())
            devices.push_back(inspect(*instance, handle, static_cast<uint32_t>(devices.size()), false).caps);
    } catch (const Error& error) {
        if (error.code != ErrorCode::MissingFeature) throw;
    }
    return devices;
}

}  // namespace parhelion::gpu
