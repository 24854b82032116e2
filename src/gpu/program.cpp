// Pipelines from shader code: compute, and ray tracing with the scene's hit and miss shaders.
#include <algorithm>
#include <cstring>
#include <utility>

#include "base/hash.h"
#include "gpu/program_parts.h"

namespace parhelion::gpu {

namespace {

constexpr std::string_view kHitName = "scene/hit", kMissName = "scene/miss", kShadowMissName = "scene/shadow_miss";

VkShaderStageFlagBits stage_bit(Stage stage) {
    switch (stage) {
        case Stage::Vertex: return VK_SHADER_STAGE_VERTEX_BIT;
        case Stage::Fragment: return VK_SHADER_STAGE_FRAGMENT_BIT;
        case Stage::Raygen: return VK_SHADER_STAGE_RAYGEN_BIT_KHR;
        case Stage::Miss: return VK_SHADER_STAGE_MISS_BIT_KHR;
        case Stage::ClosestHit: return VK_SHADER_STAGE_CLOSEST_HIT_BIT_KHR;
        case Stage::AnyHit: return VK_SHADER_STAGE_ANY_HIT_BIT_KHR;
        default: return VK_SHADER_STAGE_COMPUTE_BIT;
    }
}

VkDescriptorType descriptor_type(BindingKind kind) {
    switch (kind) {
        case BindingKind::StorageImage: return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
        case BindingKind::SampledImage:
        case BindingKind::TextureTable: return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
        case BindingKind::UniformBuffer: return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
        case BindingKind::Accel: return VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
        default: return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    }
}

}  // namespace

void fail(const ShaderCode& code, const std::string& what) {
    throw Error(ErrorCode::Failed, what, fmt::format("shader {}{}{}", code.name, code.variant.empty() ? "" : " ", code.variant));
}

const ShaderCode& require(const ShaderPack& pack, std::string_view name, std::string_view variant, Stage stage) {
    if (const ShaderCode* code = pack.find(name, variant, stage)) return *code;
    constexpr std::string_view stages[] = {"compute", "raygen", "miss", "closest hit", "any hit", "vertex", "fragment"};
    throw Error(ErrorCode::Failed, fmt::format("there is no {} shader '{}'{}", stages[static_cast<size_t>(stage)], name, variant.empty() ? "" : fmt::format(" in variant '{}'", variant)),
                "shaders.pack", "build it again");
}

namespace {

// What was optimised for GPUs (variant~), where there is such a thing and the device is one.
const ShaderCode& compute_code(const ShaderPack& pack, std::string_view name, std::string_view variant, const DeviceCaps& caps) {
    const ShaderCode* optimized = caps.type == DeviceType::Cpu ? nullptr : pack.find(name, fmt::format("{}~", variant), Stage::Compute);
    return optimized ? *optimized : require(pack, name, variant, Stage::Compute);
}

}  // namespace

void check_bindings(const Device::Impl& device, const ShaderCode& code) {
    uint32_t pushed = 0;
    for (const ShaderBinding& b : code.bindings) {
        if (b.kind == BindingKind::ColorOutput) continue;
        constexpr BindingKind scene_kinds[] = {BindingKind::Accel, BindingKind::Accel, BindingKind::StorageBuffer, BindingKind::TextureTable};
        if (b.set > 1) fail(code, fmt::format("'{}' lies in set {}; there are 0 (scene) and 1 (pass)", b.name, b.set));
        if (b.set == 0 && (b.binding > 3 || scene_kinds[b.binding] != b.kind)) fail(code, fmt::format("'{}' is no part of the scene's set 0", b.name));
        if (b.set == 1 && b.kind == BindingKind::TextureTable) fail(code, fmt::format("'{}' is an array, which set 1 cannot hold", b.name));
        if (b.kind == BindingKind::Accel && !device.has_accel)
            throw Error(ErrorCode::MissingFeature, fmt::format("{} {} needs acceleration structures", code.name, code.variant), device.name(), "use --trace compute");
        pushed += b.set;
    }
    if (pushed > device.physical.max_push_descriptors) fail(code, fmt::format("it binds {} resources, this device takes {}", pushed, device.physical.max_push_descriptors));
    if (code.push_bytes > device.physical.caps.max_push_constant_bytes)
        fail(code, fmt::format("it has {} bytes of push constants, this device takes {}", code.push_bytes, device.physical.caps.max_push_constant_bytes));
}

bool sees_scene(const ShaderCode& code) {
    return std::any_of(code.bindings.begin(), code.bindings.end(), [](const ShaderBinding& b) { return b.set == 0; });
}

void make_layouts(Device::Impl& device, Program::Data& data, VkShaderStageFlags set1_stages) {
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (const ShaderBinding& b : data.code.bindings)
        if (b.set == 1) bindings.push_back({b.binding, descriptor_type(b.kind), 1, set1_stages, nullptr});
    VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set_info.flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR;
    set_info.bindingCount = static_cast<uint32_t>(bindings.size());
    set_info.pBindings = bindings.data();
    PARHELION_VK(device.name(), device.vk.vkCreateDescriptorSetLayout(device.device, &set_info, nullptr, &data.set1));
    const VkDescriptorSetLayout sets[] = {device.scene_layout, data.set1};
    const VkPushConstantRange push{data.push_stages, 0, data.code.push_bytes};
    VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    info.setLayoutCount = 2;
    info.pSetLayouts = sets;
    info.pushConstantRangeCount = data.code.push_bytes != 0 ? 1 : 0;
    info.pPushConstantRanges = &push;
    PARHELION_VK(device.name(), device.vk.vkCreatePipelineLayout(device.device, &info, nullptr, &data.layout));
}

ShaderModule::ShaderModule(Device::Impl& owner, const ShaderCode& code) : device(owner) {
    VkShaderModuleCreateInfo info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    info.codeSize = code.words.size() * sizeof(uint32_t);
    info.pCode = code.words.data();
    PARHELION_VK(device.name(), device.vk.vkCreateShaderModule(device.device, &info, nullptr, &handle));
}
ShaderModule::~ShaderModule() { device.vk.vkDestroyShaderModule(device.device, handle, nullptr); }

VkPipelineShaderStageCreateInfo stage_info(const ShaderModule& module, Stage stage) {
    VkPipelineShaderStageCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage = stage_bit(stage);
    info.module = module.handle;
    info.pName = "main";
    return info;
}

namespace {

void make_compute(Device::Impl& device, Program::Data& data, const ShaderCode& code, uint32_t constant) {
    const VkPhysicalDeviceLimits& limits = device.physical.limits;
    const uint64_t invocations = uint64_t(code.local_size[0]) * code.local_size[1] * code.local_size[2];
    if (invocations > limits.maxComputeWorkGroupInvocations)
        fail(code, fmt::format("its work groups have {} invocations, this device takes {}", invocations, limits.maxComputeWorkGroupInvocations));
    data.push_stages = VK_SHADER_STAGE_COMPUTE_BIT;
    make_layouts(device, data, VK_SHADER_STAGE_COMPUTE_BIT);
    const ShaderModule module(device, code);
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    const VkSpecializationMapEntry entry{0, 0, sizeof(constant)};
    const VkSpecializationInfo constants{1, &entry, sizeof(constant), &constant};
    info.stage = stage_info(module, Stage::Compute);
    if (code.has_constant) info.stage.pSpecializationInfo = &constants;
    info.layout = data.layout;
    PARHELION_VK(fmt::format("{}: {}", device.name(), code.name), device.vk.vkCreateComputePipelines(device.device, device.pipeline_cache, 1, &info, nullptr, &data.pipeline));
}

// The stages of every ray tracing program, in this order; the group numbers below refer to it. Four groups: raygen, two miss shaders, one hit group.
struct RayStages {
    const ShaderCode *raygen, *miss, *shadow_miss, *closest_hit, *any_hit;
    std::array<const ShaderCode*, 5> all() const { return {raygen, miss, shadow_miss, closest_hit, any_hit}; }
};
enum Group : uint32_t { kRaygenGroup, kMissGroup, kShadowMissGroup, kHitGroup, kGroupCount };

void make_table(Device::Impl& device, Program::Data& data) {
    const DeviceCaps& caps = device.physical.caps;
    const uint32_t handle_bytes = caps.shader_group_handle_size;
    const ShaderTableLayout at = layout_shader_table(handle_bytes, caps.shader_group_handle_alignment, caps.shader_group_base_alignment);
    std::vector<std::byte> handles(size_t(handle_bytes) * kGroupCount);
    PARHELION_VK(device.name(), device.vk.vkGetRayTracingShaderGroupHandlesKHR(device.device, data.pipeline, 0, kGroupCount, handles.size(), handles.data()));
    const uint64_t offsets[kGroupCount] = {at.raygen, at.miss, at.shadow_miss, at.hit};
    data.sbt = device.create_buffer("programs/" + data.code.name, at.bytes, Placement::MappedDevice);
    for (uint32_t g = 0; g < kGroupCount; ++g) std::memcpy(data.sbt.allocation.mapped + offsets[g], handles.data() + size_t(g) * handle_bytes, handle_bytes);
    PARHELION_CHECK(data.sbt.address % at.base == 0, "the shader binding table of {} is misaligned", data.code.name);
    data.raygen = {data.sbt.address + at.raygen, at.stride, at.stride};  // Vulkan wants size = stride here
    data.miss = {data.sbt.address + at.miss, at.stride, 2 * at.stride};
    data.hit = {data.sbt.address + at.hit, at.stride, at.stride};
}

void make_ray_tracing(Device::Impl& device, Program::Data& data, const RayStages& stages) {
    PARHELION_CHECK(device.physical.caps.ray_pipeline && device.physical.caps.max_ray_recursion_depth >= 1, "{} has no ray tracing pipelines", device.name());
    data.push_stages = VK_SHADER_STAGE_RAYGEN_BIT_KHR;
    for (const ShaderCode* code : stages.all())
        if (code != stages.raygen && code->push_bytes != 0) data.push_stages |= stage_bit(code->stage);
    make_layouts(device, data, VK_SHADER_STAGE_RAYGEN_BIT_KHR);
    std::vector<std::unique_ptr<ShaderModule>> modules;
    std::vector<VkPipelineShaderStageCreateInfo> infos;
    for (const ShaderCode* code : stages.all()) {
        modules.push_back(std::make_unique<ShaderModule>(device, *code));
        infos.push_back(stage_info(*modules.back(), code->stage));
    }
    std::vector<VkRayTracingShaderGroupCreateInfoKHR> groups(kGroupCount);
    for (uint32_t g = 0; g < kGroupCount; ++g) {
        groups[g] = {VK_STRUCTURE_TYPE_RAY_TRACING_SHADER_GROUP_CREATE_INFO_KHR};
        groups[g].type = VK_RAY_TRACING_SHADER_GROUP_TYPE_GENERAL_KHR;
        groups[g].generalShader = g;
        groups[g].closestHitShader = groups[g].anyHitShader = groups[g].intersectionShader = VK_SHADER_UNUSED_KHR;
    }
    groups[kHitGroup].type = VK_RAY_TRACING_SHADER_GROUP_TYPE_TRIANGLES_HIT_GROUP_KHR;
    groups[kHitGroup].generalShader = VK_SHADER_UNUSED_KHR;
    groups[kHitGroup].closestHitShader = 3;
    groups[kHitGroup].anyHitShader = 4;
    VkRayTracingPipelineCreateInfoKHR info{VK_STRUCTURE_TYPE_RAY_TRACING_PIPELINE_CREATE_INFO_KHR};
    info.stageCount = static_cast<uint32_t>(infos.size());
    info.pStages = infos.data();
    info.groupCount = kGroupCount;
    info.pGroups = groups.data();
    info.maxPipelineRayRecursionDepth = 1;
    info.layout = data.layout;
    PARHELION_VK(fmt::format("{}: {}", device.name(), data.code.name),
                 device.vk.vkCreateRayTracingPipelinesKHR(device.device, nullptr, device.pipeline_cache, 1, &info, nullptr, &data.pipeline));
    make_table(device, data);
}

// The scene's stages see set 0 and at most the raygen's push constants, in which addresses have the names that raygen gives them.
void check_scene_stage(const ShaderCode& raygen, const ShaderCode& code) {
    for (const ShaderBinding& b : code.bindings)
        if (b.set != 0) fail(code, fmt::format("'{}' lies in set {}; hit and miss shaders see set 0 only", b.name, b.set));
    if (code.push_bytes > raygen.push_bytes) fail(code, fmt::format("its push constants are larger than those of {}", raygen.name));
    for (const PushPointer& pointer : code.push_pointers) {
        const auto same = [&](const PushPointer& p) { return p.name == pointer.name && p.offset == pointer.offset; };
        if (std::none_of(raygen.push_pointers.begin(), raygen.push_pointers.end(), same))
            fail(code, fmt::format("the push constants of {} have no address '{}' at {}", raygen.name, pointer.name, pointer.offset));
    }
}

// Hit and miss shaders of the raygen's defines, if the pack has a closest-hit shader for those; else the plain ones. All four are
// of one kind: they share a payload.
void add_scene_stages(const ShaderPack& pack, std::string_view variant, RayStages& stages) {
    std::string_view defines = variant.substr(std::min(variant.find('+'), variant.size()));
    if (!pack.find(kHitName, defines, Stage::ClosestHit)) defines = {};
    stages.miss = &require(pack, kMissName, defines, Stage::Miss);
    stages.shadow_miss = &require(pack, kShadowMissName, defines, Stage::Miss);
    stages.closest_hit = &require(pack, kHitName, defines, Stage::ClosestHit);
    stages.any_hit = &require(pack, kHitName, defines, Stage::AnyHit);
}

std::shared_ptr<Program::Data> make_program(Device::Impl& device, const RayStages& stages, bool ray_tracing, uint32_t constant) {
    const auto data = std::make_shared<Program::Data>();
    data->code = *stages.raygen;
    data->code.words.clear();
    data->point = ray_tracing ? VK_PIPELINE_BIND_POINT_RAY_TRACING_KHR : VK_PIPELINE_BIND_POINT_COMPUTE;
    try {
        for (const ShaderCode* code : stages.all()) {
            if (!code) continue;
            check_bindings(device, *code);
            if (code != stages.raygen) check_scene_stage(*stages.raygen, *code);
            data->scene_set = data->scene_set || sees_scene(*code);
        }
        if (ray_tracing) make_ray_tracing(device, *data, stages);
        else make_compute(device, *data, *stages.raygen, constant);
    } catch (...) {
        data->destroy(device);
        throw;
    }
    device.set_name(VK_OBJECT_TYPE_PIPELINE, data->pipeline, data->code.name + " " + data->code.variant);
    return data;
}

}  // namespace

void Program::Data::destroy(Device::Impl& device) noexcept {
    if (pipeline) device.vk.vkDestroyPipeline(device.device, pipeline, nullptr);
    if (layout) device.vk.vkDestroyPipelineLayout(device.device, layout, nullptr);
    if (set1) device.vk.vkDestroyDescriptorSetLayout(device.device, set1, nullptr);
    device.destroy_buffer("programs/" + code.name, sbt);
    pipeline = nullptr, layout = nullptr, set1 = nullptr;
}

Program Program::get(const DevicePtr& device, const ShaderPack& pack, std::string_view name, std::string_view variant, bool ray_tracing, uint32_t constant) {
    const ShaderCode& first = ray_tracing ? require(pack, name, variant, Stage::Raygen) : compute_code(pack, name, variant, device->caps());
    RayStages stages{&first, nullptr, nullptr, nullptr, nullptr};
    Hasher hash;
    if (ray_tracing) add_scene_stages(pack, variant, stages);
    for (const ShaderCode* code : stages.all()) hash.add(code ? code->hash : 0);
    if (stages.raygen->has_constant) hash.add(constant);
    Program out;
    out.data_ = keep_program(device, {hash.value(), fmt::format("{}\n{}\n{}", name, variant, ray_tracing)},
                             [&] { return make_program(device->impl(), stages, ray_tracing, constant); });
    return out;
}

std::shared_ptr<Program::Data> keep_program(const DevicePtr& device, const std::pair<uint64_t, std::string>& key,
                                            const std::function<std::shared_ptr<Program::Data>()>& make) {
    Device::Impl& impl = device->impl();
    using Data = Program::Data;
    std::shared_ptr<Data> data;
    {
        const std::lock_guard lock(impl.mutex);
        if (const auto found = impl.programs.find(key); found != impl.programs.end()) data = found->second;
    }
    if (!data) {
        data = make();
        std::unique_lock lock(impl.mutex);
        const auto [kept, is_new] = impl.programs.emplace(key, data);
        lock.unlock();
        if (!is_new) data->destroy(impl), data = kept->second;  // another thread was faster
    }
    // The device owns the pipeline; the handle keeps the device.
    struct Hold {
        DevicePtr device;
        std::shared_ptr<Data> data;
    };
    const auto hold = std::make_shared<Hold>(Hold{device, std::move(data)});
    return {hold, hold->data.get()};
}

void Program::forget(const DevicePtr& device, Program&& program) {
    const Data* data = std::exchange(program, {}).data_.get();  // its handle ends here
    Device::Impl& impl = device->impl();
    const std::lock_guard lock(impl.mutex);
    const auto found = std::ranges::find_if(impl.programs, [&](const auto& kept) { return kept.second.get() == data; });
    if (found == impl.programs.end() || found->second.use_count() > 1) return;
    found->second->destroy(impl);
    impl.programs.erase(found);
}

const ShaderCode& Program::code() const { return data_->code; }
bool Program::uses_scene_set() const { return data_->scene_set; }

}  // namespace parhelion::gpu
