#pragma once
// The pictures of a window. The window library makes the surface through a function of the caller, so that nothing here knows one.
#include <functional>

#include "gpu/command_list.h"

namespace parhelion::gpu {

enum class PresentMode : uint32_t {
    Fifo,     // waits for the display: nothing tears
    Mailbox,  // never waits, the newest picture is shown; Fifo where the display does not have it
};

// Opened with DeviceRequest::window_extensions. Used by one thread. A frame of it: acquire(), a command list with
// CommandList::copy_to_window(), submit() with this window, which also shows the picture.
class Swapchain {
public:
    // Makes the surface of the window for an instance; null: it cannot. The surface is destroyed with the Swapchain.
    using MakeSurface = std::function<VkSurfaceKHR(VkInstance)>;

    // Throws MissingFeature if the device cannot show pictures in this window.
    Swapchain(const DevicePtr& device, const MakeSurface& make_surface, PresentMode mode);
    ~Swapchain();
    Swapchain(const Swapchain&) = delete;
    Swapchain& operator=(const Swapchain&) = delete;

    // Takes the image that the next picture goes to. Makes the images anew when the window has another size than they (`width` and
    // `height`: pixels of its framebuffer) or the display asks for it. False: there is nothing to draw to now (a minimised window, or no
    // image has become free within a tenth of a second). Taken and not submitted, the same image is taken again.
    bool acquire(uint32_t width, uint32_t height);
    Extent extent() const;  // of the image taken
    PresentMode mode() const;
    void set_mode(PresentMode mode);  // from the next acquire() on
    uint64_t generation() const;      // how often the images have been made

    struct Impl;
    Impl& impl() const { return *impl_; }

private:
    std::unique_ptr<Impl> impl_;
};

}  // namespace parhelion::gpu
