// Submission on the device's one queue. A timeline semaphore counts submissions; command pools are used again when theirs is done.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "gpu/internal.h"
#include "gpu/swapchain_data.h"

namespace parhelion::gpu {

Ticket Device::Impl::completed() {
    uint64_t value = 0;
    PARHELION_VK(name(), vk.vkGetSemaphoreCounterValue(device, timeline, &value));
    // Drivers may report a lost device by the largest value.
    if (value > submitted) check_result(VK_ERROR_DEVICE_LOST, "vkGetSemaphoreCounterValue", name());
    return value;
}

CommandSlot Device::Impl::take_slot() {
    const std::lock_guard lock(mutex);
    if (!busy_slots.empty()) {
        const Ticket done = completed();
        std::erase_if(busy_slots, [&](const auto& busy) {
            if (busy.first > done) return false;
            free_slots.push_back(busy.second);
            return true;
        });
    }
    if (!free_slots.empty()) {
        const CommandSlot slot = free_slots.back();
        PARHELION_VK(name(), vk.vkResetCommandPool(device, slot.pool, 0));
        free_slots.pop_back();
        return slot;
    }
    CommandSlot slot;
    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
    pool.queueFamilyIndex = physical.queue_family;
    PARHELION_VK(name(), vk.vkCreateCommandPool(device, &pool, nullptr, &slot.pool));
    VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = slot.pool;
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    const VkResult result = vk.vkAllocateCommandBuffers(device, &allocate, &slot.buffer);
    if (result != VK_SUCCESS) vk.vkDestroyCommandPool(device, slot.pool, nullptr);
    check_result(result, "vkAllocateCommandBuffers", name());
    return slot;
}

Ticket submit(const DevicePtr& device, CommandList&& commands, Swapchain* window) {
    Device::Impl& impl = device->impl();
    CommandList::Impl& list = commands.impl();
    PARHELION_CHECK(list.own, "a command list of the host program is submitted by the host program");
    // What mapped buffers received is visible to the host once the ticket is done.
    list.memory_barrier(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
    PARHELION_VK(impl.name(), impl.vk.vkEndCommandBuffer(list.buffer));

    const std::lock_guard lock(impl.mutex);
    const Ticket ticket = impl.submitted + 1;
    VkCommandBufferSubmitInfo buffer{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
    buffer.commandBuffer = list.buffer;
    VkSemaphoreSubmitInfo signals[2]{}, wait{};
    signals[0].sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
    signals[0].semaphore = impl.timeline;
    signals[0].value = ticket;
    signals[0].stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    if (window) std::tie(wait, signals[1]) = window->impl().semaphores();
    VkSubmitInfo2 info{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
    info.commandBufferInfoCount = 1;
    info.pCommandBufferInfos = &buffer;
    info.waitSemaphoreInfoCount = window ? 1 : 0;
    info.pWaitSemaphoreInfos = &wait;
    info.signalSemaphoreInfoCount = window ? 2 : 1;
    info.pSignalSemaphoreInfos = signals;
    PARHELION_VK(impl.name(), impl.vk.vkQueueSubmit2(impl.queue, 1, &info, nullptr));
    impl.submitted = ticket;
    impl.busy_slots.emplace_back(ticket, list.slot);
    list.slot = {};
    list.first_layouts.clear();
    if (window) window->impl().show(ticket);
    return ticket;
}

bool is_done(const DevicePtr& device, Ticket ticket) {
    Device::Impl& impl = device->impl();
    const std::lock_guard lock(impl.mutex);
    return impl.completed() >= ticket;
}

bool wait(const DevicePtr& device, Ticket ticket, double timeout_seconds) {
    Device::Impl& impl = device->impl();
    VkSemaphoreWaitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
    info.semaphoreCount = 1;
    info.pSemaphores = &impl.timeline;
    info.pValues = &ticket;
    const double nanoseconds = std::clamp(timeout_seconds, 0.0, 1e9) * 1e9;
    const VkResult result = impl.vk.vkWaitSemaphores(impl.device, &info, static_cast<uint64_t>(nanoseconds));
    if (result == VK_TIMEOUT) return false;
    check_result(result, "vkWaitSemaphores", impl.name());
    return true;
}

}  // namespace parhelion::gpu
