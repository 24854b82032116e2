// Blocks of BC1 to BC7 against values worked out by hand.
#include "image/texels.h"

#include <array>
#include <bit>
#include <string>

#include <gtest/gtest.h>

namespace parhelion::image::block_decode_test {
namespace {

using Texel = std::array<int, 4>;

Texel texel(TexelFormat format, const std::vector<uint8_t>& block, size_t index) {
    std::array<uint8_t, 64> out{};
    EXPECT_EQ(block.size(), block_bytes(format));
    decode_block(format, block.data(), out.data());
    return {out[4 * index], out[4 * index + 1], out[4 * index + 2], out[4 * index + 3]};
}

// Bits from the lowest on, as BC7 orders them.
class Bits {
public:
    Bits& put(uint32_t value, uint32_t count) {
        for (uint32_t i = 0; i < count; ++i, ++at_) bytes_[at_ / 8] = static_cast<uint8_t>(bytes_[at_ / 8] | (value >> i & 1) << (at_ % 8));
        return *this;
    }
    Bits& put_all(std::initializer_list<uint32_t> values, uint32_t count) {
        for (const uint32_t value : values) put(value, count);
        return *this;
    }
    std::vector<uint8_t> block() const { return bytes_; }
    uint32_t size() const { return at_; }

private:
    std::vector<uint8_t> bytes_ = std::vector<uint8_t>(16);
    uint32_t at_ = 0;
};

TEST(BlockDecode, bc1_has_two_means_between_ends_that_fall) {
    // Ends (31, 63, 31) and (0, 0, 0), codes 0, 1, 2, 3 in each row.
    const std::vector<uint8_t> block = {0xFF, 0xFF, 0, 0, 0xE4, 0xE4, 0xE4, 0xE4};
    for (const TexelFormat format : {TexelFormat::Bc1, TexelFormat::Bc1Rgb}) {
        EXPECT_EQ(texel(format, block, 0), (Texel{255, 255, 255, 255}));
        EXPECT_EQ(texel(format, block, 5), (Texel{0, 0, 0, 255}));
        EXPECT_EQ(texel(format, block, 10), (Texel{170, 170, 170, 255}));
        EXPECT_EQ(texel(format, block, 15), (Texel{85, 85, 85, 255}));
    }
}

TEST(BlockDecode, bc1_has_one_mean_and_black_between_ends_that_rise) {
    // Ends (0, 0, 1) and (1, 2, 3): means 0.5 / 31, 1 / 63, 2 / 31.
    const std::vector<uint8_t> block = {1, 0, 0x43, 0x08, 0xE4, 0, 0, 0};
    EXPECT_EQ(texel(TexelFormat::Bc1, block, 0), (Texel{0, 0, 8, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc1, block, 1), (Texel{8, 8, 25, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc1, block, 2), (Texel{4, 4, 16, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc1, block, 3), (Texel{0, 0, 0, 0}));
    EXPECT_EQ(texel(TexelFormat::Bc1Rgb, block, 3), (Texel{0, 0, 0, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc1, block, 4), (Texel{0, 0, 8, 255}));
}

TEST(BlockDecode, bc3_has_two_means_always_and_alpha_before_colour) {
    // Alpha ends 70 and 0 (falling: sevenths), codes 2, 7, 0, ...; the colour is the rising one above.
    const std::vector<uint8_t> block = {70, 0, 2 | 7 << 3, 0, 0, 0, 0, 0, 1, 0, 0x43, 0x08, 0xE4, 0, 0, 0};
    EXPECT_EQ(texel(TexelFormat::Bc3, block, 0), (Texel{0, 0, 8, 60}));
    EXPECT_EQ(texel(TexelFormat::Bc3, block, 1), (Texel{8, 8, 25, 10}));
    EXPECT_EQ(texel(TexelFormat::Bc3, block, 2), (Texel{3, 3, 14, 70}));
    EXPECT_EQ(texel(TexelFormat::Bc3, block, 3), (Texel{5, 5, 19, 70}));
}

TEST(BlockDecode, bc4_and_bc5_are_one_and_two_channels_with_black_and_white_between_ends_that_rise) {
    // Ends 10 and 60: codes 2 (20), 5 (50), 6 (0), 7 (255).
    const std::vector<uint8_t> red = {10, 60, uint8_t(2 | 5 << 3 | (6 & 3) << 6), uint8_t(6 >> 2 | 7 << 1), 0, 0, 0, 0};
    EXPECT_EQ(texel(TexelFormat::Bc4, red, 0), (Texel{20, 0, 0, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc4, red, 1), (Texel{50, 0, 0, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc4, red, 2), (Texel{0, 0, 0, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc4, red, 3), (Texel{255, 0, 0, 255}));
    std::vector<uint8_t> both = {200, 130, 0, 0, 0, 0, 0, 3 << 5};  // code 3 of texel 15: 5/7 of 200 and 2/7 of 130
    both.insert(both.end(), red.begin(), red.end());
    EXPECT_EQ(texel(TexelFormat::Bc5, both, 3), (Texel{200, 255, 0, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc5, both, 15), (Texel{180, 10, 0, 255}));
}

// Each mode with hand-picked ends; texel 0 has index 0, the last texel an index with all its bits where it is no anchor.
TEST(BlockDecode, bc7_mode_0_has_three_subsets_four_bits_and_a_bit_for_each_end) {
    Bits b;
    b.put(1, 1).put(0, 4);  // partition 0: texel 0 in subset 0, 3 in 1, 15 in 2
    b.put_all({15, 0, 8, 0, 0, 4}, 4).put_all({0, 15, 0, 8, 0, 4}, 4).put_all({0, 0, 1, 1, 2, 4}, 4).put_all({1, 0, 0, 1, 0, 1}, 1);
    EXPECT_EQ(b.size(), 83u);
    // 15 with p 1: 31 -> 255; 0 with p 1: 1 -> 8. Subset 1: (16, 0, 2) -> (132, 0, 16). Subset 2: index 7 of 3 bits would need 3 bits: an
    // anchor has 2, so the first end: (0, 0, 4) -> (0, 0, 33).
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 0), (Texel{255, 8, 8, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 3), (Texel{132, 0, 16, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 15), (Texel{0, 0, 33, 255}));
    // Texel 1 (subset 0, bits 85 to 87) to index 7: the second end, (0, 30, 0) -> (0, 247, 0).
    b.put(0, 2).put(7, 3);
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 1), (Texel{0, 247, 0, 255}));
}

TEST(BlockDecode, bc7_mode_1_has_two_subsets_six_bits_and_a_bit_for_each_subset) {
    Bits b;
    b.put(2, 2).put(0, 6);  // partition 0: columns 0 and 1, 2 and 3
    b.put_all({63, 0, 1, 2}, 6).put_all({0, 63, 3, 4}, 6).put_all({32, 32, 5, 6}, 6).put_all({1, 0}, 1);
    EXPECT_EQ(b.size(), 82u);
    b.put(0, 2).put(4, 3);  // texel 1: weight 37 of 64 between (255, 2, 131) and (2, 255, 131)
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 0), (Texel{255, 2, 131, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 1), (Texel{(27 * 255 + 37 * 2 + 32) >> 6, (27 * 2 + 37 * 255 + 32) >> 6, 131, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 2), (Texel{4, 12, 20, 255}));
}

TEST(BlockDecode, bc7_mode_2_has_three_subsets_and_five_bits) {
    Bits b;
    b.put(4, 3).put(6, 6);  // partition 6 and texel 9: the example of the specification
    b.put_all({1, 1, 31, 0, 1, 1}, 5).put_all({1, 1, 0, 31, 1, 1}, 5).put_all({1, 1, 16, 16, 1, 1}, 5);
    EXPECT_EQ(b.size(), 99u);
    b.put(0, 16).put(2, 2);  // bits 115 and 116: index 2, weight 43
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 9), (Texel{(21 * 255 + 32) >> 6, (43 * 255 + 32) >> 6, 132, 255}));
}

TEST(BlockDecode, bc7_mode_3_has_two_subsets_seven_bits_and_a_bit_for_each_end) {
    Bits b;
    b.put(8, 4).put(13, 6);  // partition 13: rows 0 and 1, 2 and 3
    b.put_all({127, 0, 64, 5}, 7).put_all({1, 0, 65, 6}, 7).put_all({2, 0, 66, 7}, 7).put_all({1, 0, 0, 1}, 1);
    EXPECT_EQ(b.size(), 98u);
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 0), (Texel{255, 3, 5, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 8), (Texel{128, 130, 132, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.put(0, 29).put(1, 1).block(), 15), (Texel{(43 * 128 + 21 * 11 + 32) >> 6, (43 * 130 + 21 * 13 + 32) >> 6, (43 * 132 + 21 * 15 + 32) >> 6, 255}));
}

TEST(BlockDecode, bc7_mode_4_has_two_sets_of_indices_which_the_selection_bit_exchanges_and_a_rotation) {
    for (const uint32_t selection : {0u, 1u}) {
        Bits b;
        b.put(16, 5).put(2, 2).put(selection, 1);  // rotation 2: alpha and green change places
        b.put_all({31, 0}, 5).put_all({31, 0}, 5).put_all({31, 0}, 5).put_all({63, 0}, 6);
        EXPECT_EQ(b.size(), 50u);
        b.put(0, 1).put(1, 2).put(0, 28).put(0, 2).put(6, 3);  // texel 1: index 1 of 2 bits (weight 21), 6 of 3 bits (weight 55)
        const int two = (43 * 255 + 32) >> 6, three = (9 * 255 + 32) >> 6;
        const int color = selection ? three : two, alpha = selection ? two : three;
        EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 1), (Texel{color, alpha, color, color})) << selection;
    }
}

TEST(BlockDecode, bc7_mode_5_has_alpha_of_eight_bits_with_its_own_indices) {
    Bits b;
    b.put(32, 6).put(0, 2).put_all({127, 0}, 7).put_all({64, 0}, 7).put_all({0, 127}, 7).put_all({200, 100}, 8);
    EXPECT_EQ(b.size(), 66u);
    b.put(0, 1).put(3, 2).put(0, 28).put(0, 1).put(1, 2);  // texel 1: colour index 3, alpha index 1
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 0), (Texel{255, 129, 0, 200}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 1), (Texel{0, 0, 255, (43 * 200 + 21 * 100 + 32) >> 6}));
}

TEST(BlockDecode, bc7_mode_6_has_one_subset_and_indices_of_four_bits) {
    Bits b;
    b.put(64, 7).put_all({127, 0}, 7).put_all({0, 127}, 7).put_all({50, 50}, 7).put_all({127, 10}, 7).put_all({1, 0}, 1);
    EXPECT_EQ(b.size(), 65u);
    b.put(0, 3).put(9, 4);  // texel 1: weight 38
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 0), (Texel{255, 1, 101, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 1),
              (Texel{(26 * 255 + 32) >> 6, (26 * 1 + 38 * 254 + 32) >> 6, (26 * 101 + 38 * 100 + 32) >> 6, (26 * 255 + 38 * 20 + 32) >> 6}));
}

TEST(BlockDecode, bc7_mode_7_has_two_subsets_with_alpha) {
    Bits b;
    b.put(128, 8).put(17, 6);  // partition 17: texel 2, the anchor of subset 1, has one bit
    b.put_all({31, 0, 0, 31}, 5).put_all({0, 0, 31, 0}, 5).put_all({0, 0, 0, 0}, 5).put_all({31, 31, 10, 20}, 5).put_all({1, 0, 0, 1}, 1);
    EXPECT_EQ(b.size(), 98u);
    b.put(0, 1).put(0, 2).put(1, 1).put(3, 2);  // texel 1: index 0; 2: index 1; 3: index 3
    // Alpha 10 with p 0: 20 of 6 bits -> 81; 20 with p 1: 41 -> 166.
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 0), (Texel{255, 4, 4, 255}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 2), (Texel{(43 * 0 + 21 * 255 + 32) >> 6, (43 * 251 + 21 * 4 + 32) >> 6, (21 * 4 + 32) >> 6, (43 * 81 + 21 * 166 + 32) >> 6}));
    EXPECT_EQ(texel(TexelFormat::Bc7, b.block(), 3), (Texel{255, 4, 4, 166}));
}

TEST(BlockDecode, reserved_bc7_blocks_are_zero) {
    std::vector<uint8_t> block(16, 0xFF);
    block[0] = 0;
    EXPECT_EQ(texel(TexelFormat::Bc7, block, 7), (Texel{0, 0, 0, 0}));
}

TEST(BlockDecode, images_that_are_no_multiple_of_four_are_cut_and_all_levels_decoded) {
    EXPECT_EQ(level_bytes(TexelFormat::Bc1, 5, 3), 16u);
    EXPECT_EQ(level_bytes(TexelFormat::Bc7, 1, 9), 48u);
    EXPECT_EQ(level_bytes(TexelFormat::Rgba8, 5, 3), 60u);
    EXPECT_EQ(image_bytes(TexelFormat::Bc4, 5, 3, 3), 16u + 8 + 8);
    // 5x3: a white block and one whose left column is red; 2x1 and 1x1: grey ones.
    const std::vector<uint8_t> white = {0xFF, 0xFF, 0xFF, 0xFF, 0, 0, 0, 0}, red = {0x00, 0xF8, 0, 0, 0xFC, 0xFC, 0xFC, 0xFC};
    const std::vector<uint8_t> grey = {0xFF, 0xFF, 0, 0, 0xAA, 0xAA, 0xAA, 0xAA};
    std::vector<uint8_t> bytes;
    for (const auto* block : {&white, &red, &grey, &grey}) bytes.insert(bytes.end(), block->begin(), block->end());
    const std::vector<uint8_t> rgba = decode_to_rgba8(TexelFormat::Bc1, 5, 3, 3, bytes);
    ASSERT_EQ(rgba.size(), 60u + 8 + 4);
    for (size_t y = 0; y < 3; ++y)
        for (size_t x = 0; x < 5; ++x) EXPECT_EQ(rgba[4 * (5 * y + x) + 1], x < 4 ? 255 : 0) << x << ' ' << y;
    for (size_t i = 60; i < 72; ++i) EXPECT_EQ(rgba[i], i % 4 == 3 ? 255 : 170);
}

}  // namespace
}  // namespace parhelion::image::block_decode_test
