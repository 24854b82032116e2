// Names of Vulkan's results, and the one way from a failed call to an Error.
#include "gpu/internal.h"

namespace parhelion::gpu {

std::string_view result_name(VkResult result) {
#define PARHELION_RESULT(name) \
    case name: return #name;
    switch (result) {
        PARHELION_RESULT(VK_SUCCESS)
        PARHELION_RESULT(VK_NOT_READY)
        PARHELION_RESULT(VK_TIMEOUT)
        PARHELION_RESULT(VK_INCOMPLETE)
        PARHELION_RESULT(VK_ERROR_OUT_OF_HOST_MEMORY)
        PARHELION_RESULT(VK_ERROR_OUT_OF_DEVICE_MEMORY)
        PARHELION_RESULT(VK_ERROR_INITIALIZATION_FAILED)
        PARHELION_RESULT(VK_ERROR_DEVICE_LOST)
        PARHELION_RESULT(VK_ERROR_MEMORY_MAP_FAILED)
        PARHELION_RESULT(VK_ERROR_LAYER_NOT_PRESENT)
        PARHELION_RESULT(VK_ERROR_EXTENSION_NOT_PRESENT)
        PARHELION_RESULT(VK_ERROR_FEATURE_NOT_PRESENT)
        PARHELION_RESULT(VK_ERROR_INCOMPATIBLE_DRIVER)
        PARHELION_RESULT(VK_ERROR_TOO_MANY_OBJECTS)
        PARHELION_RESULT(VK_ERROR_FORMAT_NOT_SUPPORTED)
        PARHELION_RESULT(VK_ERROR_FRAGMENTED_POOL)
        PARHELION_RESULT(VK_ERROR_OUT_OF_POOL_MEMORY)
        PARHELION_RESULT(VK_ERROR_INVALID_OPAQUE_CAPTURE_ADDRESS)
        PARHELION_RESULT(VK_PIPELINE_COMPILE_REQUIRED)
        PARHELION_RESULT(VK_ERROR_UNKNOWN)
        default: return "an unknown result";
    }
#undef PARHELION_RESULT
}

void check_result(VkResult result, const char* call, std::string_view where) {
    if (result == VK_SUCCESS) return;
    if (result == VK_ERROR_DEVICE_LOST) throw DeviceLost("the device was lost", std::string(where));
    // "vk.vkCreateImage(device, ...)" -> "vkCreateImage"
    std::string_view name = call;
    name = name.substr(0, name.find('('));
    if (const size_t dot = name.find_last_of(".>:"); dot != std::string_view::npos) name.remove_prefix(dot + 1);
    throw Error(ErrorCode::Failed, fmt::format("{} failed with {}", name, result_name(result)), std::string(where));
}

}  // namespace parhelion::gpu
