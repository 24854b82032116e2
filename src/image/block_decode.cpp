// Blocks of BC1 to BC5, and images of blocks. Khronos Data Format 1.3, 18 (S3TC: BC1 to BC3) and 19 (RGTC: BC4, BC5).
#include <algorithm>
#include <array>
#include <cstring>

#include "base/error.h"
#include "image/block_bc7.h"
#include "image/texels.h"

namespace parhelion::image {

namespace {

// numerator / denominator as the nearest of 256 steps.
uint8_t to_unorm(uint32_t numerator, uint32_t denominator) {
    return static_cast<uint8_t>((numerator * 510 + denominator) / (2 * denominator));
}

uint32_t read_u16(const uint8_t* bytes) { return uint32_t(bytes[0]) | uint32_t(bytes[1]) << 8; }

// "Block decoding for BC1". `opaque`: the last code of blocks with one mean is opaque black; `four`: always two means between the ends.
void decode_color(const uint8_t* block, bool opaque, bool four, uint8_t* rgba) {
    const uint32_t color[2] = {read_u16(block), read_u16(block + 2)};
    const bool two_means = four || color[0] > color[1];
    std::array<std::array<uint8_t, 4>, 4> palette{};
    constexpr std::array<uint32_t, 3> kShift = {11, 5, 0}, kMax = {31, 63, 31};
    for (size_t c = 0; c < 3; ++c) {
        const uint32_t a = color[0] >> kShift[c] & kMax[c], b = color[1] >> kShift[c] & kMax[c];
        palette[0][c] = to_unorm(a, kMax[c]);
        palette[1][c] = to_unorm(b, kMax[c]);
        palette[2][c] = two_means ? to_unorm(2 * a + b, 3 * kMax[c]) : to_unorm(a + b, 2 * kMax[c]);
        palette[3][c] = two_means ? to_unorm(a + 2 * b, 3 * kMax[c]) : uint8_t{0};
    }
    for (size_t i = 0; i < 4; ++i) palette[i][3] = i < 3 || two_means || opaque ? 255 : 0;
    for (uint32_t i = 0; i < 16; ++i) std::memcpy(rgba + 4 * i, palette[block[4 + i / 4] >> (2 * (i % 4)) & 3].data(), 4);
}

// "Block decoding for BC4": one channel of 16 texels, written to every fourth byte.
void decode_channel(const uint8_t* block, uint8_t* out) {
    const uint32_t a = block[0], b = block[1];
    std::array<uint8_t, 8> palette = {block[0], block[1]};
    const uint32_t steps = a > b ? 7 : 5;
    for (uint32_t i = 1; i < steps; ++i) palette[i + 1] = to_unorm((steps - i) * a + i * b, steps * 255);
    if (a <= b) palette[6] = 0, palette[7] = 255;
    uint64_t codes = 0;
    for (uint32_t i = 0; i < 6; ++i) codes |= uint64_t(block[2 + i]) << (8 * i);
    for (uint32_t i = 0; i < 16; ++i) out[4 * i] = palette[codes >> (3 * i) & 7];
}

// One level of blocks, of which those at the right and lower edge may reach over it.
void decode_level(TexelFormat format, uint32_t width, uint32_t height, const uint8_t* blocks, uint8_t* out) {
    std::array<uint8_t, 64> texels;
    for (uint32_t y = 0; y < height; y += 4)
        for (uint32_t x = 0; x < width; x += 4, blocks += block_bytes(format)) {
            decode_block(format, blocks, texels.data());
            const size_t row_bytes = size_t{4} * std::min(4u, width - x);
            for (uint32_t row = 0; row < std::min(4u, height - y); ++row)
                std::memcpy(out + 4 * (size_t{y + row} * width + x), texels.data() + size_t{16} * row, row_bytes);
        }
}

uint32_t side_of_level(uint32_t side, uint32_t level) { return std::max(1u, side >> std::min(level, 31u)); }

}  // namespace

uint64_t block_bytes(TexelFormat format) {
    switch (format) {
        case TexelFormat::Rgba8: return 4;
        case TexelFormat::Bc1Rgb:
        case TexelFormat::Bc1:
        case TexelFormat::Bc4: return 8;
        default: return 16;
    }
}

uint64_t level_bytes(TexelFormat format, uint32_t width, uint32_t height) {
    if (format == TexelFormat::Rgba8) return 4ull * width * height;
    return (uint64_t(width) + 3) / 4 * ((uint64_t(height) + 3) / 4) * block_bytes(format);
}

uint64_t image_bytes(TexelFormat format, uint32_t width, uint32_t height, uint32_t level_count) {
    uint64_t bytes = 0;
    for (uint32_t level = 0; level < level_count; ++level) bytes += level_bytes(format, side_of_level(width, level), side_of_level(height, level));
    return bytes;
}

void decode_block(TexelFormat format, const uint8_t* block, uint8_t* rgba) {
    switch (format) {
        case TexelFormat::Rgba8: std::memcpy(rgba, block, 4); return;
        case TexelFormat::Bc1Rgb: decode_color(block, true, false, rgba); return;
        case TexelFormat::Bc1: decode_color(block, false, false, rgba); return;
        case TexelFormat::Bc3:
            decode_color(block + 8, true, true, rgba);
            decode_channel(block, rgba + 3);
            return;
        case TexelFormat::Bc7: decode_bc7(block, rgba); return;
        case TexelFormat::Bc4:
        case TexelFormat::Bc5:
            for (uint32_t i = 0; i < 16; ++i) rgba[4 * i + 1] = rgba[4 * i + 2] = 0, rgba[4 * i + 3] = 255;
            decode_channel(block, rgba);
            if (format == TexelFormat::Bc5) decode_channel(block + 8, rgba + 1);
            return;
    }
}

std::vector<uint8_t> decode_to_rgba8(TexelFormat format, uint32_t width, uint32_t height, uint32_t level_count,
                                     std::span<const uint8_t> bytes) {
    PARHELION_CHECK(bytes.size() == image_bytes(format, width, height, level_count), "{} bytes are not {} levels of {}x{}", bytes.size(),
                    level_count, width, height);
    if (format == TexelFormat::Rgba8) return {bytes.begin(), bytes.end()};
    std::vector<uint8_t> out(image_bytes(TexelFormat::Rgba8, width, height, level_count));
    uint64_t from = 0, to = 0;
    for (uint32_t level = 0; level < level_count; ++level) {
        const uint32_t w = side_of_level(width, level), h = side_of_level(height, level);
        decode_level(format, w, h, bytes.data() + from, out.data() + to);
        from += level_bytes(format, w, h);
        to += level_bytes(TexelFormat::Rgba8, w, h);
    }
    return out;
}

}  // namespace parhelion::image
