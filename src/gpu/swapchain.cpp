// Windows: surface, swapchain, and the semaphores between them and the device's queue.
#include "gpu/swapchain.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "gpu/swapchain_data.h"

namespace parhelion::gpu {

namespace {

template <class T, class Enumerate>
std::vector<T> enumerate(const Enumerate& call) {
    uint32_t count = 0;
    call(&count, nullptr);
    std::vector<T> out(count);
    call(&count, out.data());
    out.resize(count);
    return out;
}

bool can_blit_to(const Device::Impl& device, VkFormat format) {
    VkFormatProperties2 properties{VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_2};
    device.instance->vk.vkGetPhysicalDeviceFormatProperties2(device.physical.handle, format, &properties);
    return (properties.formatProperties.optimalTilingFeatures & VK_FORMAT_FEATURE_BLIT_DST_BIT) != 0;
}

Extent extent_of(const VkExtent2D& extent) { return {extent.width, extent.height, 1}; }

[[noreturn]] void fail_window(const Device::Impl& device, const std::string& what) {
    throw Error(ErrorCode::MissingFeature, what, escape_name(device.name()), "choose another --device, or render without a window: parhelion render");
}

}  // namespace

Swapchain::Swapchain(const DevicePtr& device, const MakeSurface& make_surface, PresentMode mode) : impl_(std::make_unique<Impl>()) {
    impl_->device = device;
    impl_->mode = mode;
    Device::Impl& gpu = device->impl();
    const InstanceFunctions& vk = gpu.instance->vk;
    if (!gpu.vk.vkCreateSwapchainKHR) fail_window(gpu, "cannot show pictures in windows");
    impl_->surface = make_surface(gpu.instance->handle);
    if (!impl_->surface) fail_window(gpu, "the window has no surface for Vulkan");
    VkBool32 supported = VK_FALSE;
    PARHELION_VK(gpu.name(), vk.vkGetPhysicalDeviceSurfaceSupportKHR(gpu.physical.handle, gpu.physical.queue_family, impl_->surface, &supported));
    if (!supported) fail_window(gpu, "cannot show pictures on this display");
    impl_->choose_format();
}

// Values that are written already have the display's transfer function, so the images must not apply one of their own.
void Swapchain::Impl::choose_format() {
    Device::Impl& gpu = device->impl();
    const auto formats = enumerate<VkSurfaceFormatKHR>(
        [&](uint32_t* count, VkSurfaceFormatKHR* out) { gpu.instance->vk.vkGetPhysicalDeviceSurfaceFormatsKHR(gpu.physical.handle, surface, count, out); });
    for (const VkFormat wanted : {VK_FORMAT_B8G8R8A8_UNORM, VK_FORMAT_R8G8B8A8_UNORM, VK_FORMAT_A8B8G8R8_UNORM_PACK32, VK_FORMAT_A2B10G10R10_UNORM_PACK32})
        for (const VkSurfaceFormatKHR& offered : formats)
            if (offered.format == wanted && offered.colorSpace == VK_COLOR_SPACE_SRGB_NONLINEAR_KHR && can_blit_to(gpu, wanted)) {
                format = wanted;
                return;
            }
    fail_window(gpu, "has no format for this display that pictures can be copied to");
}

Swapchain::~Swapchain() {
    if (impl_) impl_->destroy();
}

void Swapchain::Impl::destroy() noexcept {
    Device::Impl& gpu = device->impl();
    if (handle) gpu.vk.vkDeviceWaitIdle(gpu.device);
    destroy_images();
    if (handle) gpu.vk.vkDestroySwapchainKHR(gpu.device, handle, nullptr);
    if (surface) gpu.instance->vk.vkDestroySurfaceKHR(gpu.instance->handle, surface, nullptr);
}

void Swapchain::Impl::destroy_images() noexcept {
    Device::Impl& gpu = device->impl();
    for (const VkSemaphore semaphore : shown) gpu.vk.vkDestroySemaphore(gpu.device, semaphore, nullptr);
    for (const Taking& taking : takings) gpu.vk.vkDestroySemaphore(gpu.device, taking.semaphore, nullptr);
    shown.clear();
    takings.clear();
    images.clear();
    taken.reset();
}

VkPresentModeKHR Swapchain::Impl::present_mode() const {
    const Device::Impl& gpu = device->impl();
    const auto offered = enumerate<VkPresentModeKHR>(
        [&](uint32_t* count, VkPresentModeKHR* out) { gpu.instance->vk.vkGetPhysicalDeviceSurfacePresentModesKHR(gpu.physical.handle, surface, count, out); });
    const bool mailbox = mode == PresentMode::Mailbox && std::find(offered.begin(), offered.end(), VK_PRESENT_MODE_MAILBOX_KHR) != offered.end();
    return mailbox ? VK_PRESENT_MODE_MAILBOX_KHR : VK_PRESENT_MODE_FIFO_KHR;  // every display has FIFO
}

// False: the window has no size now.
bool Swapchain::Impl::make(uint32_t width, uint32_t height) {
    Device::Impl& gpu = device->impl();
    gpu.vk.vkDeviceWaitIdle(gpu.device);  // the old images may still be on their way to the display
    VkSurfaceCapabilitiesKHR can{};
    PARHELION_VK(gpu.name(), gpu.instance->vk.vkGetPhysicalDeviceSurfaceCapabilitiesKHR(gpu.physical.handle, surface, &can));
    // Some displays say how large the images must be, others take what the window says.
    const bool fixed = can.currentExtent.width != std::numeric_limits<uint32_t>::max();
    const VkExtent2D size = fixed ? can.currentExtent
                                  : VkExtent2D{std::clamp(width, can.minImageExtent.width, can.maxImageExtent.width),
                                               std::clamp(height, can.minImageExtent.height, can.maxImageExtent.height)};
    if (size.width == 0 || size.height == 0) return false;
    if (!(can.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT)) fail_window(gpu, "cannot copy pictures to this display");
    VkSwapchainCreateInfoKHR info{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
    info.surface = surface;
    info.minImageCount = can.maxImageCount == 0 ? std::max(3u, can.minImageCount + 1) : std::min(std::max(3u, can.minImageCount + 1), can.maxImageCount);
    info.imageFormat = format;
    info.imageColorSpace = VK_COLOR_SPACE_SRGB_NONLINEAR_KHR;
    info.imageExtent = size;
    info.imageArrayLayers = 1;
    info.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    info.preTransform = can.currentTransform;
    info.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
    if (!(can.supportedCompositeAlpha & info.compositeAlpha)) info.compositeAlpha = VK_COMPOSITE_ALPHA_INHERIT_BIT_KHR;
    info.presentMode = present_mode();
    info.clipped = VK_TRUE;
    info.oldSwapchain = handle;
    VkSwapchainKHR made = nullptr;
    PARHELION_VK(gpu.name(), gpu.vk.vkCreateSwapchainKHR(gpu.device, &info, nullptr, &made));
    destroy_images();
    if (handle) gpu.vk.vkDestroySwapchainKHR(gpu.device, handle, nullptr);
    handle = made;
    images = enumerate<VkImage>([&](uint32_t* count, VkImage* out) { gpu.vk.vkGetSwapchainImagesKHR(gpu.device, handle, count, out); });
    const VkSemaphoreCreateInfo create{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
    const auto make_semaphore = [&](VkSemaphore& out) { PARHELION_VK(gpu.name(), gpu.vk.vkCreateSemaphore(gpu.device, &create, nullptr, &out)); };
    for (size_t i = 0; i < images.size(); ++i) make_semaphore(shown.emplace_back());
    // One more than can be taken at a time: the one that is handed over has been waited for.
    for (size_t i = 0; i <= images.size(); ++i) make_semaphore(takings.emplace_back().semaphore);
    extent = size;
    asked = {width, height};
    stale = false;
    ++generation;
    return true;
}

bool Swapchain::acquire(uint32_t width, uint32_t height) {
    Impl& s = *impl_;
    if (s.taken) return true;
    if (width == 0 || height == 0) return false;
    Device::Impl& gpu = s.device->impl();
    constexpr int kTries = 3;  // a window that is being resized may change again at once
    for (int i = 0; i < kTries; ++i) {
        const bool same = s.handle && !s.stale && s.asked.width == width && s.asked.height == height;
        if (!same && !s.make(width, height)) return false;
        Impl::Taking& taking = s.takings[s.next_taking % s.takings.size()];
        if (taking.waited_by != 0 && !wait(s.device, taking.waited_by)) return false;
        constexpr uint64_t kTimeout = 100'000'000;  // ns
        uint32_t index = 0;
        const VkResult result = gpu.vk.vkAcquireNextImageKHR(gpu.device, s.handle, kTimeout, taking.semaphore, nullptr, &index);
        if (result == VK_TIMEOUT || result == VK_NOT_READY) return false;
        s.stale = result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR;
        if (result == VK_ERROR_OUT_OF_DATE_KHR) continue;
        if (result != VK_SUBOPTIMAL_KHR) check_result(result, "vkAcquireNextImageKHR", gpu.name());
        s.taken = index;
        return true;
    }
    return false;
}

Extent Swapchain::extent() const { return extent_of(impl_->extent); }
PresentMode Swapchain::mode() const { return impl_->mode; }
uint64_t Swapchain::generation() const { return impl_->generation; }
void Swapchain::set_mode(PresentMode mode) {
    if (mode == impl_->mode) return;
    impl_->mode = mode;
    impl_->stale = true;
}

// The submission waits for the display to let go of the image, and tells when it is filled.
std::pair<VkSemaphoreSubmitInfo, VkSemaphoreSubmitInfo> Swapchain::Impl::semaphores() const {
    PARHELION_CHECK(taken, "no image of the window has been taken");
    VkSemaphoreSubmitInfo wait{VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO}, signal = wait;
    wait.semaphore = takings[next_taking % takings.size()].semaphore;
    wait.stageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
    signal.semaphore = shown[*taken];
    signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    return {wait, signal};
}

void Swapchain::Impl::show(Ticket ticket) {
    Device::Impl& gpu = device->impl();
    takings[next_taking++ % takings.size()].waited_by = ticket;
    VkPresentInfoKHR info{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
    info.waitSemaphoreCount = 1;
    info.pWaitSemaphores = &shown[*taken];
    info.swapchainCount = 1;
    info.pSwapchains = &handle;
    info.pImageIndices = &*taken;
    const VkResult result = gpu.vk.vkQueuePresentKHR(gpu.queue, &info);
    taken.reset();
    if (result == VK_SUBOPTIMAL_KHR || result == VK_ERROR_OUT_OF_DATE_KHR) stale = true;
    else check_result(result, "vkQueuePresentKHR", gpu.name());
}

void CommandList::copy_to_window(const Image& from, const Swapchain& to) {
    const Swapchain::Impl& window = to.impl();
    PARHELION_CHECK(window.taken, "no image of the window has been taken");
    const VkImage image = window.images[*window.taken];
    const auto transition = [&](VkImageLayout before, VkImageLayout after, VkAccessFlags2 written, VkAccessFlags2 writes) {
        VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
        barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;  // where the submission waits for the display
        barrier.srcAccessMask = written;
        barrier.dstStageMask = writes != 0 ? VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT : VK_PIPELINE_STAGE_2_NONE;
        barrier.dstAccessMask = writes;
        barrier.oldLayout = before;
        barrier.newLayout = after;
        barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
        barrier.image = image;
        barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
        info.imageMemoryBarrierCount = 1;
        info.pImageMemoryBarriers = &barrier;
        impl_->vk().vkCmdPipelineBarrier2(impl_->buffer, &info);
    };
    transition(VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 0, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    impl_->blit(from, image, extent_of(window.extent), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
    transition(VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_PRESENT_SRC_KHR, VK_ACCESS_2_TRANSFER_WRITE_BIT, 0);
}

}  // namespace parhelion::gpu
