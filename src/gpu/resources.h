#pragma once
// Buffers, images, samplers and acceleration structures: cheap handles to shared, reference-counted GPU objects. Every object
// has a name ("group/what"), which is its debug name and its memory group.
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "gpu/device.h"

namespace parhelion::gpu {

enum class Format : uint32_t {
    Undefined, R8Unorm, Rg8Unorm, Rgba8Unorm, Rgba8Srgb, R16Float, Rg16Float, Rgba16Float, R32Float, Rg32Float, Rgba32Float, R32Uint, Rgba32Uint, Depth32Float,
    // Blocks of 4 x 4 texels, sampled only; on devices with DeviceCaps::block_compression.
    Bc1RgbUnorm, Bc1RgbSrgb, Bc1Unorm, Bc1Srgb, Bc3Unorm, Bc3Srgb, Bc4Unorm, Bc5Unorm, Bc7Unorm, Bc7Srgb,
};
uint32_t format_block(Format format);  // texels along the side of a block: 4, or 1 for plain formats
uint64_t format_bytes(Format format, uint64_t width = 1, uint64_t height = 1);  // of that many texels, whole blocks
std::string_view format_name(Format format);

struct Extent {
    uint32_t width = 1, height = 1, depth = 1;
    friend bool operator==(const Extent&, const Extent&) = default;
};

enum class MemoryKind {
    Device,    // fastest for the GPU, not mapped
    Upload,    // mapped, written by the host
    Readback,  // mapped, cached, read by the host
};

// How a command uses a resource. Frame derives barriers from it; gpu maps it to Vulkan stages and access.
enum class Use : uint32_t {
    ComputeRead, ComputeWrite, ComputeReadWrite,  // storage access or buffer reference in a compute shader
    TraceRead, TraceWrite, TraceReadWrite,        // the same in ray tracing shaders
    ComputeSample, TraceSample,                   // sampled image
    ComputeAccel, TraceAccel,                     // acceleration structure read by a ray query / by traceRayEXT
    RasterRead, RasterSample,                     // by address or binding, as an image, in vertex and fragment shaders
    ColorAttachment, DepthAttachment,             // read and written
    IndirectRead, TransferRead, TransferWrite,
    BuildInput,                                   // geometry or instances read by an acceleration structure build
    BuildWrite, BuildRead, BuildScratch,          // acceleration structure written, read (TLAS over BLAS, compaction), scratch
    HostRead, HostWrite,
};
bool use_writes(Use use);
bool use_reads(Use use);
std::string_view use_name(Use use);

class Buffer {
public:
    Buffer() = default;
    // All buffers can be used in every way and have a device address. Never fails silently: throws Error naming bytes and name.
    Buffer(const DevicePtr& device, std::string name, uint64_t bytes, MemoryKind kind = MemoryKind::Device);

    explicit operator bool() const { return data_ != nullptr; }
    uint64_t bytes() const;
    uint64_t address() const;  // device address, aligned to at least 256
    const std::string& name() const;
    std::byte* mapped() const;  // Upload and Readback only
    template <class T>
    std::span<T> mapped_as() const {
        return {reinterpret_cast<T*>(mapped()), bytes() / sizeof(T)};
    }
    const void* id() const { return data_.get(); }  // identity for hazard tracking

    struct Data;
    const std::shared_ptr<Data>& data() const { return data_; }

private:
    std::shared_ptr<Data> data_;
};

struct ImageDesc {
    Format format = Format::Rgba32Float;
    Extent extent;
    uint32_t mip_count = 1;
};

// Images live in the GENERAL layout from their first use on (a compute renderer writes storage images, which need it).
class Image {
public:
    Image() = default;
    Image(const DevicePtr& device, std::string name, const ImageDesc& desc);
    // An image of the host program: it must be in GENERAL and have storage (and transfer) usage.
    static Image borrow(const DevicePtr& device, std::string name, const ImageDesc& desc, VkImage image);

    explicit operator bool() const { return data_ != nullptr; }
    const ImageDesc& desc() const;
    Extent extent() const { return desc().extent; }
    const std::string& name() const;
    bool needs_layout() const;  // no command list has recorded initialise_layout() for it yet
    const void* id() const { return data_.get(); }

    struct Data;
    const std::shared_ptr<Data>& data() const { return data_; }

private:
    std::shared_ptr<Data> data_;
};

enum class Wrap { Repeat, Mirror, Clamp };
enum class Filter { Nearest, Linear };
struct SamplerDesc {
    Wrap wrap_u = Wrap::Repeat, wrap_v = Wrap::Repeat;
    Filter mag = Filter::Linear, min = Filter::Linear, mip = Filter::Linear;
    friend bool operator==(const SamplerDesc&, const SamplerDesc&) = default;
};

class Sampler {
public:
    Sampler() = default;
    Sampler(const DevicePtr& device, const SamplerDesc& desc);  // equal descriptions share one object
    explicit operator bool() const { return data_ != nullptr; }
    struct Data;
    const std::shared_ptr<Data>& data() const { return data_; }

private:
    std::shared_ptr<Data> data_;
};

// Triangles of one geometry of a bottom-level structure. Addresses are device addresses.
struct BlasGeometry {
    uint64_t positions = 0;  // tightly packed 3 x float32 in object space
    uint32_t vertex_count = 0;
    uint64_t indices = 0;  // uint32 triples
    uint32_t triangle_count = 0;
    bool opaque = true;  // false: any-hit runs, once per triangle
};

// One instance as Vulkan lays it out (VkAccelerationStructureInstanceKHR, 64 bytes).
struct TlasInstance {
    float world_from_object[12];  // row-major 3x4
    uint32_t custom_index_and_mask;  // 24 bits custom index, 8 bits mask
    uint32_t sbt_offset_and_flags;   // 24 bits hit group offset, 8 bits VkGeometryInstanceFlagBitsKHR
    uint64_t blas_address;
};
static_assert(sizeof(TlasInstance) == 64);
constexpr uint32_t kInstanceDisableCulling = 1;  // VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR
constexpr uint32_t kInstanceForceOpaque = 4;     // VK_GEOMETRY_INSTANCE_FORCE_OPAQUE_BIT_KHR
constexpr uint32_t kInstanceForceNoOpaque = 8;   // VK_GEOMETRY_INSTANCE_FORCE_NO_OPAQUE_BIT_KHR

// Static bottom levels can be compacted; deforming ones can be refitted to other positions instead of being built.
enum class BlasClass { Static, Deforming };

class AccelStruct {
public:
    AccelStruct() = default;
    // Bottom level for these geometries; build it with CommandList::build_blas.
    static AccelStruct bottom(const DevicePtr& device, std::string name, std::span<const BlasGeometry> geometries, BlasClass blas_class = BlasClass::Static);
    // Bottom level that takes a compacted copy of this size (CommandList::compact_blas; the size is one of AccelSizes).
    static AccelStruct compacted(const DevicePtr& device, std::string name, uint64_t bytes);
    // Top level for up to max_instances instances.
    static AccelStruct top(const DevicePtr& device, std::string name, uint32_t max_instances);

    explicit operator bool() const { return data_ != nullptr; }
    uint64_t address() const;        // for TlasInstance::blas_address
    uint64_t bytes() const;
    uint64_t scratch_bytes() const;  // for a build or a refit, alignment included
    bool deforming() const;
    const std::string& name() const;
    const void* id() const { return data_.get(); }

    struct Data;
    const std::shared_ptr<Data>& data() const { return data_; }

private:
    std::shared_ptr<Data> data_;
};

// The bytes that built bottom levels would need if they were compacted: the device writes them (CommandList::measure_blas).
class AccelSizes {
public:
    AccelSizes() = default;
    AccelSizes(const DevicePtr& device, uint32_t count);
    explicit operator bool() const { return data_ != nullptr; }
    uint32_t count() const;
    // Call after the commands that write them are done. Empty: the device has not written them.
    std::vector<uint64_t> read() const;
    struct Data;
    const std::shared_ptr<Data>& data() const { return data_; }

private:
    std::shared_ptr<Data> data_;
};

}  // namespace parhelion::gpu
