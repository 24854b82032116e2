#pragma once
// What a window's pictures are made of, for those files of src/gpu that fill and submit them.
#include <optional>

#include "gpu/internal.h"
#include "gpu/swapchain.h"

namespace parhelion::gpu {

struct Swapchain::Impl {
    // Signalled by the display when an image is free; may be used again once the submission that waited for it is done.
    struct Taking {
        VkSemaphore semaphore = nullptr;
        Ticket waited_by = 0;
    };
    DevicePtr device;
    PresentMode mode = PresentMode::Fifo;
    VkSurfaceKHR surface = nullptr;
    VkSwapchainKHR handle = nullptr;
    VkFormat format = VK_FORMAT_UNDEFINED;
    VkExtent2D extent{}, asked{};
    std::vector<VkImage> images;
    std::vector<VkSemaphore> shown;  // one for each image: free again when that image is
    std::vector<Taking> takings;
    size_t next_taking = 0;
    std::optional<uint32_t> taken;
    bool stale = false;
    uint64_t generation = 0;

    ~Impl() = default;
    void choose_format();
    bool make(uint32_t width, uint32_t height);
    VkPresentModeKHR present_mode() const;
    void destroy_images() noexcept;
    void destroy() noexcept;
    std::pair<VkSemaphoreSubmitInfo, VkSemaphoreSubmitInfo> semaphores() const;
    void show(Ticket ticket);  // with the queue to itself
};

}  // namespace parhelion::gpu
