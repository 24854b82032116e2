// BC7 blocks. Khronos Data Format 1.3, 20.1; all tables are of that chapter.
#include "image/block_bc7.h"

#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace parhelion::image {

namespace {

// "Mode-dependent BPTC parameters": bits of each field. Every mode keeps the order of the fields.
struct Mode {
    uint32_t subsets, partition, rotation, index_selection, color, alpha, end_p, shared_p, index, second_index;
};
constexpr std::array<Mode, 8> kModes = {{
    {3, 4, 0, 0, 4, 0, 1, 0, 3, 0},
    {2, 6, 0, 0, 6, 0, 0, 1, 3, 0},
    {3, 6, 0, 0, 5, 0, 0, 0, 2, 0},
    {2, 6, 0, 0, 7, 0, 1, 0, 2, 0},
    {1, 0, 2, 1, 5, 6, 0, 0, 2, 3},
    {1, 0, 2, 0, 7, 8, 0, 0, 2, 2},
    {1, 0, 0, 0, 7, 7, 1, 0, 4, 0},
    {2, 6, 0, 0, 5, 5, 1, 0, 2, 0},
}};

// Subset of texel i: bit i of a row; bits 2 i and 2 i + 1 where there are three.
// clang-format off
constexpr std::array<uint16_t, 64> kTwoSubsets = {
    0xCCCC, 0x8888, 0xEEEE, 0xECC8, 0xC880, 0xFEEC, 0xFEC8, 0xEC80, 0xC800, 0xFFEC, 0xFE80, 0xE800, 0xFFE8, 0xFF00, 0xFFF0, 0xF000,
    0xF710, 0x008E, 0x7100, 0x08CE, 0x008C, 0x7310, 0x3100, 0x8CCE, 0x088C, 0x3110, 0x6666, 0x366C, 0x17E8, 0x0FF0, 0x718E, 0x399C,
    0xAAAA, 0xF0F0, 0x5A5A, 0x33CC, 0x3C3C, 0x55AA, 0x9696, 0xA55A, 0x73CE, 0x13C8, 0x324C, 0x3BDC, 0x6996, 0xC33C, 0x9966, 0x0660,
    0x0272, 0x04E4, 0x4E40, 0x2720, 0xC936, 0x936C, 0x39C6, 0x639C, 0x9336, 0x9CC6, 0x817E, 0xE718, 0xCCF0, 0x0FCC, 0x7744, 0xEE22,
};
constexpr std::array<uint32_t, 64> kThreeSubsets = {
    0xAA685050, 0x6A5A5040, 0x5A5A4200, 0x5450A0A8, 0xA5A50000, 0xA0A05050, 0x5555A0A0, 0x5A5A5050,
    0xAA550000, 0xAA555500, 0xAAAA5500, 0x90909090, 0x94949494, 0xA4A4A4A4, 0xA9A59450, 0x2A0A4250,
    0xA5945040, 0x0A425054, 0xA5A5A500, 0x55A0A0A0, 0xA8A85454, 0x6A6A4040, 0xA4A45000, 0x1A1A0500,
    0x0050A4A4, 0xAAA59090, 0x14696914, 0x69691400, 0xA08585A0, 0xAA821414, 0x50A4A450, 0x6A5A0200,
    0xA9A58000, 0x5090A0A8, 0xA8A09050, 0x24242424, 0x00AA5500, 0x24924924, 0x24499224, 0x50A50A50,
    0x500AA550, 0xAAAA4444, 0x66660000, 0xA5A0A5A0, 0x50A050A0, 0x69286928, 0x44AAAA44, 0x66666600,
    0xAA444444, 0x54A854A8, 0x95809580, 0x96969600, 0xA85454A8, 0x80959580, 0xAA141414, 0x96960000,
    0xAAAA1414, 0xA05050A0, 0xA0A5A5A0, 0x96000000, 0x40804080, 0xA9A8A9A8, 0xAAAAAA44, 0x2A4A5254,
};

// Anchors: the texel of a subset whose index lacks its highest bit. That of the first subset is texel 0.
constexpr std::array<uint8_t, 64> kAnchorOfTwo = {
    15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 2, 8, 2, 2, 8, 8, 15, 2, 8, 2, 2, 8, 8, 2, 2,
    15, 15, 6, 8, 2, 8, 15, 15, 2, 8, 2, 2, 2, 15, 15, 6, 6, 2, 6, 8, 15, 15, 2, 2, 15, 15, 15, 15, 15, 2, 2, 15,
};
constexpr std::array<uint8_t, 64> kSecondAnchorOfThree = {
    3, 3, 15, 15, 8, 3, 15, 15, 8, 8, 6, 6, 6, 5, 3, 3, 3, 3, 8, 15, 3, 3, 6, 10, 5, 8, 8, 6, 8, 5, 15, 15,
    8, 15, 3, 5, 6, 10, 8, 15, 15, 3, 15, 5, 15, 15, 15, 15, 3, 15, 5, 5, 5, 8, 5, 10, 5, 10, 8, 13, 15, 12, 3, 3,
};
constexpr std::array<uint8_t, 64> kThirdAnchorOfThree = {
    15, 8, 8, 3, 15, 15, 3, 8, 15, 15, 15, 15, 15, 15, 15, 8, 15, 8, 15, 3, 15, 8, 15, 8, 3, 15, 6, 10, 15, 15, 10, 8,
    15, 3, 15, 10, 10, 8, 9, 10, 6, 15, 8, 15, 3, 6, 6, 8, 15, 3, 15, 15, 15, 15, 15, 15, 15, 15, 15, 15, 3, 15, 15, 8,
};
// clang-format on

// Reads the block from its lowest bit on.
class BlockBits {
public:
    explicit BlockBits(const uint8_t* block) {
        for (uint32_t i = 0; i < 8; ++i) {
            low_ |= uint64_t(block[i]) << (8 * i);
            high_ |= uint64_t(block[8 + i]) << (8 * i);
        }
    }
    uint32_t take(uint32_t count) {  // at most 8
        const auto value = static_cast<uint32_t>(low_ & ((1u << count) - 1));
        if (count == 0) return value;
        low_ = low_ >> count | high_ << (64 - count);
        high_ >>= count;
        return value;
    }

private:
    uint64_t low_ = 0, high_ = 0;
};

// Two ends a subset.
using Ends = std::array<std::array<uint32_t, 4>, 6>;
using Indices = std::array<uint32_t, 16>;

// The high bits of a byte; the top ones are repeated below.
uint32_t to_byte(uint32_t value, uint32_t bits) {
    value <<= 8 - bits;
    return value | value >> bits;
}

Ends read_ends(BlockBits& bits, const Mode& mode) {
    Ends ends{};
    const uint32_t count = 2 * mode.subsets;
    for (uint32_t channel = 0; channel < 4; ++channel)
        for (uint32_t i = 0; i < count; ++i) ends[i][channel] = bits.take(channel < 3 ? mode.color : mode.alpha);
    std::array<uint32_t, 6> p{};
    if (mode.end_p)
        for (uint32_t i = 0; i < count; ++i) p[i] = bits.take(1);
    if (mode.shared_p)
        for (uint32_t i = 0; i < count; i += 2) p[i] = p[i + 1] = bits.take(1);
    const uint32_t p_bits = mode.end_p | mode.shared_p;
    for (uint32_t i = 0; i < count; ++i)
        for (uint32_t channel = 0; channel < 4; ++channel) {
            const uint32_t width = channel < 3 ? mode.color : mode.alpha;
            ends[i][channel] = width == 0 ? 255 : to_byte(ends[i][channel] << p_bits | p[i], width + p_bits);
        }
    return ends;
}

uint32_t subset_of(const Mode& mode, uint32_t partition, uint32_t texel) {
    if (mode.subsets == 1) return 0;
    return mode.subsets == 2 ? kTwoSubsets[partition] >> texel & 1u : kThreeSubsets[partition] >> (2 * texel) & 3u;
}

bool is_anchor(const Mode& mode, uint32_t partition, uint32_t texel) {
    if (texel == 0) return true;
    if (mode.subsets == 2) return texel == kAnchorOfTwo[partition];
    return mode.subsets == 3 && (texel == kSecondAnchorOfThree[partition] || texel == kThirdAnchorOfThree[partition]);
}

Indices read_indices(BlockBits& bits, const Mode& mode, uint32_t partition, uint32_t width) {
    Indices indices{};
    if (width == 0) return indices;
    for (uint32_t texel = 0; texel < 16; ++texel) indices[texel] = bits.take(width - (is_anchor(mode, partition, texel) ? 1 : 0));
    return indices;
}

uint32_t weight(uint32_t index, uint32_t width) {
    if (width == 2) return index * 21 + (index >> 1);
    if (width == 3) return index * 9 + (index >> 2);
    return (index << 2) + (index >> 2) + (index >> 1 & 1);
}

uint8_t mix(uint32_t a, uint32_t b, uint32_t w) { return static_cast<uint8_t>(((64 - w) * a + w * b + 32) >> 6); }

}  // namespace

void decode_bc7(const uint8_t* block, uint8_t* rgba) {
    if (block[0] == 0) {
        std::memset(rgba, 0, 64);
        return;
    }
    const auto number = static_cast<uint32_t>(std::countr_zero(block[0]));
    const Mode& mode = kModes[number];
    BlockBits bits(block);
    bits.take(number + 1);
    const uint32_t partition = bits.take(mode.partition), rotation = bits.take(mode.rotation), selection = bits.take(mode.index_selection);
    const Ends ends = read_ends(bits, mode);
    const Indices first = read_indices(bits, mode, partition, mode.index);
    const Indices second = read_indices(bits, mode, partition, mode.second_index);
    // With two sets of indices colour has one and alpha the other; the selection bit exchanges them.
    const bool color_second = selection != 0, alpha_second = mode.second_index != 0 && selection == 0;
    for (uint32_t texel = 0; texel < 16; ++texel, rgba += 4) {
        const uint32_t subset = subset_of(mode, partition, texel);
        const auto& a = ends[2 * subset];
        const auto& b = ends[2 * subset + 1];
        const uint32_t color = color_second ? weight(second[texel], mode.second_index) : weight(first[texel], mode.index);
        const uint32_t alpha = alpha_second ? weight(second[texel], mode.second_index) : weight(first[texel], mode.index);
        for (uint32_t channel = 0; channel < 4; ++channel) rgba[channel] = mix(a[channel], b[channel], channel < 3 ? color : alpha);
        if (rotation != 0) std::swap(rgba[3], rgba[rotation - 1]);
    }
}

}  // namespace parhelion::image
