// Images, their views, and samplers.
#include <algorithm>
#include <bit>

#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

struct FormatInfo {
    Format format;
    std::string_view name;
    uint32_t bytes;  // a texel or block
    VkFormat vulkan;
};

constexpr FormatInfo kFormats[] = {
    {Format::Undefined, "undefined", 0, VK_FORMAT_UNDEFINED},
    {Format::R8Unorm, "r8", 1, VK_FORMAT_R8_UNORM},
    {Format::Rg8Unorm, "rg8", 2, VK_FORMAT_R8G8_UNORM},
    {Format::Rgba8Unorm, "rgba8", 4, VK_FORMAT_R8G8B8A8_UNORM},
    {Format::Rgba8Srgb, "rgba8_srgb", 4, VK_FORMAT_R8G8B8A8_SRGB},
    {Format::R16Float, "r16f", 2, VK_FORMAT_R16_SFLOAT},
    {Format::Rg16Float, "rg16f", 4, VK_FORMAT_R16G16_SFLOAT},
    {Format::Rgba16Float, "rgba16f", 8, VK_FORMAT_R16G16B16A16_SFLOAT},
    {Format::R32Float, "r32f", 4, VK_FORMAT_R32_SFLOAT},
    {Format::Rg32Float, "rg32f", 8, VK_FORMAT_R32G32_SFLOAT},
    {Format::Rgba32Float, "rgba32f", 16, VK_FORMAT_R32G32B32A32_SFLOAT},
    {Format::R32Uint, "r32ui", 4, VK_FORMAT_R32_UINT},
    {Format::Rgba32Uint, "rgba32ui", 16, VK_FORMAT_R32G32B32A32_UINT},
    {Format::Depth32Float, "d32f", 4, VK_FORMAT_D32_SFLOAT},
    {Format::Bc1RgbUnorm, "bc1_rgb", 8, VK_FORMAT_BC1_RGB_UNORM_BLOCK},
    {Format::Bc1RgbSrgb, "bc1_rgb_srgb", 8, VK_FORMAT_BC1_RGB_SRGB_BLOCK},
    {Format::Bc1Unorm, "bc1", 8, VK_FORMAT_BC1_RGBA_UNORM_BLOCK},
    {Format::Bc1Srgb, "bc1_srgb", 8, VK_FORMAT_BC1_RGBA_SRGB_BLOCK},
    {Format::Bc3Unorm, "bc3", 16, VK_FORMAT_BC3_UNORM_BLOCK},
    {Format::Bc3Srgb, "bc3_srgb", 16, VK_FORMAT_BC3_SRGB_BLOCK},
    {Format::Bc4Unorm, "bc4", 8, VK_FORMAT_BC4_UNORM_BLOCK},
    {Format::Bc5Unorm, "bc5", 16, VK_FORMAT_BC5_UNORM_BLOCK},
    {Format::Bc7Unorm, "bc7", 16, VK_FORMAT_BC7_UNORM_BLOCK},
    {Format::Bc7Srgb, "bc7_srgb", 16, VK_FORMAT_BC7_SRGB_BLOCK},
};

constexpr bool in_order() {
    for (size_t i = 0; i < std::size(kFormats); ++i)
        if (static_cast<size_t>(kFormats[i].format) != i) return false;
    return static_cast<size_t>(Format::Bc7Srgb) + 1 == std::size(kFormats);
}
static_assert(in_order());

const FormatInfo& info(Format format) {
    PARHELION_CHECK(static_cast<size_t>(format) < std::size(kFormats), "format {} does not exist", static_cast<uint32_t>(format));
    return kFormats[static_cast<size_t>(format)];
}

VkFormatFeatureFlags format_features(const Device::Impl& device, Format format) {
    VkFormatProperties2 properties{VK_STRUCTURE_TYPE_FORMAT_PROPERTIES_2};
    device.instance->vk.vkGetPhysicalDeviceFormatProperties2(device.physical.handle, vk_format(format), &properties);
    return properties.formatProperties.optimalTilingFeatures;
}

void check_desc(const Device::Impl& device, const std::string& name, const ImageDesc& desc) {
    const Extent& e = desc.extent;
    PARHELION_CHECK(desc.format != Format::Undefined && e.width > 0 && e.height > 0 && e.depth == 1, "image {} is {}x{}x{} of format {}", name, e.width, e.height,
                    e.depth, format_name(desc.format));
    PARHELION_CHECK(desc.mip_count > 0 && desc.mip_count <= static_cast<uint32_t>(std::bit_width(std::max(e.width, e.height))), "image {} has {} mips", name, desc.mip_count);
    if (format_block(desc.format) > 1 && !device.physical.caps.block_compression)
        throw Error(ErrorCode::MissingFeature, fmt::format("cannot read images in blocks ({} is {})", name, format_name(desc.format)), device.name());
    const uint32_t most = device.physical.limits.maxImageDimension2D;
    if (std::max(e.width, e.height) > most)
        throw Error(ErrorCode::Failed, fmt::format("{} is {}x{}, an image of this device has at most {} texels a side", name, e.width, e.height, most), device.name());
}

VkImageView create_view(Device::Impl& device, VkImage image, const ImageDesc& desc, uint32_t mips, VkImageUsageFlags usage) {
    VkImageViewUsageCreateInfo usage_info{VK_STRUCTURE_TYPE_IMAGE_VIEW_USAGE_CREATE_INFO};
    usage_info.usage = usage;
    VkImageViewCreateInfo view_info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view_info.pNext = &usage_info;
    view_info.image = image;
    view_info.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view_info.format = vk_format(desc.format);
    view_info.subresourceRange = {image_aspect(desc.format), 0, mips, 0, 1};
    VkImageView view = nullptr;
    PARHELION_VK(device.name(), device.vk.vkCreateImageView(device.device, &view_info, nullptr, &view));
    return view;
}

void create_image(Device::Impl& device, Image::Data& data, VkImageUsageFlags usage) {
    VkImageCreateInfo create{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    create.imageType = VK_IMAGE_TYPE_2D;
    create.format = vk_format(data.desc.format);
    create.extent = {data.desc.extent.width, data.desc.extent.height, 1};
    create.mipLevels = data.desc.mip_count;
    create.arrayLayers = 1;
    create.samples = VK_SAMPLE_COUNT_1_BIT;
    create.usage = usage;
    PARHELION_VK(device.name(), device.vk.vkCreateImage(device.device, &create, nullptr, &data.handle));
    VkMemoryRequirements needs{};
    device.vk.vkGetImageMemoryRequirements(device.device, data.handle, &needs);
    const VkResult result = device.memory->allocate(needs, Placement::Device, data.allocation);
    if (result != VK_SUCCESS)
        throw Error(ErrorCode::Failed, fmt::format("not enough memory for {} ({} bytes)", data.name, needs.size), device.name(), "a smaller --size or scene, or another --device, may fit");
    device.account(data.name, static_cast<int64_t>(data.allocation.bytes));
    PARHELION_VK(device.name(), device.vk.vkBindImageMemory(device.device, data.handle, data.allocation.memory, data.allocation.offset));
}

}  // namespace

uint32_t format_block(Format format) { return format >= Format::Bc1RgbUnorm ? 4 : 1; }
uint64_t format_bytes(Format format, uint64_t width, uint64_t height) {
    const uint64_t block = format_block(format);
    return (width + block - 1) / block * ((height + block - 1) / block) * info(format).bytes;
}
std::string_view format_name(Format format) { return info(format).name; }
VkFormat vk_format(Format format) { return info(format).vulkan; }
VkImageAspectFlags image_aspect(Format format) { return format == Format::Depth32Float ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT; }

Image::Image(const DevicePtr& device, std::string name, const ImageDesc& desc) {
    Device::Impl& impl = device->impl();
    check_desc(impl, name, desc);
    const VkFormatFeatureFlags features = format_features(impl, desc.format);
    VkImageUsageFlags usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    if (features & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT) usage |= VK_IMAGE_USAGE_SAMPLED_BIT;
    if (features & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT && desc.format != Format::Rgba8Srgb) usage |= VK_IMAGE_USAGE_STORAGE_BIT;
    // What has mip levels is a texture and never drawn to.
    VkImageUsageFlags attachment = 0;
    if (impl.physical.caps.raster && desc.mip_count == 1) {
        if (features & VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT) attachment = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
        if (features & VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT) attachment = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    }
    usage |= attachment;
    auto data = std::make_shared<Data>();
    data->device = device;
    data->name = std::move(name);
    data->desc = desc;
    data->owned = true;
    create_image(impl, *data, usage);
    if (usage & VK_IMAGE_USAGE_SAMPLED_BIT) data->sampled = create_view(impl, data->handle, desc, desc.mip_count, VK_IMAGE_USAGE_SAMPLED_BIT);
    if (usage & VK_IMAGE_USAGE_STORAGE_BIT) data->storage = create_view(impl, data->handle, desc, 1, VK_IMAGE_USAGE_STORAGE_BIT);
    if (attachment != 0) data->attachment = create_view(impl, data->handle, desc, 1, attachment);
    impl.set_name(VK_OBJECT_TYPE_IMAGE, data->handle, data->name);
    data_ = std::move(data);
}

Image Image::borrow(const DevicePtr& device, std::string name, const ImageDesc& desc, VkImage image) {
    PARHELION_CHECK(image, "borrowed image {} has no handle", name);
    check_desc(device->impl(), name, desc);
    auto data = std::make_shared<Data>();
    data->device = device;
    data->name = std::move(name);
    data->desc = desc;
    data->handle = image;
    data->initialised = true;
    data->storage = create_view(device->impl(), image, desc, 1, VK_IMAGE_USAGE_STORAGE_BIT);
    Image out;
    out.data_ = std::move(data);
    return out;
}

Image::Data::~Data() {
    Device::Impl& impl = device->impl();
    if (sampled) impl.vk.vkDestroyImageView(impl.device, sampled, nullptr);
    if (storage) impl.vk.vkDestroyImageView(impl.device, storage, nullptr);
    if (attachment) impl.vk.vkDestroyImageView(impl.device, attachment, nullptr);
    if (!owned) return;
    if (handle) impl.vk.vkDestroyImage(impl.device, handle, nullptr);
    if (allocation.handle) {
        impl.memory->free(allocation);
        impl.account(name, -static_cast<int64_t>(allocation.bytes));
    }
}

const ImageDesc& Image::desc() const { return data_->desc; }
const std::string& Image::name() const { return data_->name; }
bool Image::needs_layout() const { return !data_->initialised; }

Sampler::Sampler(const DevicePtr& device, const SamplerDesc& desc) {
    Device::Impl& impl = device->impl();
    const std::lock_guard lock(impl.mutex);
    auto found = std::find_if(impl.samplers.begin(), impl.samplers.end(), [&](const auto& entry) { return entry.first == desc; });
    if (found == impl.samplers.end()) {
        const auto wrap = [](Wrap w) {
            return w == Wrap::Repeat ? VK_SAMPLER_ADDRESS_MODE_REPEAT : w == Wrap::Mirror ? VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT : VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
        };
        const auto filter = [](Filter f) { return f == Filter::Nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR; };
        VkSamplerCreateInfo create{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
        create.magFilter = filter(desc.mag);
        create.minFilter = filter(desc.min);
        create.mipmapMode = desc.mip == Filter::Nearest ? VK_SAMPLER_MIPMAP_MODE_NEAREST : VK_SAMPLER_MIPMAP_MODE_LINEAR;
        create.addressModeU = wrap(desc.wrap_u);
        create.addressModeV = wrap(desc.wrap_v);
        create.addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
        create.maxLod = VK_LOD_CLAMP_NONE;
        auto made = std::make_shared<Data>();
        PARHELION_VK(impl.name(), impl.vk.vkCreateSampler(impl.device, &create, nullptr, &made->handle));
        found = impl.samplers.insert(impl.samplers.end(), {desc, std::move(made)});
    }
    // The device owns the object; the handle keeps the device.
    struct Hold {
        DevicePtr device;
        std::shared_ptr<Data> data;
    };
    const auto hold = std::make_shared<Hold>(Hold{device, found->second});
    data_ = {hold, hold->data.get()};
}

}  // namespace parhelion::gpu
