// Recording: copies, fills, mip levels, acceleration structure builds, timers and the progress marker.
#include <algorithm>

#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

void check_range(const Buffer& buffer, uint64_t offset, uint64_t bytes) {
    PARHELION_CHECK(offset <= buffer.bytes() && bytes <= buffer.bytes() - offset, "bytes {} to {} of {} ({} bytes)", offset, offset + bytes, buffer.name(), buffer.bytes());
}

Extent mip_extent(const ImageDesc& desc, uint32_t mip) {
    return {std::max(desc.extent.width >> mip, 1u), std::max(desc.extent.height >> mip, 1u), 1};
}

VkImageSubresourceLayers layers(const Image& image, uint32_t mip) { return {image_aspect(image.desc().format), mip, 0, 1}; }

uint64_t scratch_address(const AccelStruct& accel, const Buffer& scratch, uint64_t offset, uint32_t alignment) {
    check_range(scratch, offset, accel.scratch_bytes());
    return align_up(scratch.address() + offset, alignment);
}

// What Vulkan wants to know of one build; it points into itself.
struct BlasInfo {
    std::vector<VkAccelerationStructureGeometryKHR> triangles;
    std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
    VkAccelerationStructureBuildGeometryInfoKHR header{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};

    void fill(const BlasBuild& build, uint64_t scratch) {
        const AccelStruct::Data& data = *build.blas.data();
        const std::vector<BlasGeometry>& geometries = build.geometries;
        PARHELION_CHECK(geometries.size() == data.sizes.size(), "{} is built from {} geometries and was made for {}", data.name, geometries.size(), data.sizes.size());
        for (size_t i = 0; i < geometries.size(); ++i) {
            const BlasGeometry& geometry = geometries[i];
            PARHELION_CHECK(geometry.vertex_count <= data.sizes[i].first && geometry.triangle_count <= data.sizes[i].second,
                            "geometry {} of {} has {} vertices and {} triangles; room is for {} and {}", i, data.name, geometry.vertex_count, geometry.triangle_count,
                            data.sizes[i].first, data.sizes[i].second);
            triangles.push_back(triangle_geometry(geometry));
            ranges.push_back({geometry.triangle_count, 0, 0, 0});
        }
        header.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
        header.flags = data.flags;
        header.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
        if (build.refit_from) {
            const AccelStruct::Data& from = *build.refit_from.data();
            PARHELION_CHECK(data.flags == kDeformingFlags && from.flags == kDeformingFlags && from.sizes == data.sizes, "{} cannot be refitted from {}", data.name, from.name);
            header.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR;
            header.srcAccelerationStructure = from.handle;
        }
        header.dstAccelerationStructure = data.handle;
        header.geometryCount = static_cast<uint32_t>(triangles.size());
        header.pGeometries = triangles.data();
        header.scratchData.deviceAddress = scratch;
    }
};

}  // namespace

void CommandList::copy(const Buffer& from, uint64_t from_offset, const Buffer& to, uint64_t to_offset, uint64_t bytes) {
    check_range(from, from_offset, bytes);
    check_range(to, to_offset, bytes);
    const VkBufferCopy region{from_offset, to_offset, bytes};
    impl_->vk().vkCmdCopyBuffer(impl_->buffer, from.data()->raw.handle, to.data()->raw.handle, 1, &region);
}

void CommandList::copy_to_image(const Buffer& from, uint64_t offset, const Image& to, uint32_t mip, uint32_t first_row, uint32_t rows) {
    const Extent extent = mip_extent(to.desc(), mip);
    PARHELION_CHECK(mip < to.desc().mip_count && first_row <= extent.height && rows <= extent.height - first_row, "rows {} to {} of mip {} of {} ({} rows)", first_row,
                    first_row + rows, mip, to.name(), extent.height);
    const uint32_t block = format_block(to.desc().format);
    PARHELION_CHECK(first_row % block == 0 && (rows % block == 0 || first_row + rows == extent.height), "rows {} to {} of {} are not whole blocks", first_row,
                    first_row + rows, to.name());
    check_range(from, offset, format_bytes(to.desc().format, extent.width, rows));
    VkBufferImageCopy region{};
    region.bufferOffset = offset;
    region.imageSubresource = layers(to, mip);
    region.imageOffset = {0, static_cast<int32_t>(first_row), 0};
    region.imageExtent = {extent.width, rows, 1};
    impl_->vk().vkCmdCopyBufferToImage(impl_->buffer, from.data()->raw.handle, to.data()->handle, VK_IMAGE_LAYOUT_GENERAL, 1, &region);
}

void CommandList::copy_from_image(const Image& from, const Buffer& to, uint64_t offset) {
    const Extent extent = from.extent();
    check_range(to, offset, format_bytes(from.desc().format, extent.width, extent.height));
    VkBufferImageCopy region{};
    region.bufferOffset = offset;
    region.imageSubresource = layers(from, 0);
    region.imageExtent = {extent.width, extent.height, 1};
    impl_->vk().vkCmdCopyImageToBuffer(impl_->buffer, from.data()->handle, VK_IMAGE_LAYOUT_GENERAL, to.data()->raw.handle, 1, &region);
}

void CommandList::fill(const Buffer& buffer, uint64_t offset, uint64_t bytes, uint32_t value) {
    check_range(buffer, offset, bytes);
    PARHELION_CHECK(offset % 4 == 0 && bytes % 4 == 0, "a fill of {} writes whole words, not {} bytes at {}", buffer.name(), bytes, offset);
    if (bytes != 0) impl_->vk().vkCmdFillBuffer(impl_->buffer, buffer.data()->raw.handle, offset, bytes, value);
}

void CommandList::blit_mip(const Image& image, uint32_t from_mip) {
    PARHELION_CHECK(from_mip + 1 < image.desc().mip_count, "image {} has no mip {}", image.name(), from_mip + 1);
    if (!impl_->device->impl().physical.queue_has_graphics)
        throw Error(ErrorCode::MissingFeature, "its queue cannot filter images into mip levels", impl_->device->caps().name);
    const Extent from = mip_extent(image.desc(), from_mip), to = mip_extent(image.desc(), from_mip + 1);
    VkImageBlit region{};
    region.srcSubresource = layers(image, from_mip);
    region.srcOffsets[1] = {static_cast<int32_t>(from.width), static_cast<int32_t>(from.height), 1};
    region.dstSubresource = layers(image, from_mip + 1);
    region.dstOffsets[1] = {static_cast<int32_t>(to.width), static_cast<int32_t>(to.height), 1};
    const VkImage handle = image.data()->handle;
    impl_->vk().vkCmdBlitImage(impl_->buffer, handle, VK_IMAGE_LAYOUT_GENERAL, handle, VK_IMAGE_LAYOUT_GENERAL, 1, &region, VK_FILTER_LINEAR);
}

void CommandList::Impl::blit(const Image& from, VkImage to, const Extent& extent, VkImageLayout layout) {
    if (!device->impl().physical.queue_has_graphics) throw Error(ErrorCode::MissingFeature, "its queue cannot scale images", device->caps().name);
    VkImageBlit region{};
    region.srcSubresource = region.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.srcOffsets[1] = {static_cast<int32_t>(from.extent().width), static_cast<int32_t>(from.extent().height), 1};
    region.dstOffsets[1] = {static_cast<int32_t>(extent.width), static_cast<int32_t>(extent.height), 1};
    const VkFilter filter = from.extent() == extent ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
    vk().vkCmdBlitImage(buffer, from.data()->handle, VK_IMAGE_LAYOUT_GENERAL, to, layout, 1, &region, filter);
}

void CommandList::scale(const Image& from, const Image& to) { impl_->blit(from, to.data()->handle, to.extent(), VK_IMAGE_LAYOUT_GENERAL); }

void CommandList::build_blas(std::span<const BlasBuild> builds, const Buffer& scratch) {
    std::vector<BlasInfo> infos(builds.size());
    std::vector<VkAccelerationStructureBuildGeometryInfoKHR> headers;
    std::vector<const VkAccelerationStructureBuildRangeInfoKHR*> ranges;
    uint64_t offset = 0;
    for (size_t i = 0; i < builds.size(); ++i) {
        infos[i].fill(builds[i], scratch_address(builds[i].blas, scratch, offset, impl_->device->caps().scratch_alignment));
        offset += builds[i].blas.scratch_bytes();
        headers.push_back(infos[i].header);
        ranges.push_back(infos[i].ranges.data());
    }
    impl_->vk().vkCmdBuildAccelerationStructuresKHR(impl_->buffer, static_cast<uint32_t>(headers.size()), headers.data(), ranges.data());
}

void CommandList::measure_blas(std::span<const AccelStruct> blases, const AccelSizes& sizes) {
    PARHELION_CHECK(blases.size() == sizes.count(), "{} bottom levels are measured into room for {}", blases.size(), sizes.count());
    std::vector<VkAccelerationStructureKHR> handles;
    for (const AccelStruct& blas : blases) handles.push_back(blas.data()->handle);
    impl_->vk().vkCmdResetQueryPool(impl_->buffer, sizes.data()->pool, 0, sizes.count());
    impl_->vk().vkCmdWriteAccelerationStructuresPropertiesKHR(impl_->buffer, sizes.count(), handles.data(), VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR,
                                                              sizes.data()->pool, 0);
}

void CommandList::compact_blas(const AccelStruct& from, const AccelStruct& to) {
    VkCopyAccelerationStructureInfoKHR info{VK_STRUCTURE_TYPE_COPY_ACCELERATION_STRUCTURE_INFO_KHR};
    info.src = from.data()->handle;
    info.dst = to.data()->handle;
    info.mode = VK_COPY_ACCELERATION_STRUCTURE_MODE_COMPACT_KHR;
    impl_->vk().vkCmdCopyAccelerationStructureKHR(impl_->buffer, &info);
}

void CommandList::build_tlas(const AccelStruct& tlas, const Buffer& instances, uint64_t offset, uint32_t count, const Buffer& scratch, uint64_t scratch_offset) {
    const AccelStruct::Data& data = *tlas.data();
    PARHELION_CHECK(data.sizes.empty() && count <= data.max_instances, "{} instances in {}, which has room for {}", count, data.name, data.max_instances);
    PARHELION_CHECK(offset % 16 == 0, "instances at {} of {} are not aligned to 16 bytes", offset, instances.name());
    check_range(instances, offset, uint64_t(count) * sizeof(TlasInstance));
    const VkAccelerationStructureGeometryKHR geometry = instance_geometry(instances.address() + offset);
    VkAccelerationStructureBuildGeometryInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
    info.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
    info.flags = kTopFlags;
    info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.dstAccelerationStructure = data.handle;
    info.geometryCount = 1;
    info.pGeometries = &geometry;
    info.scratchData.deviceAddress = scratch_address(tlas, scratch, scratch_offset, impl_->device->caps().scratch_alignment);
    const VkAccelerationStructureBuildRangeInfoKHR range{count, 0, 0, 0};
    const VkAccelerationStructureBuildRangeInfoKHR* first = &range;
    impl_->vk().vkCmdBuildAccelerationStructuresKHR(impl_->buffer, 1, &info, &first);
}

TimerPool::TimerPool(const DevicePtr& device, uint32_t count) {
    Device::Impl& impl = device->impl();
    PARHELION_CHECK(count > 0 && device->caps().timestamp_period_ns > 0, "{} timestamps on {}", count, device->caps().name);
    auto data = std::make_shared<Data>();
    data->device = device;
    data->count = count;
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = count;
    PARHELION_VK(impl.name(), impl.vk.vkCreateQueryPool(impl.device, &info, nullptr, &data->pool));
    data_ = std::move(data);
}

TimerPool::Data::~Data() {
    Device::Impl& impl = device->impl();
    if (pool) impl.vk.vkDestroyQueryPool(impl.device, pool, nullptr);
}

uint32_t TimerPool::count() const { return data_->count; }

std::vector<double> TimerPool::read_ms(uint32_t count) const {
    PARHELION_CHECK(count <= data_->count, "{} of {} timers", count, data_->count);
    Device::Impl& impl = data_->device->impl();
    std::vector<uint64_t> ticks(count);
    if (count == 0) return {};
    PARHELION_VK(impl.name(), impl.vk.vkGetQueryPoolResults(impl.device, data_->pool, 0, count, count * sizeof(uint64_t), ticks.data(), sizeof(uint64_t), VK_QUERY_RESULT_64_BIT));
    // Counters have as many bits as the queue says and may wrap around.
    const uint64_t mask = impl.physical.timestamp_bits >= 64 ? ~0ull : (1ull << impl.physical.timestamp_bits) - 1;
    std::vector<double> out;
    for (const uint64_t tick : ticks) out.push_back(static_cast<double>((tick - ticks[0]) & mask) * impl.physical.caps.timestamp_period_ns * 1e-6);
    return out;
}

void CommandList::reset_timers(const TimerPool& pool) { impl_->vk().vkCmdResetQueryPool(impl_->buffer, pool.data()->pool, 0, pool.count()); }

// Both ends of a pass are taken when all earlier commands are done, so that times of consecutive passes do not overlap.
void CommandList::write_timer(const TimerPool& pool, uint32_t index) {
    PARHELION_CHECK(index < pool.count(), "timer {} of {}", index, pool.count());
    impl_->vk().vkCmdWriteTimestamp2(impl_->buffer, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool.data()->pool, index);
}

// The barrier orders memory of the marker alone: other hazards stay visible to validation.
void CommandList::write_marker(const Buffer& readback, uint32_t value) {
    VkBufferMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_BUFFER_MEMORY_BARRIER_2};
    barrier.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    barrier.dstStageMask = VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT;
    barrier.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.buffer = readback.data()->raw.handle;
    barrier.size = VK_WHOLE_SIZE;
    VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    info.bufferMemoryBarrierCount = 1;
    info.pBufferMemoryBarriers = &barrier;
    impl_->vk().vkCmdPipelineBarrier2(impl_->buffer, &info);
    impl_->vk().vkCmdFillBuffer(impl_->buffer, readback.data()->raw.handle, 0, sizeof(uint32_t), value);
}

}  // namespace parhelion::gpu
