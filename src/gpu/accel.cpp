// Acceleration structures: memory and handles; CommandList builds them.
#include <algorithm>

#include "gpu/internal.h"

namespace parhelion::gpu {

namespace {

void require_accel(const Device::Impl& device, const std::string& name) {
    PARHELION_CHECK(device.has_accel, "{} on {}, which has no acceleration structures", name, device.name());
}

// Makes the structure in memory of this many bytes.
void create_handle(AccelStruct::Data& data, VkAccelerationStructureTypeKHR type, uint64_t bytes) {
    Device::Impl& impl = data.device->impl();
    data.storage = impl.create_buffer(data.name, std::max<uint64_t>(bytes, 256), Placement::Device);
    VkAccelerationStructureCreateInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
    info.buffer = data.storage.handle;
    info.size = data.storage.bytes;
    info.type = type;
    PARHELION_VK(impl.name(), impl.vk.vkCreateAccelerationStructureKHR(impl.device, &info, nullptr, &data.handle));
    impl.set_name(VK_OBJECT_TYPE_ACCELERATION_STRUCTURE_KHR, data.handle, data.name);
    VkAccelerationStructureDeviceAddressInfoKHR address{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
    address.accelerationStructure = data.handle;
    data.address = impl.vk.vkGetAccelerationStructureDeviceAddressKHR(impl.device, &address);
}

// Fills in handle, memory and sizes for a structure of these geometries.
void create(AccelStruct::Data& data, VkAccelerationStructureTypeKHR type, std::span<const VkAccelerationStructureGeometryKHR> geometries, std::span<const uint32_t> counts) {
    Device::Impl& impl = data.device->impl();
    VkAccelerationStructureBuildGeometryInfoKHR build{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
    build.type = type;
    build.flags = data.flags;
    build.geometryCount = static_cast<uint32_t>(geometries.size());
    build.pGeometries = geometries.data();
    VkAccelerationStructureBuildSizesInfoKHR sizes{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    impl.vk.vkGetAccelerationStructureBuildSizesKHR(impl.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &build, counts.data(), &sizes);
    data.scratch_bytes = std::max<uint64_t>({sizes.buildScratchSize, sizes.updateScratchSize, 1}) + impl.physical.caps.scratch_alignment;
    create_handle(data, type, sizes.accelerationStructureSize);
}

}  // namespace

VkAccelerationStructureGeometryKHR triangle_geometry(const BlasGeometry& geometry) {
    VkAccelerationStructureGeometryKHR out{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    out.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    out.flags = geometry.opaque ? VK_GEOMETRY_OPAQUE_BIT_KHR : VK_GEOMETRY_NO_DUPLICATE_ANY_HIT_INVOCATION_BIT_KHR;
    VkAccelerationStructureGeometryTrianglesDataKHR& triangles = out.geometry.triangles;
    triangles.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
    triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    triangles.vertexData.deviceAddress = geometry.positions;
    triangles.vertexStride = 12;
    triangles.maxVertex = std::max(geometry.vertex_count, 1u) - 1;
    triangles.indexType = VK_INDEX_TYPE_UINT32;
    triangles.indexData.deviceAddress = geometry.indices;
    return out;
}

VkAccelerationStructureGeometryKHR instance_geometry(uint64_t instances_address) {
    static_assert(sizeof(TlasInstance) == sizeof(VkAccelerationStructureInstanceKHR));
    VkAccelerationStructureGeometryKHR out{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    out.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    out.geometry.instances.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
    out.geometry.instances.data.deviceAddress = instances_address;
    return out;
}

AccelStruct AccelStruct::bottom(const DevicePtr& device, std::string name, std::span<const BlasGeometry> geometries, BlasClass blas_class) {
    require_accel(device->impl(), name);
    auto data = std::make_shared<Data>();
    data->flags = blas_class == BlasClass::Deforming ? kDeformingFlags : kStaticFlags;
    data->device = device;
    data->name = std::move(name);
    PARHELION_CHECK(!geometries.empty(), "{} has no geometry", data->name);
    std::vector<VkAccelerationStructureGeometryKHR> triangles;
    std::vector<uint32_t> counts;
    for (const BlasGeometry& geometry : geometries) {
        triangles.push_back(triangle_geometry(geometry));
        counts.push_back(geometry.triangle_count);
        data->sizes.emplace_back(geometry.vertex_count, geometry.triangle_count);
    }
    create(*data, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, triangles, counts);
    AccelStruct out;
    out.data_ = std::move(data);
    return out;
}

AccelStruct AccelStruct::compacted(const DevicePtr& device, std::string name, uint64_t bytes) {
    require_accel(device->impl(), name);
    auto data = std::make_shared<Data>();
    data->device = device;
    data->name = std::move(name);
    create_handle(*data, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, bytes);
    AccelStruct out;
    out.data_ = std::move(data);
    return out;
}

AccelStruct AccelStruct::top(const DevicePtr& device, std::string name, uint32_t max_instances) {
    require_accel(device->impl(), name);
    auto data = std::make_shared<Data>();
    data->device = device;
    data->name = std::move(name);
    data->max_instances = max_instances;
    const VkAccelerationStructureGeometryKHR geometry = instance_geometry(0);
    create(*data, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, {&geometry, 1}, {&max_instances, 1});
    AccelStruct out;
    out.data_ = std::move(data);
    return out;
}

AccelStruct::Data::~Data() {
    Device::Impl& impl = device->impl();
    if (handle) impl.vk.vkDestroyAccelerationStructureKHR(impl.device, handle, nullptr);
    impl.destroy_buffer(name, storage);
}

uint64_t AccelStruct::address() const { return data_->address; }
bool AccelStruct::deforming() const { return data_->flags == kDeformingFlags; }
uint64_t AccelStruct::bytes() const { return data_->storage.bytes; }
uint64_t AccelStruct::scratch_bytes() const { return data_->scratch_bytes; }
const std::string& AccelStruct::name() const { return data_->name; }

AccelSizes::AccelSizes(const DevicePtr& device, uint32_t count) {
    Device::Impl& impl = device->impl();
    require_accel(impl, "compacted sizes");
    auto data = std::make_shared<Data>();
    data->device = device;
    data->count = count;
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;
    info.queryCount = count;
    PARHELION_VK(impl.name(), impl.vk.vkCreateQueryPool(impl.device, &info, nullptr, &data->pool));
    data_ = std::move(data);
}

AccelSizes::Data::~Data() {
    Device::Impl& impl = device->impl();
    if (pool) impl.vk.vkDestroyQueryPool(impl.device, pool, nullptr);
}

uint32_t AccelSizes::count() const { return data_->count; }

std::vector<uint64_t> AccelSizes::read() const {
    Device::Impl& impl = data_->device->impl();
    std::vector<uint64_t> bytes(data_->count);
    const VkResult result = impl.vk.vkGetQueryPoolResults(impl.device, data_->pool, 0, data_->count, bytes.size() * sizeof(uint64_t), bytes.data(), sizeof(uint64_t),
                                                          VK_QUERY_RESULT_64_BIT);
    if (result == VK_NOT_READY) return {};
    check_result(result, "vkGetQueryPoolResults", impl.name());
    return bytes;
}

}  // namespace parhelion::gpu
