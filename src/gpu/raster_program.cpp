// Raster programs: a vertex and a fragment shader with everything that Vulkan wants to know beside them. Attachments are named when
// rendering begins (dynamic rendering, Vulkan 1.3), so a program depends on their formats alone.
#include <algorithm>

#include "base/hash.h"
#include "gpu/program_parts.h"

namespace parhelion::gpu {

namespace {

struct RasterStages {
    const ShaderCode *vertex, *fragment;
};

RasterStages find_stages(const ShaderPack& pack, std::string_view name, std::string_view variant) {
    const ShaderCode* vertex = pack.find(name, variant, Stage::Vertex);
    return {vertex ? vertex : &require(pack, name, {}, Stage::Vertex), &require(pack, name, variant, Stage::Fragment)};
}

// Both shaders name one resource alike.
void merge(const ShaderCode& from, ShaderCode& into) {
    into.push_bytes = std::max(into.push_bytes, from.push_bytes);
    for (const ShaderBinding& b : from.bindings) {
        if (b.writes && b.kind != BindingKind::ColorOutput) fail(from, fmt::format("'{}' is written; declare it readonly: vertex and fragment shaders only read", b.name));
        const auto same = std::find_if(into.bindings.begin(), into.bindings.end(), [&](const ShaderBinding& o) { return o.set == b.set && o.binding == b.binding; });
        if (same == into.bindings.end()) into.bindings.push_back(b);
        else if (same->name != b.name || same->kind != b.kind) fail(from, fmt::format("'{}' is '{}' in the other shader", b.name, same->name));
    }
    for (const PushPointer& p : from.push_pointers) {
        if (p.writes) fail(from, fmt::format("'{}' is written; declare it readonly: vertex and fragment shaders only read", p.name));
        const auto same = std::find_if(into.push_pointers.begin(), into.push_pointers.end(), [&](const PushPointer& o) { return o.offset == p.offset; });
        if (same == into.push_pointers.end()) into.push_pointers.push_back(p);
        else if (same->name != p.name) fail(from, fmt::format("'{}' is '{}' in the other shader", p.name, same->name));
    }
}

ShaderCode joined_code(const RasterStages& stages, std::string_view variant) {
    ShaderCode out;
    out.name = stages.fragment->name;
    out.variant = variant;
    out.stage = Stage::Fragment;
    merge(*stages.vertex, out);
    merge(*stages.fragment, out);
    return out;
}

void check_target(const ShaderCode& code, const RasterTarget& target) {
    const auto outputs = std::count_if(code.bindings.begin(), code.bindings.end(), [](const ShaderBinding& b) { return b.kind == BindingKind::ColorOutput; });
    if (static_cast<size_t>(outputs) != target.colors.size()) fail(code, fmt::format("it writes {} colour outputs, {} are given", outputs, target.colors.size()));
    for (const ShaderBinding& b : code.bindings)
        if (b.kind == BindingKind::ColorOutput && b.binding >= target.colors.size()) fail(code, fmt::format("its output '{}' leaves locations out", b.name));
}

VkPipelineColorBlendAttachmentState blend_state(Blend blend) {
    VkPipelineColorBlendAttachmentState out{};
    out.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT;
    if (blend == Blend::None) return out;
    out.blendEnable = VK_TRUE;
    out.srcColorBlendFactor = blend == Blend::Alpha ? VK_BLEND_FACTOR_SRC_ALPHA : VK_BLEND_FACTOR_ONE;
    out.srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE;
    out.dstColorBlendFactor = out.dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA;
    out.colorBlendOp = out.alphaBlendOp = VK_BLEND_OP_ADD;
    return out;
}

// Everything but shaders and layout; it points into itself.
struct FixedState {
    VkPipelineVertexInputStateCreateInfo input{VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    VkPipelineInputAssemblyStateCreateInfo assembly{VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO};
    VkPipelineViewportStateCreateInfo viewport{VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO};
    VkPipelineRasterizationStateCreateInfo raster{VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO};
    VkPipelineMultisampleStateCreateInfo samples{VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO};
    VkPipelineDepthStencilStateCreateInfo depth{VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
    VkPipelineColorBlendStateCreateInfo blend{VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO};
    VkPipelineDynamicStateCreateInfo dynamic{VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO};
    VkPipelineRenderingCreateInfo rendering{VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
    std::vector<VkPipelineColorBlendAttachmentState> blends;
    std::vector<VkFormat> formats;
    const VkDynamicState states[2] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};

    FixedState(const RasterState& state, const RasterTarget& target) : blends(target.colors.size(), blend_state(state.blend)) {
        for (const Format format : target.colors) formats.push_back(vk_format(format));
        assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
        viewport.viewportCount = viewport.scissorCount = 1;
        raster.cullMode = state.cull == Cull::Back ? VK_CULL_MODE_BACK_BIT : VK_CULL_MODE_NONE;
        raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
        raster.lineWidth = 1.0f;
        samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
        depth.depthTestEnable = state.depth_test != DepthTest::None;
        depth.depthWriteEnable = state.depth_test != DepthTest::None && state.depth_write;
        depth.depthCompareOp = VK_COMPARE_OP_GREATER;
        blend.attachmentCount = static_cast<uint32_t>(blends.size());
        blend.pAttachments = blends.data();
        dynamic.dynamicStateCount = 2;
        dynamic.pDynamicStates = states;
        rendering.colorAttachmentCount = static_cast<uint32_t>(formats.size());
        rendering.pColorAttachmentFormats = formats.data();
        rendering.depthAttachmentFormat = vk_format(target.depth);
    }
    FixedState(const FixedState&) = delete;
    FixedState& operator=(const FixedState&) = delete;
};

void make_pipeline(Device::Impl& device, Program::Data& data, const RasterStages& stages, const RasterState& state, const RasterTarget& target) {
    if (!device.physical.caps.raster) throw Error(ErrorCode::MissingFeature, fmt::format("cannot rasterise ({})", data.code.name), device.name(), "use what traces instead");
    check_bindings(device, data.code);
    check_target(data.code, target);
    data.push_stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    make_layouts(device, data, data.push_stages);
    const ShaderModule vertex(device, *stages.vertex), fragment(device, *stages.fragment);
    const VkPipelineShaderStageCreateInfo infos[] = {stage_info(vertex, Stage::Vertex), stage_info(fragment, Stage::Fragment)};
    const FixedState fixed(state, target);
    VkGraphicsPipelineCreateInfo info{VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO};
    info.pNext = &fixed.rendering;
    info.stageCount = 2;
    info.pStages = infos;
    info.pVertexInputState = &fixed.input;
    info.pInputAssemblyState = &fixed.assembly;
    info.pViewportState = &fixed.viewport;
    info.pRasterizationState = &fixed.raster;
    info.pMultisampleState = &fixed.samples;
    info.pDepthStencilState = &fixed.depth;
    info.pColorBlendState = &fixed.blend;
    info.pDynamicState = &fixed.dynamic;
    info.layout = data.layout;
    PARHELION_VK(fmt::format("{}: {}", device.name(), data.code.name),
                 device.vk.vkCreateGraphicsPipelines(device.device, device.pipeline_cache, 1, &info, nullptr, &data.pipeline));
}

}  // namespace

ShaderCode Program::raster_code(const ShaderPack& pack, std::string_view name, std::string_view variant) { return joined_code(find_stages(pack, name, variant), variant); }

Program Program::get_raster(const DevicePtr& device, const ShaderPack& pack, std::string_view name, std::string_view variant, const RasterState& state,
                            const RasterTarget& target) {
    const RasterStages stages = find_stages(pack, name, variant);
    Hasher hash;
    hash.add(stages.vertex->hash);
    hash.add(stages.fragment->hash);
    std::string key = fmt::format("{}\n{}\nraster {} {} {} {} {}", name, variant, static_cast<uint32_t>(state.cull), static_cast<uint32_t>(state.blend),
                                  static_cast<uint32_t>(state.depth_test), state.depth_write, format_name(target.depth));
    for (const Format format : target.colors) key += fmt::format(" {}", format_name(format));
    Program out;
    out.data_ = keep_program(device, {hash.value(), std::move(key)}, [&] {
        Device::Impl& impl = device->impl();
        const auto data = std::make_shared<Data>();
        data->point = VK_PIPELINE_BIND_POINT_GRAPHICS;
        data->code = joined_code(stages, variant);
        data->scene_set = sees_scene(data->code);
        try {
            make_pipeline(impl, *data, stages, state, target);
        } catch (...) {
            data->destroy(impl);
            throw;
        }
        impl.set_name(VK_OBJECT_TYPE_PIPELINE, data->pipeline, data->code.name + " " + data->code.variant);
        return data;
    });
    return out;
}

}  // namespace parhelion::gpu
