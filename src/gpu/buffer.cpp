// Buffers: every one can be used in every way, has a device address and counts for its memory group.
#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

// Shader binding tables, scratch and cache lines all want less.
constexpr uint64_t kAddressAlignment = 256;

VkBufferUsageFlags all_usage(const Device::Impl& device) {
    VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                               VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
    if (device.has_accel)
        usage |= VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR | VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;
    if (device.physical.caps.ray_pipeline) usage |= VK_BUFFER_USAGE_SHADER_BINDING_TABLE_BIT_KHR;
    return usage;
}

[[noreturn]] void fail_memory(const std::string& device, const std::string& name, uint64_t bytes, VkResult result) {
    if (result != VK_ERROR_OUT_OF_DEVICE_MEMORY && result != VK_ERROR_OUT_OF_HOST_MEMORY)
        check_result(result, "vkAllocateMemory", fmt::format("{} ({})", device, name));
    throw Error(ErrorCode::Failed, fmt::format("not enough memory for {} ({} bytes)", name, bytes), device, "a smaller --size or scene, or another --device, may fit");
}

}  // namespace

RawBuffer Device::Impl::create_buffer(const std::string& buffer_name, uint64_t bytes, Placement placement) {
    PARHELION_CHECK(bytes > 0, "buffer {} has no bytes", buffer_name);
    if (bytes > physical.max_buffer_bytes)
        throw Error(ErrorCode::Failed, fmt::format("{} would need {} bytes, a buffer of this device has at most {}", buffer_name, bytes, physical.max_buffer_bytes), name());
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = all_usage(*this);
    RawBuffer raw;
    raw.bytes = bytes;
    VkResult result = vk.vkCreateBuffer(device, &info, nullptr, &raw.handle);
    if (result == VK_SUCCESS) {
        VkMemoryRequirements needs{};
        vk.vkGetBufferMemoryRequirements(device, raw.handle, &needs);
        needs.alignment = std::max(needs.alignment, kAddressAlignment);
        result = memory->allocate(needs, placement, raw.allocation);
        if (result == VK_SUCCESS) {
            account(buffer_name, static_cast<int64_t>(raw.allocation.bytes));
            result = vk.vkBindBufferMemory(device, raw.handle, raw.allocation.memory, raw.allocation.offset);
        }
    }
    if (result != VK_SUCCESS) {
        destroy_buffer(buffer_name, raw);
        fail_memory(name(), buffer_name, bytes, result);
    }
    set_name(VK_OBJECT_TYPE_BUFFER, raw.handle, buffer_name);
    VkBufferDeviceAddressInfo address{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
    address.buffer = raw.handle;
    raw.address = vk.vkGetBufferDeviceAddress(device, &address);
    PARHELION_CHECK(raw.address % kAddressAlignment == 0, "the address of buffer {} is aligned to less than {} bytes", buffer_name, kAddressAlignment);
    return raw;
}

void Device::Impl::destroy_buffer(const std::string& buffer_name, RawBuffer& buffer) noexcept {
    if (buffer.handle) vk.vkDestroyBuffer(device, buffer.handle, nullptr);
    if (buffer.allocation.handle) {
        memory->free(buffer.allocation);
        account(buffer_name, -static_cast<int64_t>(buffer.allocation.bytes));
    }
    buffer = {};
}

Buffer::Buffer(const DevicePtr& device, std::string name, uint64_t bytes, MemoryKind kind) {
    auto data = std::make_shared<Data>();
    data->device = device;
    data->name = std::move(name);
    data->raw = device->impl().create_buffer(data->name, bytes, placement_of(kind));
    data_ = std::move(data);
}

Buffer::Data::~Data() { device->impl().destroy_buffer(name, raw); }

uint64_t Buffer::bytes() const { return data_->raw.bytes; }
uint64_t Buffer::address() const { return data_->raw.address; }
const std::string& Buffer::name() const { return data_->name; }
std::byte* Buffer::mapped() const {
    PARHELION_CHECK(data_->raw.allocation.mapped, "buffer {} is not mapped", data_->name);
    return data_->raw.allocation.mapped;
}

}  // namespace parhelion::gpu
