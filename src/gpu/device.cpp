// Devices: opened by us or borrowed, with everything that belongs to one of them.
#include <algorithm>
#include <cstdlib>

#include "base/log.h"
#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

VkDevice create_device(const Instance& instance, PhysicalDevice& physical) {
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = physical.queue_family;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    std::vector<const char*> extensions;
    for (const std::string& name : physical.extensions) extensions.push_back(name.c_str());
    physical.enabled.link(physical.caps.ray_pipeline, physical.caps.ray_query);
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.pNext = &physical.enabled.core;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    VkDevice device = nullptr;
    PARHELION_VK(physical.caps.name, instance.vk.vkCreateDevice(physical.handle, &info, nullptr, &device));
    return device;
}

}  // namespace

Device::Device() : impl_(std::make_unique<Impl>()) {}

std::shared_ptr<Device> Device::open(const DeviceRequest& request) {
    const char* environment = std::getenv("PARHELION_DEVICE");
    const std::string selector = !request.selector.empty() ? request.selector : environment ? environment : "";
    const std::shared_ptr<Instance> instance = create_instance(request.validate, request.window_extensions);
    std::vector<PhysicalDevice> physicals;
    std::vector<DeviceCaps> caps;
    for (const VkPhysicalDevice handle : instance->physical_devices()) {
        physicals.push_back(inspect(*instance, handle, static_cast<uint32_t>(physicals.size()), request.mask_ray_tracing, !request.window_extensions.empty()));
        caps.push_back(physicals.back().caps);
    }
    std::shared_ptr<Device> device(new Device);
    Impl& impl = device->impl();
    impl.instance = instance;
    impl.physical = physicals[choose(caps, selector, request.selector.empty() ? "PARHELION_DEVICE" : "--device")];
    device->caps_ = impl.physical.caps;
    impl.device = create_device(*instance, impl.physical);
    impl.owned = true;
    impl.start();
    impl.vk.vkGetDeviceQueue(impl.device, impl.physical.queue_family, 0, &impl.queue);
    log(LogLevel::Debug, "device {}: {}", impl.name(), impl.physical.caps.driver);
    return device;
}

std::shared_ptr<Device> Device::borrow(const BorrowedDevice& handles) {
    PARHELION_CHECK(handles.instance && handles.physical_device && handles.device && handles.queue, "a borrowed device needs instance, physical device, device and queue");
    std::shared_ptr<Device> device(new Device);
    Impl& impl = device->impl();
    impl.instance = borrow_instance(handles.instance, reinterpret_cast<PFN_vkGetInstanceProcAddr>(handles.get_instance_proc_addr));
    const std::vector<VkPhysicalDevice> all = impl.instance->physical_devices();
    const auto index = std::find(all.begin(), all.end(), handles.physical_device) - all.begin();
    impl.physical = inspect(*impl.instance, handles.physical_device, static_cast<uint32_t>(index), false);
    DeviceCaps& caps = impl.physical.caps;
    use_queue_family(*impl.instance, handles.queue_family, impl.physical);
    caps.ray_pipeline = caps.ray_pipeline && handles.enabled_ray_pipeline;
    caps.ray_query = caps.ray_query && handles.enabled_ray_query;
    caps.block_compression = caps.block_compression && handles.enabled_block_compression;
    caps.raster = caps.raster && handles.enabled_raster && impl.physical.queue_has_graphics;
    caps.draw_indirect_count = caps.raster && caps.draw_indirect_count && handles.enabled_draw_indirect_count;
    caps.buffer_int64_atomics = caps.buffer_int64_atomics && handles.enabled_buffer_int64_atomics;
    choose_best({caps});  // throws with what is missing
    device->caps_ = caps;
    impl.device = handles.device;
    impl.queue = handles.queue;
    impl.start();
    return device;
}

Device::~Device() {
    if (impl_->device) impl_->destroy(impl_->owned);
}

void Device::wait_idle() { PARHELION_VK(caps_.name, impl_->vk.vkDeviceWaitIdle(impl_->device)); }

std::vector<std::string> Device::validation_messages() const {
    const std::lock_guard lock(impl_->instance->mutex);
    return impl_->instance->messages;
}
uint64_t Device::validation_message_count() const { return validation_messages().size(); }

std::vector<MemoryUse> Device::memory_use() const {
    const std::lock_guard lock(impl_->mutex);
    std::vector<MemoryUse> out;
    for (const auto& [group, bytes] : impl_->memory_use)
        if (bytes != 0) out.push_back({group, bytes});
    return out;
}

uint64_t Device::peak_memory_bytes() const {
    const std::lock_guard lock(impl_->mutex);
    return impl_->memory_peak;
}

void Device::Impl::start() {
#define PARHELION_LOAD(function) vk.function = reinterpret_cast<PFN_##function>(instance->vk.vkGetDeviceProcAddr(device, #function));
    PARHELION_DEVICE_FUNCTIONS(PARHELION_LOAD)
#undef PARHELION_LOAD
    PARHELION_CHECK(vk.vkQueueSubmit2 && vk.vkCmdPushDescriptorSetKHR, "device {} was made without Vulkan 1.3 or {}", name(), VK_KHR_PUSH_DESCRIPTOR_EXTENSION_NAME);
    has_accel = physical.caps.ray_pipeline || physical.caps.ray_query;
    memory = std::make_unique<MemoryBlocks>(*this);
    VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
    type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
    const VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, &type, 0};
    PARHELION_VK(name(), vk.vkCreateSemaphore(device, &info, nullptr, &timeline));
    make_scene_layout();
    load_pipeline_cache();
}

// Called once, by ~Device: every resource holds its device, so none is left but the device's own. Also cleans up a start()
// that threw half-way.
void Device::Impl::destroy(bool wait_for_all) noexcept {
    if (wait_for_all && vk.vkDeviceWaitIdle) {
        vk.vkDeviceWaitIdle(device);
    } else if (timeline) {
        VkSemaphoreWaitInfo wait{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
        wait.semaphoreCount = 1;
        wait.pSemaphores = &timeline;
        wait.pValues = &submitted;
        vk.vkWaitSemaphores(device, &wait, UINT64_MAX);
    }
    if (pipeline_cache) save_pipeline_cache();
    for (auto& [key, program] : programs) program->destroy(*this);
    for (auto& [desc, sampler] : samplers) vk.vkDestroySampler(device, sampler->handle, nullptr);
    for (const auto& [ticket, slot] : busy_slots) vk.vkDestroyCommandPool(device, slot.pool, nullptr);
    for (const CommandSlot& slot : free_slots) vk.vkDestroyCommandPool(device, slot.pool, nullptr);
    if (scene_layout) vk.vkDestroyDescriptorSetLayout(device, scene_layout, nullptr);
    if (pipeline_cache) vk.vkDestroyPipelineCache(device, pipeline_cache, nullptr);
    if (timeline) vk.vkDestroySemaphore(device, timeline, nullptr);
    memory.reset();
    if (owned && vk.vkDestroyDevice) vk.vkDestroyDevice(device, nullptr);
}

void Device::Impl::set_name(VkObjectType type, uint64_t handle, std::string_view text) const {
    if (!instance->debug_utils || !vk.vkSetDebugUtilsObjectNameEXT) return;
    const std::string terminated(text);
    VkDebugUtilsObjectNameInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
    info.objectType = type;
    info.objectHandle = handle;
    info.pObjectName = terminated.c_str();
    vk.vkSetDebugUtilsObjectNameEXT(device, &info);
}

void Device::Impl::account(std::string_view resource_name, int64_t bytes) {
    const std::string_view group = resource_name.substr(0, resource_name.find('/'));
    const std::lock_guard lock(mutex);
    const auto it = memory_use.try_emplace(std::string(group), 0).first;
    it->second = static_cast<uint64_t>(static_cast<int64_t>(it->second) + bytes);
    memory_now = static_cast<uint64_t>(static_cast<int64_t>(memory_now) + bytes);
    memory_peak = std::max(memory_peak, memory_now);
}

}  // namespace parhelion::gpu
