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

// Small uploads share a buffer.
Frame::Staging Frame::stage(uint64_t bytes) {
    constexpr uint64_t kBlock = 1 << 18, kAlignment = 16;  // texels are up to 16 bytes
    if (!staging_.buffer || bytes > staging_.buffer.bytes() - std::min(staging_.offset, staging_.buffer.bytes()))
        staging_ = {gpu::Buffer(device_, "frame/upload", std::max(bytes, kBlock), gpu::MemoryKind::Upload), 0};
    const Staging out = staging_;
    staging_.offset += (bytes + kAlignment - 1) / kAlignment * kAlignment;
    return out;
}

std::span<std::byte> Frame::upload_in_place(const gpu::Buffer& to, uint64_t offset, uint64_t bytes) {
    PARHELION_CHECK(offset <= to.bytes() && bytes <= to.bytes() - offset, "an upload to {} is out of range", to.name());
    const Staging staging = stage(bytes);
    const bool joins = upload_ && upload_end_ == records_.size() && upload_->from.id() == staging.buffer.id() && upload_->to.id() == to.id() &&
                       offset >= upload_->regions.back()[1] + upload_->regions.back()[2];
    if (!joins) {
        keep(staging.buffer.data());
        keep(to.data());
        upload_ = std::make_shared<Upload>(Upload{staging.buffer, to, {}});
        add({.info = {.name = "transfer/upload", .reads = {staging.buffer.name()}, .writes = {to.name()}},
             .accesses = {{staging.buffer.id(), Use::TransferRead, &staging.buffer.name()}, {to.id(), Use::TransferWrite, &to.name()}},
             .launch = [upload = upload_](gpu::CommandList& commands) {
                 for (const auto& [from, into, count] : upload->regions) commands.copy(upload->from, from, upload->to, into, count);
             }});
        upload_end_ = records_.size();
    }
    upload_->regions.push_back({staging.offset, offset, bytes});
    return {staging.buffer.mapped() + staging.offset, bytes};
}

void Frame::upload(const gpu::Buffer& to, uint64_t offset, std::span<const std::byte> bytes) {
    if (!bytes.empty()) std::memcpy(upload_in_place(to, offset, bytes.size()).data(), bytes.data(), bytes.size());
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

std::span<std::byte> Frame::upload_rows_in_place(const gpu::Image& to, uint32_t mip, uint32_t first_row, uint32_t rows) {
    const uint64_t bytes = gpu::format_bytes(to.desc().format, mip_side(to.extent().width, mip), rows);
    const Staging staging = stage(bytes);
    keep(staging.buffer.data());
    keep(to.data());
    add({.info = {.name = "transfer/upload_image", .reads = {staging.buffer.name()}, .writes = {to.name()}},
         .accesses = {{staging.buffer.id(), Use::TransferRead, &staging.buffer.name()}, {to.id(), Use::TransferWrite, &to.name()}},
         .images = {to},
         .launch = [=](gpu::CommandList& commands) { commands.copy_to_image(staging.buffer, staging.offset, to, mip, first_row, rows); }});
    return {staging.buffer.mapped() + staging.offset, bytes};
}

void Frame::upload_image(const gpu::Image& to, std::span<const std::byte> texels, uint32_t mips) {
    uint64_t bytes = 0;
    for (uint32_t mip = 0; mip < mips; ++mip) bytes += mip_bytes(to, mip);
    PARHELION_CHECK(mips <= to.desc().mip_count && texels.size() == bytes, "{}: {} bytes of texels do not fill {} mips", to.name(), texels.size(), mips);
    for (uint32_t mip = 0; mip < mips; ++mip) {
        const std::span<const std::byte> level = texels.first(mip_bytes(to, mip));
        std::memcpy(upload_rows_in_place(to, mip, 0, mip_side(to.extent().height, mip)).data(), level.data(), level.size());
        texels = texels.subspan(level.size());
    }
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

void Frame::scale(const gpu::Image& from, const gpu::Image& to) {
    keep(from.data());
    keep(to.data());
    add({.info = {.name = "transfer/scale", .reads = {from.name()}, .writes = {to.name()}},
         .accesses = {{from.id(), Use::TransferRead, &from.name()}, {to.id(), Use::TransferWrite, &to.name()}},
         .images = {from, to},
         .launch = [=](gpu::CommandList& commands) { commands.scale(from, to); }});
}

void Frame::show(const gpu::Image& from, gpu::Swapchain& window) {
    keep(from.data());
    window_ = &window;
    add({.info = {.name = "transfer/show", .reads = {from.name()}, .writes = {"window"}},
         .accesses = {{from.id(), Use::TransferRead, &from.name()}},
         .images = {from},
         .launch = [from, &window](gpu::CommandList& commands) { commands.copy_to_window(from, window); }});
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

void Frame::build_blas(std::vector<gpu::BlasBuild> builds, const std::vector<gpu::Buffer>& inputs) {
    uint64_t scratch_bytes = 0;
    for (const gpu::BlasBuild& build : builds) scratch_bytes += build.blas.scratch_bytes();
    const gpu::Buffer scratch(device_, "frame/build_scratch", scratch_bytes);
    const bool refit = static_cast<bool>(builds.front().refit_from);
    Record record{.info = {.name = refit ? "build/refit" : "build/bottom", .writes = {builds.front().blas.name()}, .extent = fmt::format("{}", builds.size())},
                  .accesses = {{scratch.id(), Use::BuildScratch, &scratch.name()}}};
    if (refit) record.info.reads.push_back(builds.front().refit_from.name());
    for (const gpu::BlasBuild& build : builds) {
        PARHELION_CHECK(static_cast<bool>(build.refit_from) == refit, "{} is built among refits, or refitted among builds", build.blas.name());
        record.accesses.push_back({build.blas.id(), Use::BuildWrite, &build.blas.name()});
        keep(build.blas.data());
        if (!refit) continue;
        record.accesses.push_back({build.refit_from.id(), Use::BuildRead, &build.refit_from.name()});
        keep(build.refit_from.data());
    }
    for (const gpu::Buffer& input : inputs) {
        record.info.reads.push_back(input.name());
        record.accesses.push_back({input.id(), Use::BuildInput, &input.name()});
        keep(input.data());
    }
    keep(scratch.data());
    record.launch = [scratch, builds = std::move(builds)](gpu::CommandList& commands) { commands.build_blas(builds, scratch); };
    add(std::move(record));
}

void Frame::measure_blas(std::vector<gpu::AccelStruct> blases, const gpu::AccelSizes& sizes) {
    Record record{.info = {.name = "build/measure", .reads = {blases.front().name()}, .extent = fmt::format("{}", blases.size())}};
    for (const gpu::AccelStruct& blas : blases) {
        record.accesses.push_back({blas.id(), Use::BuildRead, &blas.name()});
        keep(blas.data());
    }
    keep(sizes.data());
    record.launch = [sizes, blases = std::move(blases)](gpu::CommandList& commands) { commands.measure_blas(blases, sizes); };
    add(std::move(record));
}

void Frame::compact_blas(const gpu::AccelStruct& from, const gpu::AccelStruct& to) {
    keep(from.data());
    keep(to.data());
    add({.info = {.name = "build/compact", .reads = {from.name()}, .writes = {to.name()}},
         .accesses = {{from.id(), Use::BuildRead, &from.name()}, {to.id(), Use::BuildWrite, &to.name()}},
         .launch = [=](gpu::CommandList& commands) { commands.compact_blas(from, to); }});
}

void Frame::build_tlas(const gpu::AccelStruct& tlas, const gpu::Buffer& instances, uint32_t count, std::span<const gpu::AccelStruct> bottoms) {
    const gpu::Buffer scratch(device_, "frame/build_scratch", tlas.scratch_bytes());
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
