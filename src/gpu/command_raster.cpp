// Recording: rendering into attachments, and draws.
#include <algorithm>
#include <bit>

#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

VkRenderingAttachmentInfo attachment_info(const Image& image, bool clear) {
    PARHELION_CHECK(image && image.data()->attachment, "nothing can be drawn into image {} of format {}", image ? image.name() : "-",
                    image ? format_name(image.desc().format) : "none");
    VkRenderingAttachmentInfo info{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
    info.imageView = image.data()->attachment;
    info.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
    info.loadOp = clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD;
    info.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
    return info;
}

void check_draws(const Buffer& draws, uint64_t offset, uint32_t count) {
    PARHELION_CHECK(offset % 4 == 0 && offset <= draws.bytes() && count <= (draws.bytes() - offset) / sizeof(Draw), "{} draws at {} of {} ({} bytes)", count, offset,
                    draws.name(), draws.bytes());
}

}  // namespace

ClearColor ClearColor::floats(float r, float g, float b, float a) {
    return {{std::bit_cast<uint32_t>(r), std::bit_cast<uint32_t>(g), std::bit_cast<uint32_t>(b), std::bit_cast<uint32_t>(a)}};
}

void CommandList::begin_rendering(const RenderTarget& target) {
    const Program::Data& program = impl_->bound_program(VK_PIPELINE_BIND_POINT_GRAPHICS);
    const Extent extent = target.extent();
    const auto check_extent = [&](const Image& image) {
        PARHELION_CHECK(image.extent() == extent, "program {}: {} is {}x{}, another attachment {}x{}", program.code.name, image.name(), image.extent().width,
                        image.extent().height, extent.width, extent.height);
    };
    std::vector<VkRenderingAttachmentInfo> colors;
    for (const RenderTarget::Color& color : target.colors) {
        colors.push_back(attachment_info(color.image, color.clear.has_value()));
        check_extent(color.image);
        if (color.clear) std::copy(color.clear->bits.begin(), color.clear->bits.end(), colors.back().clearValue.color.uint32);
    }
    VkRenderingAttachmentInfo depth{};
    VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
    info.renderArea.extent = {extent.width, extent.height};
    info.layerCount = 1;
    info.colorAttachmentCount = static_cast<uint32_t>(colors.size());
    info.pColorAttachments = colors.data();
    if (target.depth) {
        check_extent(target.depth);
        depth = attachment_info(target.depth, target.depth_clear.has_value());
        depth.clearValue.depthStencil.depth = target.depth_clear.value_or(0.0f);
        info.pDepthAttachment = &depth;
    }
    impl_->vk().vkCmdBeginRendering(impl_->buffer, &info);
    impl_->target = extent;
    const VkViewport viewport{0.0f, 0.0f, static_cast<float>(extent.width), static_cast<float>(extent.height), 0.0f, 1.0f};
    impl_->vk().vkCmdSetViewport(impl_->buffer, 0, 1, &viewport);
    set_scissor({0, 0, extent.width, extent.height});
}

void CommandList::end_rendering() { impl_->vk().vkCmdEndRendering(impl_->buffer); }

void CommandList::set_scissor(const Rect& rect) {
    const uint32_t x = std::min(rect.x, impl_->target.width), y = std::min(rect.y, impl_->target.height);
    const VkRect2D scissor{{static_cast<int32_t>(x), static_cast<int32_t>(y)}, {std::min(rect.width, impl_->target.width - x), std::min(rect.height, impl_->target.height - y)}};
    impl_->vk().vkCmdSetScissor(impl_->buffer, 0, 1, &scissor);
}

void CommandList::draw(const Draw& draw) {
    impl_->bound_program(VK_PIPELINE_BIND_POINT_GRAPHICS);
    impl_->vk().vkCmdDraw(impl_->buffer, draw.vertex_count, draw.instance_count, draw.first_vertex, draw.first_instance);
}

void CommandList::draw_indirect(const Buffer& draws, uint64_t offset, uint32_t count) {
    impl_->bound_program(VK_PIPELINE_BIND_POINT_GRAPHICS);
    check_draws(draws, offset, count);
    const uint32_t most = impl_->device->impl().physical.limits.maxDrawIndirectCount;
    for (uint32_t done = 0; done < count; done += std::min(most, count - done))
        impl_->vk().vkCmdDrawIndirect(impl_->buffer, draws.data()->raw.handle, offset + uint64_t(done) * sizeof(Draw), std::min(most, count - done), sizeof(Draw));
}

void CommandList::draw_indirect_count(const Buffer& draws, uint64_t offset, const Buffer& count, uint64_t count_offset, uint32_t most) {
    const Device::Impl& device = impl_->device->impl();
    if (!device.physical.caps.draw_indirect_count || most > device.physical.limits.maxDrawIndirectCount) return draw_indirect(draws, offset, most);
    impl_->bound_program(VK_PIPELINE_BIND_POINT_GRAPHICS);
    check_draws(draws, offset, most);
    PARHELION_CHECK(count_offset % 4 == 0 && count_offset <= count.bytes() && count.bytes() - count_offset >= 4, "the number of draws at {} of {} ({} bytes)", count_offset,
                    count.name(), count.bytes());
    impl_->vk().vkCmdDrawIndirectCount(impl_->buffer, draws.data()->raw.handle, offset, count.data()->raw.handle, count_offset, most, sizeof(Draw));
}

}  // namespace parhelion::gpu
