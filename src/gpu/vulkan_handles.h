#pragma once
// Vulkan's dispatchable handles by name only, so that embedding programs and other layers can pass them through without
// including vulkan.h (which only src/gpu does). The declarations are identical to Vulkan's own and may stand beside them.
typedef struct VkInstance_T* VkInstance;
typedef struct VkPhysicalDevice_T* VkPhysicalDevice;
typedef struct VkDevice_T* VkDevice;
typedef struct VkQueue_T* VkQueue;
typedef struct VkCommandBuffer_T* VkCommandBuffer;
typedef struct VkImage_T* VkImage;          // 64-bit platforms
typedef struct VkImageView_T* VkImageView;  // 64-bit platforms
typedef struct VkSurfaceKHR_T* VkSurfaceKHR;  // 64-bit platforms
