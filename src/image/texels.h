#pragma once
// Texels as devices read them: plain or in blocks, with all stored levels; and the decoding of blocks on the host.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace parhelion::image {

// Four bytes a texel, or blocks of 4 x 4 texels (Khronos Data Format 1.3, 18 to 20). Bc1Rgb has no alpha: what is transparent
// black in Bc1 is opaque black there. Whether colours are sRGB or linear is not said by the format.
enum class TexelFormat { Rgba8, Bc1Rgb, Bc1, Bc3, Bc4, Bc5, Bc7 };
uint64_t block_bytes(TexelFormat format);  // of a block; of a texel for Rgba8

uint64_t level_bytes(TexelFormat format, uint32_t width, uint32_t height);  // of one level of that size
uint64_t image_bytes(TexelFormat format, uint32_t width, uint32_t height, uint32_t level_count);

// Rows from the top. Level i is max(1, width >> i) x max(1, height >> i) texels.
struct Texels {
    uint32_t width = 0, height = 0;
    TexelFormat format = TexelFormat::Rgba8;
    uint32_t level_count = 1;
    std::vector<uint8_t> bytes = {};  // all levels, finest first
};

// One block (block_bytes(format) bytes) to 16 RGBA texels, row by row. What a format lacks is as Vulkan gives it: Bc4 is
// (r, 0, 0, 1), Bc5 (r, g, 0, 1). BC7 is exact; the others are rounded to the nearest of 256 steps.
void decode_block(TexelFormat format, const uint8_t* block, uint8_t* rgba);

// All levels as Rgba8. `bytes` are as long as image_bytes() says.
std::vector<uint8_t> decode_to_rgba8(TexelFormat format, uint32_t width, uint32_t height, uint32_t level_count,
                                     std::span<const uint8_t> bytes);

}  // namespace parhelion::image
