// Descriptor set 0: one layout for all programs of a device.
#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

constexpr uint32_t kNow = 0, kBefore = 1, kHeader = 2, kTextures = 3;

void update(const SceneSet::Data& data, VkWriteDescriptorSet& write) {
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = data.set;
    write.descriptorCount = 1;
    const Device::Impl& impl = data.device->impl();
    impl.vk.vkUpdateDescriptorSets(impl.device, 1, &write, 0, nullptr);
}

}  // namespace

void Device::Impl::make_scene_layout() {
    VkShaderStageFlags stages = VK_SHADER_STAGE_COMPUTE_BIT;
    if (physical.caps.ray_pipeline)
        stages |= VK_SHADER_STAGE_RAYGEN_BIT_KHR | VK_SHADER_STAGE_MISS_BIT_KHR | VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR | VK_SHADER_STAGE_ANY_HIT_BIT_KHR;
    if (physical.caps.raster) stages |= VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    std::vector<VkDescriptorBindingFlags> flags;
    const auto add = [&](uint32_t binding, VkDescriptorType type, uint32_t count, VkDescriptorBindingFlags extra) {
        bindings.push_back({binding, type, count, stages, nullptr});
        flags.push_back(VK_DESCRIPTOR_BINDING_PARTIALLY_BOUND_BIT | extra);
    };
    if (has_accel)
        for (const uint32_t binding : {kNow, kBefore}) add(binding, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1, 0);
    add(kHeader, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1, 0);
    add(kTextures, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, physical.caps.max_bindless_textures,
        VK_DESCRIPTOR_BINDING_UPDATE_AFTER_BIND_BIT | VK_DESCRIPTOR_BINDING_VARIABLE_DESCRIPTOR_COUNT_BIT);
    VkDescriptorSetLayoutBindingFlagsCreateInfo flags_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_BINDING_FLAGS_CREATE_INFO};
    flags_info.bindingCount = static_cast<uint32_t>(flags.size());
    flags_info.pBindingFlags = flags.data();
    VkDescriptorSetLayoutCreateInfo info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    info.pNext = &flags_info;
    info.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_UPDATE_AFTER_BIND_POOL_BIT;
    info.bindingCount = static_cast<uint32_t>(bindings.size());
    info.pBindings = bindings.data();
    PARHELION_VK(name(), vk.vkCreateDescriptorSetLayout(device, &info, nullptr, &scene_layout));
}

SceneSet::SceneSet(const DevicePtr& device, std::string name, uint32_t max_textures) {
    Device::Impl& impl = device->impl();
    const uint32_t limit = impl.physical.caps.max_bindless_textures;
    if (max_textures > limit)
        throw Error(ErrorCode::Failed, fmt::format("the scene has {} textures, this device takes {}", max_textures, limit), impl.name());
    auto data = std::make_shared<Data>();
    data->device = device;
    data->name = std::move(name);
    data->max_textures = max_textures;
    const uint32_t slots = std::max(max_textures, 1u);
    std::vector<VkDescriptorPoolSize> sizes{{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1}, {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, slots}};
    if (impl.has_accel) sizes.push_back({VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 2});
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.flags = VK_DESCRIPTOR_POOL_CREATE_UPDATE_AFTER_BIND_BIT;
    pool.maxSets = 1;
    pool.poolSizeCount = static_cast<uint32_t>(sizes.size());
    pool.pPoolSizes = sizes.data();
    PARHELION_VK(impl.name(), impl.vk.vkCreateDescriptorPool(impl.device, &pool, nullptr, &data->pool));
    VkDescriptorSetVariableDescriptorCountAllocateInfo counts{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_ALLOCATE_INFO};
    counts.descriptorSetCount = 1;
    counts.pDescriptorCounts = &slots;
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.pNext = &counts;
    allocate.descriptorPool = data->pool;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &impl.scene_layout;
    PARHELION_VK(impl.name(), impl.vk.vkAllocateDescriptorSets(impl.device, &allocate, &data->set));
    impl.set_name(VK_OBJECT_TYPE_DESCRIPTOR_SET, data->set, data->name);
    data_ = std::move(data);
}

SceneSet::Data::~Data() {
    Device::Impl& impl = device->impl();
    if (pool) impl.vk.vkDestroyDescriptorPool(impl.device, pool, nullptr);
}

uint32_t SceneSet::max_textures() const { return data_->max_textures; }

void SceneSet::set_accel(const AccelStruct& now, const AccelStruct& before) {
    PARHELION_CHECK(data_->device->impl().has_accel, "{} has no acceleration structures", data_->device->caps().name);
    for (const auto& [binding, accel] : {std::pair(kNow, &now), std::pair(kBefore, &before)}) {
        VkWriteDescriptorSetAccelerationStructureKHR accel_write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
        accel_write.accelerationStructureCount = 1;
        accel_write.pAccelerationStructures = &accel->data()->handle;
        VkWriteDescriptorSet write{};
        write.pNext = &accel_write;
        write.dstBinding = binding;
        write.descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
        update(*data_, write);
    }
}

void SceneSet::set_header(const Buffer& header) {
    const VkDescriptorBufferInfo buffer{header.data()->raw.handle, 0, VK_WHOLE_SIZE};
    VkWriteDescriptorSet write{};
    write.dstBinding = kHeader;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    write.pBufferInfo = &buffer;
    update(*data_, write);
}

void SceneSet::set_texture(uint32_t slot, const Image& image, const Sampler& sampler) {
    PARHELION_CHECK(slot < data_->max_textures, "texture slot {} of {} in {}", slot, data_->max_textures, data_->name);
    PARHELION_CHECK(image.data()->sampled, "image {} cannot be sampled", image.name());
    const VkDescriptorImageInfo info{sampler.data()->handle, image.data()->sampled, VK_IMAGE_LAYOUT_GENERAL};
    VkWriteDescriptorSet write{};
    write.dstBinding = kTextures;
    write.dstArrayElement = slot;
    write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    write.pImageInfo = &info;
    update(*data_, write);
}

}  // namespace parhelion::gpu
