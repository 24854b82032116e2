// Recording: labels, barriers, layouts, programs and their resources, dispatches and traces.
#include <algorithm>

#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

std::string_view kind_name(BindingKind kind) {
    constexpr std::string_view names[] = {"storage buffer", "storage image", "sampled image", "uniform buffer", "acceleration structure", "texture table", "colour output"};
    return names[static_cast<size_t>(kind)];
}

template <class Entries>
std::string list_of(const Entries& entries) {
    std::string out;
    for (const auto& entry : entries) out += fmt::format("{}{} {}", out.empty() ? "" : ", ", entry.binding, kind_name(entry.kind));
    return out.empty() ? "nothing" : out;
}

std::vector<ShaderBinding> declared_in_set1(const ShaderCode& code) {
    std::vector<ShaderBinding> out;
    std::copy_if(code.bindings.begin(), code.bindings.end(), std::back_inserter(out), [](const ShaderBinding& b) { return b.set == 1; });
    return out;
}

// The bindings must be exactly what the shader declares in set 1.
void check_bindings(const ShaderCode& code, std::span<const Binding> bindings) {
    const std::vector<ShaderBinding> declared = declared_in_set1(code);
    bool matches = declared.size() == bindings.size();
    for (const ShaderBinding& want : declared)
        matches = matches && std::count_if(bindings.begin(), bindings.end(), [&](const Binding& b) { return b.binding == want.binding && b.kind == want.kind; }) == 1;
    PARHELION_CHECK(matches, "program {} {}: bound {}; declared {}", code.name, code.variant, list_of(bindings), list_of(declared));
    for (const ShaderBinding& want : declared) {
        if (want.kind != BindingKind::StorageImage || want.format == 0) continue;
        const auto bound = std::find_if(bindings.begin(), bindings.end(), [&](const Binding& b) { return b.binding == want.binding; });
        const auto* image = std::get_if<Image>(&bound->resource);
        PARHELION_CHECK(image && *image && static_cast<uint32_t>(image->desc().format) == want.format, "program {}: '{}' is declared {}, image {} is {}", code.name,
                        want.name, format_name(static_cast<Format>(want.format)), image && *image ? image->name() : "-",
                        image && *image ? format_name(image->desc().format) : "no image");
    }
}

// The structures that VkWriteDescriptorSet points to; vectors are sized once so that pointers stay.
struct Writes {
    std::vector<VkWriteDescriptorSet> writes;
    std::vector<VkDescriptorBufferInfo> buffers;
    std::vector<VkDescriptorImageInfo> images;
    std::vector<VkWriteDescriptorSetAccelerationStructureKHR> accels;

    explicit Writes(size_t count) {
        buffers.reserve(count);
        images.reserve(count);
        accels.reserve(count);
    }
    void add(const ShaderCode& code, const Binding& binding) {
        VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
        write.dstBinding = binding.binding;
        write.descriptorCount = 1;
        const auto resource = [&]<class T>(const T*) -> const T& {
            const T* found = std::get_if<T>(&binding.resource);
            PARHELION_CHECK(found && *found, "program {}: binding {} needs a {}", code.name, binding.binding, kind_name(binding.kind));
            return *found;
        };
        switch (binding.kind) {
            case BindingKind::StorageBuffer:
            case BindingKind::UniformBuffer:
                write.descriptorType = binding.kind == BindingKind::StorageBuffer ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER : VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
                buffers.push_back({resource(static_cast<const Buffer*>(nullptr)).data()->raw.handle, 0, VK_WHOLE_SIZE});
                write.pBufferInfo = &buffers.back();
                break;
            case BindingKind::StorageImage:
            case BindingKind::SampledImage: add_image(code, binding, resource(static_cast<const Image*>(nullptr)), write); break;
            case BindingKind::Accel:
                write.descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
                accels.push_back({VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR, nullptr, 1, &resource(static_cast<const AccelStruct*>(nullptr)).data()->handle});
                write.pNext = &accels.back();
                break;
            case BindingKind::TextureTable:
            case BindingKind::ColorOutput: PARHELION_CHECK(false, "program {}: a {} is no resource of set 1", code.name, kind_name(binding.kind));
        }
        writes.push_back(write);
    }
    void add_image(const ShaderCode& code, const Binding& binding, const Image& image, VkWriteDescriptorSet& write) {
        const bool storage = binding.kind == BindingKind::StorageImage;
        const VkImageView view = storage ? image.data()->storage : image.data()->sampled;
        PARHELION_CHECK(view, "program {}: image {} of format {} cannot be a {}", code.name, image.name(), format_name(image.desc().format), kind_name(binding.kind));
        PARHELION_CHECK(storage || binding.sampler, "program {}: image {} is bound without a sampler", code.name, image.name());
        write.descriptorType = storage ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
        images.push_back({storage ? nullptr : binding.sampler.data()->handle, view, VK_IMAGE_LAYOUT_GENERAL});
        write.pImageInfo = &images.back();
    }
};

}  // namespace

const Program::Data& CommandList::Impl::bound_program(VkPipelineBindPoint point) const {
    const char* sort = point == VK_PIPELINE_BIND_POINT_COMPUTE ? "compute" : point == VK_PIPELINE_BIND_POINT_GRAPHICS ? "raster" : "ray tracing";
    PARHELION_CHECK(bound && bound->point == point, "no {} program is bound", sort);
    return *bound;
}

CommandList::CommandList(const DevicePtr& device) : impl_(std::make_unique<Impl>()) {
    impl_->device = device;
    impl_->own = true;
    impl_->slot = device->impl().take_slot();
    impl_->buffer = impl_->slot.buffer;
    VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    info.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    PARHELION_VK(device->caps().name, impl_->vk().vkBeginCommandBuffer(impl_->buffer, &info));
}

CommandList::CommandList(const DevicePtr& device, VkCommandBuffer host) : impl_(std::make_unique<Impl>()) {
    impl_->device = device;
    impl_->buffer = host;
}

CommandList::~CommandList() = default;
CommandList::CommandList(CommandList&&) noexcept = default;
CommandList& CommandList::operator=(CommandList&&) noexcept = default;

CommandList::Impl::~Impl() {
    if (!own || !slot.pool) return;
    // Never submitted: its transitions did not happen.
    for (const std::shared_ptr<Image::Data>& image : first_layouts) image->initialised = false;
    Device::Impl& impl = device->impl();
    const std::lock_guard lock(impl.mutex);
    impl.free_slots.push_back(slot);
}

void CommandList::Impl::memory_barrier(VkPipelineStageFlags2 before, VkAccessFlags2 before_access, VkPipelineStageFlags2 after, VkAccessFlags2 after_access) {
    VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2, nullptr, before, before_access, after, after_access};
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.memoryBarrierCount = 1;
    info.pMemoryBarriers = &barrier;
    vk().vkCmdPipelineBarrier2(buffer, &info);
}

void CommandList::begin_label(std::string_view name) {
    if (!impl_->device->impl().instance->debug_utils || !impl_->vk().vkCmdBeginDebugUtilsLabelEXT) return;
    const std::string terminated(name);
    VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
    label.pLabelName = terminated.c_str();
    impl_->vk().vkCmdBeginDebugUtilsLabelEXT(impl_->buffer, &label);
}

void CommandList::end_label() {
    if (impl_->device->impl().instance->debug_utils && impl_->vk().vkCmdEndDebugUtilsLabelEXT) impl_->vk().vkCmdEndDebugUtilsLabelEXT(impl_->buffer);
}

void CommandList::barrier(const BarrierScope& scope) {
    StageAccess before, after;
    for (const Use use : scope.before) {
        const StageAccess one = stage_access(use);
        before.stages |= one.stages;
        if (use_writes(use)) before.access |= one.access;  // reads have nothing to make available
    }
    for (const Use use : scope.after) {
        const StageAccess one = stage_access(use);
        after.stages |= one.stages;
        after.access |= one.access;
    }
    impl_->memory_barrier(before.stages, before.access, after.stages, after.access);
}

void CommandList::full_barrier() {
    constexpr VkAccessFlags2 kAll = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    impl_->memory_barrier(VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, kAll);
}

void CommandList::initialise_layout(const Image& image) {
    Image::Data& data = *image.data();
    if (data.initialised.exchange(true)) return;
    impl_->first_layouts.push_back(image.data());
    VkImageMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
    barrier.oldLayout = VK_IMAGE_LAYOUT_UNDEFINED;
    barrier.newLayout = VK_IMAGE_LAYOUT_GENERAL;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = data.handle;
    barrier.subresourceRange = {image_aspect(data.desc.format), 0, data.desc.mip_count, 0, 1};
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.imageMemoryBarrierCount = 1;
    info.pImageMemoryBarriers = &barrier;
    impl_->vk().vkCmdPipelineBarrier2(impl_->buffer, &info);
}

void CommandList::bind(const Program& program, const SceneSet* scene, std::span<const Binding> bindings, std::span<const std::byte> push) {
    const Program::Data& data = *program.data();
    const ShaderCode& code = data.code;
    PARHELION_CHECK(push.size() == code.push_bytes, "program {} {}: {} bytes of push constants, the shader declares {}", code.name, code.variant, push.size(), code.push_bytes);
    PARHELION_CHECK(!data.scene_set || (scene && *scene), "program {} {} sees the scene and none is bound", code.name, code.variant);
    check_bindings(code, bindings);
    impl_->vk().vkCmdBindPipeline(impl_->buffer, data.point, data.pipeline);
    if (data.scene_set) impl_->vk().vkCmdBindDescriptorSets(impl_->buffer, data.point, data.layout, 0, 1, &scene->data()->set, 0, nullptr);
    if (!bindings.empty()) {
        Writes writes(bindings.size());
        for (const Binding& binding : bindings) writes.add(code, binding);
        impl_->vk().vkCmdPushDescriptorSetKHR(impl_->buffer, data.point, data.layout, 1, static_cast<uint32_t>(writes.writes.size()), writes.writes.data());
    }
    if (!push.empty()) impl_->vk().vkCmdPushConstants(impl_->buffer, data.layout, data.push_stages, 0, static_cast<uint32_t>(push.size()), push.data());
    impl_->bound = &data;
}

void CommandList::dispatch(uint32_t groups_x, uint32_t groups_y, uint32_t groups_z) {
    const Program::Data& program = impl_->bound_program(VK_PIPELINE_BIND_POINT_COMPUTE);
    const uint32_t* most = impl_->device->impl().physical.limits.maxComputeWorkGroupCount;
    PARHELION_CHECK(groups_x <= most[0] && groups_y <= most[1] && groups_z <= most[2], "program {}: {}x{}x{} work groups, the device takes {}x{}x{}", program.code.name,
                    groups_x, groups_y, groups_z, most[0], most[1], most[2]);
    impl_->vk().vkCmdDispatch(impl_->buffer, groups_x, groups_y, groups_z);
}

void CommandList::dispatch_indirect(const Buffer& args, uint64_t offset) {
    impl_->bound_program(VK_PIPELINE_BIND_POINT_COMPUTE);
    PARHELION_CHECK(offset % 4 == 0 && offset <= args.bytes() && args.bytes() - offset >= 12, "indirect arguments at {} of {} ({} bytes)", offset, args.name(), args.bytes());
    impl_->vk().vkCmdDispatchIndirect(impl_->buffer, args.data()->raw.handle, offset);
}

void CommandList::trace(uint32_t width, uint32_t height, uint32_t depth) {
    const Program::Data& program = impl_->bound_program(VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR);
    const uint64_t most = impl_->device->impl().physical.max_ray_invocations;
    PARHELION_CHECK(width == 0 || height == 0 || depth <= most / width / height, "program {}: {}x{}x{} rays, the device takes {} at once", program.code.name, width, height, depth, most);
    const VkStridedDeviceAddressRegionKHR none{};
    impl_->vk().vkCmdTraceRaysKHR(impl_->buffer, &program.raygen, &program.miss, &program.hit, &none, width, height, depth);
}

void CommandList::trace_indirect(const Buffer& args, uint64_t offset) {
    const Program::Data& program = impl_->bound_program(VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR);
    PARHELION_CHECK(impl_->device->impl().physical.trace_indirect, "{} cannot trace indirectly", impl_->device->caps().name);
    PARHELION_CHECK(offset % 4 == 0 && offset <= args.bytes() && args.bytes() - offset >= 12, "indirect arguments at {} of {} ({} bytes)", offset, args.name(), args.bytes());
    const VkStridedDeviceAddressRegionKHR none{};
    impl_->vk().vkCmdTraceRaysIndirectKHR(impl_->buffer, &program.raygen, &program.miss, &program.hit, &none, args.address() + offset);
}

}  // namespace parhelion::gpu
