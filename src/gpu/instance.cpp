// The Vulkan loader and instances: one instance per device of ours, with the validation layers if asked for.
#include <algorithm>
#include <cstring>

#include "base/log.h"
#include "base/platform.h"
#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

const std::string kNoLoaderHint = "install the Vulkan loader (libvulkan1) and a driver; mesa-vulkan-drivers 25 or newer runs on any CPU";

template <class Function>
Function instance_function(PFN_vkGetInstanceProcAddr get, VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(get(instance, name));
}

void load_functions(Instance& instance, PFN_vkGetInstanceProcAddr get) {
    instance.vk.vkGetInstanceProcAddr = get;
#define PARHELION_LOAD(name) instance.vk.name = instance_function<PFN_##name>(get, instance.handle, #name);
    PARHELION_INSTANCE_FUNCTIONS(PARHELION_LOAD)
#undef PARHELION_LOAD
    PARHELION_CHECK(instance.vk.vkGetPhysicalDeviceFeatures2 && instance.vk.vkGetDeviceProcAddr, "the instance was not made for Vulkan 1.1 or newer");
}

VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity, VkDebugUtilsMessageTypeFlagsEXT,
                                          const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    auto& instance = *static_cast<Instance*>(user);
    const std::string text = data->pMessage ? data->pMessage : "";
    log(LogLevel::Error, "validation {}: {}", severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT ? "error" : "warning", text);
    const std::lock_guard lock(instance.mutex);
    instance.messages.push_back(text);
    return VK_FALSE;
}

VkDebugUtilsMessengerCreateInfoEXT messenger_info(Instance& instance) {
    VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    // Not GENERAL: there the loader speaks about drivers and layers that have nothing to do with us.
    info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    info.pfnUserCallback = on_message;
    info.pUserData = &instance;
    return info;
}

std::vector<std::string> instance_extensions(PFN_vkGetInstanceProcAddr get, const char* layer) {
    const auto enumerate = instance_function<PFN_vkEnumerateInstanceExtensionProperties>(get, nullptr, "vkEnumerateInstanceExtensionProperties");
    uint32_t count = 0;
    if (enumerate(layer, &count, nullptr) != VK_SUCCESS) return {};
    std::vector<VkExtensionProperties> properties(count);
    if (enumerate(layer, &count, properties.data()) < VK_SUCCESS) return {};
    std::vector<std::string> names;
    for (uint32_t i = 0; i < count; ++i) names.emplace_back(properties[i].extensionName);
    return names;
}

bool has_layer(PFN_vkGetInstanceProcAddr get) {
    const auto enumerate = instance_function<PFN_vkEnumerateInstanceLayerProperties>(get, nullptr, "vkEnumerateInstanceLayerProperties");
    uint32_t count = 0;
    if (enumerate(&count, nullptr) != VK_SUCCESS) return false;
    std::vector<VkLayerProperties> layers(count);
    if (enumerate(&count, layers.data()) < VK_SUCCESS) return false;
    return std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties& l) { return std::strcmp(l.layerName, kValidationLayer) == 0; });
}

void check_loader_version(PFN_vkGetInstanceProcAddr get) {
    const auto version_of = instance_function<PFN_vkEnumerateInstanceVersion>(get, nullptr, "vkEnumerateInstanceVersion");
    uint32_t version = VK_API_VERSION_1_0;
    if (version_of) version_of(&version);
    if (version < VK_API_VERSION_1_3)
        throw Error(ErrorCode::MissingFeature, fmt::format("the Vulkan loader is version {}.{}, 1.3 is needed", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version)),
                    "Vulkan", "install a newer Vulkan loader (libvulkan1)");
}

}  // namespace

PFN_vkGetInstanceProcAddr system_loader() {
    static const PFN_vkGetInstanceProcAddr loader = []() -> PFN_vkGetInstanceProcAddr {
        for (const char* name : {"libvulkan.so.1", "libvulkan.so", "vulkan-1.dll", "libvulkan.1.dylib"})
            if (void* library = platform::load_library(name))
                return reinterpret_cast<PFN_vkGetInstanceProcAddr>(platform::library_symbol(library, "vkGetInstanceProcAddr"));
        return nullptr;
    }();
    return loader;
}

std::shared_ptr<Instance> create_instance(bool validate, std::span<const std::string> more_extensions) {
    const PFN_vkGetInstanceProcAddr get = system_loader();
    if (!get) throw Error(ErrorCode::MissingFeature, "this machine has no Vulkan loader", "Vulkan", kNoLoaderHint);
    check_loader_version(get);
    if (validate && !has_layer(get))
        throw Error(ErrorCode::MissingFeature, fmt::format("the Vulkan layer {} is not installed", kValidationLayer), "--validate", "install vulkan-validationlayers");

    auto instance = std::make_shared<Instance>();
    std::vector<const char*> extensions, layers;
    const std::vector<std::string> available = instance_extensions(get, nullptr);
    instance->debug_utils = contains(available, VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    for (const std::string& name : more_extensions) {
        if (!contains(available, name))
            throw Error(ErrorCode::MissingFeature, fmt::format("the Vulkan drivers of this machine lack {}, which windows need", escape_name(name)), "Vulkan", kNoLoaderHint);
        extensions.push_back(name.c_str());
    }
    if (instance->debug_utils) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
    if (validate) {
        layers.push_back(kValidationLayer);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    }
    const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(*instance);
    VkValidationFeaturesEXT validation{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
    validation.enabledValidationFeatureCount = 1;
    validation.pEnabledValidationFeatures = enabled;
    validation.pNext = &messenger;

    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.pApplicationName = application.pEngineName = "Parhelion";
    application.apiVersion = VK_API_VERSION_1_3;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pNext = validate ? &validation : nullptr;
    info.pApplicationInfo = &application;
    info.enabledLayerCount = static_cast<uint32_t>(layers.size());
    info.ppEnabledLayerNames = layers.data();
    info.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    const auto vkCreateInstance = instance_function<PFN_vkCreateInstance>(get, nullptr, "vkCreateInstance");
    const VkResult result = vkCreateInstance(&info, nullptr, &instance->handle);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER) throw Error(ErrorCode::MissingFeature, "this machine has no Vulkan driver", "Vulkan", kNoLoaderHint);
    check_result(result, "vkCreateInstance", "Vulkan");
    instance->owned = true;
    load_functions(*instance, get);
    if (validate) PARHELION_VK("Vulkan", instance->vk.vkCreateDebugUtilsMessengerEXT(instance->handle, &messenger, nullptr, &instance->messenger));
    return instance;
}

std::shared_ptr<Instance> borrow_instance(VkInstance handle, PFN_vkGetInstanceProcAddr get) {
    if (!get) get = system_loader();
    if (!get) throw Error(ErrorCode::MissingFeature, "this machine has no Vulkan loader", "Vulkan", kNoLoaderHint);
    auto instance = std::make_shared<Instance>();
    instance->handle = handle;
    load_functions(*instance, get);
    return instance;
}

Instance::~Instance() {
    if (!owned) return;
    if (messenger) vk.vkDestroyDebugUtilsMessengerEXT(handle, messenger, nullptr);
    if (vk.vkDestroyInstance) vk.vkDestroyInstance(handle, nullptr);
}

std::vector<VkPhysicalDevice> Instance::physical_devices() const {
    uint32_t count = 0;
    std::vector<VkPhysicalDevice> devices;
    // A machine without any driver answers with an error, which is the same as none.
    if (vk.vkEnumeratePhysicalDevices(handle, &count, nullptr) < VK_SUCCESS) return devices;
    devices.resize(count);
    if (vk.vkEnumeratePhysicalDevices(handle, &count, devices.data()) < VK_SUCCESS) count = 0;
    devices.resize(count);
    return devices;
}

}  // namespace parhelion::gpu
