// Parhelion inside a program that has its own Vulkan device and its own loop: one edit a frame, an image out.
//     embed OUT.png [FRAMES]
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include <vulkan/vulkan.h>

#include "image/encode.h"
#include "renderers/renderer.h"
#include "scene/builtin.h"
#include "scene/camera.h"

namespace {

constexpr uint32_t kWidth = 160, kHeight = 160;

void check(VkResult result) {
    if (result != VK_SUCCESS) throw std::runtime_error("Vulkan call failed: " + std::to_string(result));
}

// The host's own Vulkan: an instance, the first device, one queue, one command buffer.
struct Host {
    VkInstance instance{};
    VkPhysicalDevice physical{};
    VkDevice device{};
    VkQueue queue{};
    VkCommandPool pool{};
    VkCommandBuffer commands{};
    VkFence fence{};

    Host() {
        const VkApplicationInfo app{.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .pApplicationName = "embed", .apiVersion = VK_API_VERSION_1_3};
        const VkInstanceCreateInfo instance_info{.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &app};
        check(vkCreateInstance(&instance_info, nullptr, &instance));
        uint32_t count = 1;
        if (vkEnumeratePhysicalDevices(instance, &count, &physical) < 0 || count == 0) throw std::runtime_error("no Vulkan device");
        // Parhelion says which extensions and features it needs.
        const std::vector<std::string> names = parhelion::gpu::device_extensions(instance, physical);
        std::vector<const char*> extensions;
        for (const std::string& name : names) extensions.push_back(name.c_str());
        const std::shared_ptr<const void> features = parhelion::gpu::device_features(instance, physical);
        const float priority = 1.0f;
        const VkDeviceQueueCreateInfo queue_info{.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
        const VkDeviceCreateInfo device_info{.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .pNext = features.get(), .queueCreateInfoCount = 1, .pQueueCreateInfos = &queue_info,
                                             .enabledExtensionCount = static_cast<uint32_t>(extensions.size()), .ppEnabledExtensionNames = extensions.data()};
        check(vkCreateDevice(physical, &device_info, nullptr, &device));
        vkGetDeviceQueue(device, 0, 0, &queue);
        const VkCommandPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT};
        check(vkCreateCommandPool(device, &pool_info, nullptr, &pool));
        const VkCommandBufferAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = pool, .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY, .commandBufferCount = 1};
        check(vkAllocateCommandBuffers(device, &allocate, &commands));
        const VkFenceCreateInfo fence_info{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        check(vkCreateFence(device, &fence_info, nullptr, &fence));
    }
    ~Host() {
        vkDestroyFence(device, fence, nullptr);
        vkDestroyCommandPool(device, pool, nullptr);
        vkDestroyDevice(device, nullptr);
        vkDestroyInstance(instance, nullptr);
    }

    template <class Record>
    void frame(Record record) {
        const VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        check(vkBeginCommandBuffer(commands, &begin));
        record();
        check(vkEndCommandBuffer(commands));
        const VkSubmitInfo submit{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
        check(vkQueueSubmit(queue, 1, &submit, fence));
        check(vkWaitForFences(device, 1, &fence, VK_TRUE, UINT64_MAX));
        check(vkResetFences(device, 1, &fence));
    }
};

void run(const char* out, int frames) {
    using namespace parhelion;
    Host host;
    const gpu::DevicePtr device = gpu::Device::borrow({.instance = host.instance, .physical_device = host.physical, .device = host.device, .queue = host.queue, .queue_family = 0});
    LoadedScene loaded = make_builtin("builtin:cornell");
    const Handle<Camera> camera_handle = (*loaded.scene.cameras().begin()).handle;
    const CameraView camera = view_of(loaded.scene.get(camera_handle), 1.0f);
    const glm::vec2 half = camera.image_half_extents(1.0f);
    View view(device, {.width = kWidth, .height = kHeight, .camera = {.position_ws = camera.position, .right_ws = camera.right * half.x, .up_ws = camera.up * half.y, .forward_ws = camera.forward}});
    Renderer renderer(device, {.samples_per_frame = 16, .exposure_ev100 = -1.4f});
    renderer.sync(loaded.scene, {});
    const gpu::Image ldr(device, "embed/ldr", {.format = gpu::Format::Rgba8Unorm, .extent = {kWidth, kHeight}});
    for (int i = 0; i < frames; ++i) {
        if (!loaded.scripted_edits.empty()) renderer.sync(loaded.scene, loaded.scene.apply(loaded.scripted_edits[0].apply(loaded.scene, i / 30.0)));
        uint64_t serial = 0;
        host.frame([&] { serial = renderer.record(host.commands, view, ldr); });
        renderer.retire(serial);
    }
    // Any way of the host's own would do to look at the image; this one is short.
    Frame readback(device);
    const gpu::Buffer pixels = readback.read_back(ldr);
    readback.run();
    image::Picture8 picture{.width = kWidth, .height = kHeight};
    const std::span<const uint8_t> rgba = pixels.mapped_as<const uint8_t>();
    for (size_t p = 0; p < size_t(kWidth) * kHeight; ++p) picture.rgb.insert(picture.rgb.end(), &rgba[4 * p], &rgba[4 * p] + 3);
    image::write_png(out, picture);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) return std::fprintf(stderr, "usage: embed OUT.png [FRAMES]\n"), 2;
    try {
        run(argv[1], argc > 2 ? std::atoi(argv[2]) : 8);
    } catch (const std::exception& error) {
        return std::fprintf(stderr, "embed: %s\n", error.what()), 1;
    }
}
