// Transfers and acceleration structure builds as passes.
#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "frame/frame.h"

namespace parhelion {

using gpu::Use;

namespace {

uint32_t mip_side(uint32_t side, uint32_t mip) { return std::max(side >> mip, 1u); }

uint64_t mip_bytes(const gpu::Image& image, uint32_t mip) {
    return gpu::format_bytes(image.desc().format, mip_side(image.extent().width, mip), mip_side(image.extent().height, mip));
}

}  // namespace

void Frame::upload(const gpu::Buffer& to, uint64_t offset, std::span<const std::byte> bytes) {
    if (bytes.empty()) return;
    const gpu::Buffer staging(device_, "frame/upload", bytes.size(), gpu::MemoryKind::Upload);
    std::memcpy(staging.mapped(), bytes.data(), bytes.size());
    copy(staging, 0, to, offset, bytes.size());
}

void Frame::copy(const gpu::Buffer& from, uint64_t from_offset, const gpu::Buffer& to, uint64_t to_offset, uint64_t bytes) {
    PARHELION_CHECK(from_offset + bytes <= from.bytes() && to_offset + bytes <= to.bytes(), "copy {} -> {} is out of range", from.name(), to.name());
    keep(from.data());
    keep(to.data());
    add({.info = {.name = "transfer/copy", .reads = {from.name()}, .writes = {to.name()}},
         .accesses = {{from.id(), Use::TransferRead, &from.name()}, {to.id(), Use::TransferWrite, &to.name()}},
         .launch = [=](gpu::CommandList& commands) { commands.copy(from, from_offset, to, to_offset, bytes); }});
}

void Frame::fill(const gpu::Buffer& buffer, uint32_t value) {
    keep(buffer.data());
    add({.info = {.name = "transfer/fill", .writes = {buffer.name()}},
         .accesses = {{buffer.id(), Use::TransferWrite, &buffer.name()}},
         .launch = [=](gpu::CommandList& commands) { commands.fill(buffer, 0, buffer.bytes(), value); }});
}

void Frame::upload_image(const gpu::Image& to, std::span<const std::byte> texels, uint32_t mips) {
    uint64_t bytes = 0;
    for (uint32_t mip = 0; mip < mips; ++mip) bytes += mip_bytes(to, mip);
    PARHELION_CHECK(mips <= to.desc().mip_count && texels.size() == bytes, "{}: {} bytes of texels do not fill {} mips", to.name(), texels.size(), mips);
    const gpu::Buffer staging(device_, "frame/upload", texels.size(), gpu::MemoryKind::Upload);
    std::memcpy(staging.mapped(), texels.data(), texels.size());
    keep(staging.data());
    keep(to.data());
    add({.info = {.name = "transfer/upload_image", .reads = {staging.name()}, .writes = {to.name()}},
         .accesses = {{staging.id(), Use::TransferRead, &staging.name()}, {to.id(), Use::TransferWrite, &to.name()}},
         .images = {to},
         .launch = [=](gpu::CommandList& commands) {
             uint64_t offset = 0;
             for (uint32_t mip = 0; mip < mips; ++mip) {
                 commands.copy_to_image(staging, offset, to, mip, 0, mip_side(to.extent().height, mip));
                 offset += mip_bytes(to, mip);
             }
         }});
}

void Frame::make_mips(const gpu::Image& image) {
    keep(image.data());
    // Each level reads the one above it: one pass a level, so that the barrier between them is found like any other.
    for (uint32_t mip = 0; mip + 1 < image.desc().mip_count; ++mip)
        add({.info = {.name = "transfer/mip", .reads = {image.name()}, .writes = {image.name()}},
             .accesses = {{image.id(), Use::TransferRead, &image.name()}, {image.id(), Use::TransferWrite, &image.name()}},
             .images = {image},
             .launch = [=](gpu::CommandList& commands) { commands.blit_mip(image, mip); }});
}

gpu::Buffer Frame::read_back(const gpu::Buffer& from) {
    const gpu::Buffer to(device_, "frame/readback", from.bytes(), gpu::MemoryKind::Readback);
    copy(from, 0, to, 0, from.bytes());
    return to;
}

gpu::Buffer Frame::read_back(const gpu::Image& from) {
    const gpu::Extent extent = from.extent();
    const gpu::Buffer to(device_, "frame/readback", gpu::format_bytes(from.desc().format, extent.width, extent.height), gpu::MemoryKind::Readback);
    keep(from.data());
    keep(to.data());
    add({.info = {.name = "transfer/read_back", .reads = {from.name()}, .writes = {to.name()}},
         .accesses = {{from.id(), Use::TransferRead, &from.name()}, {to.id(), Use::TransferWrite, &to.name()}},
         .images = {from},
         .launch = [=](gpu::CommandList& commands) { commands.copy_from_image(from, to, 0); }});
    return to;
}

void Frame::build_blas(const gpu::AccelStruct& blas, std::vector<gpu::BlasGeometry> geometries, std::vector<gpu::Buffer> inputs) {
    const gpu::Buffer scratch = buffer("frame/build_scratch", std::max(blas.scratch_bytes(), buffers_["frame/build_scratch"] ? buffers_["frame/build_scratch"].bytes() : 0));
    Record record{.info = {.name = "build/bottom", .writes = {blas.name()}},
                  .accesses = {{blas.id(), Use::BuildWrite, &blas.name()}, {scratch.id(), Use::BuildScratch, &scratch.name()}}};
    for (const gpu::Buffer& input : inputs) {
        record.info.reads.push_back(input.name());
        record.accesses.push_back({input.id(), Use::BuildInput, &input.name()});
        keep(input.data());
    }
    keep(blas.data());
    keep(scratch.data());
    record.launch = [=, geometries = std::move(geometries)](gpu::CommandList& commands) { commands.build_blas(blas, geometries, scratch, 0); };
    add(std::move(record));
}

void Frame::build_tlas(const gpu::AccelStruct& tlas, const gpu::Buffer& instances, uint32_t count, std::span<const gpu::AccelStruct> bottoms) {
    const gpu::Buffer scratch = buffer("frame/build_scratch", std::max(tlas.scratch_bytes(), buffers_["frame/build_scratch"] ? buffers_["frame/build_scratch"].bytes() : 0));
    Record record{.info = {.name = "build/top", .reads = {instances.name()}, .writes = {tlas.name()}},
                  .accesses = {{tlas.id(), Use::BuildWrite, &tlas.name()},
                               {scratch.id(), Use::BuildScratch, &scratch.name()},
                               {instances.id(), Use::BuildInput, &instances.name()}}};
    for (const gpu::AccelStruct& bottom : bottoms) {
        record.accesses.push_back({bottom.id(), Use::BuildRead, &bottom.name()});
        keep(bottom.data());
    }
    keep(tlas.data());
    keep(instances.data());
    keep(scratch.data());
    record.launch = [=](gpu::CommandList& commands) { commands.build_tlas(tlas, instances, 0, count, scratch, 0); };
    add(std::move(record));
}

}  // namespace parhelion
