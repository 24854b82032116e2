// WebP and KTX2 to memory: what is read, what is refused, and damaged files.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <random>

#include <gtest/gtest.h>
#include <webp/encode.h>
#include <zstd.h>

#include "base/error.h"
#include "image/decode.h"
#include "support/ktx2_writer.h"

namespace parhelion::image::texture_decode_test {
namespace {

using Bytes = std::vector<std::byte>;
using testing::Ktx2Spec;
using testing::make_ktx2;

std::string error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.line;
    }
    return {};
}

#define EXPECT_PART(text, part) EXPECT_NE((text).find(part), std::string::npos) << "in: " << (text)

std::vector<uint8_t> gradient(uint32_t width, uint32_t height) {
    std::vector<uint8_t> rgba;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            for (const uint32_t value : {8 * x, 8 * y, 100u, 255 - 4 * x}) rgba.push_back(static_cast<uint8_t>(value));
    return rgba;
}

Bytes make_webp(uint32_t width, uint32_t height, bool lossless) {
    const std::vector<uint8_t> rgba = gradient(width, height);
    uint8_t* memory = nullptr;
    const int w = static_cast<int>(width), h = static_cast<int>(height);
    const size_t size = lossless ? WebPEncodeLosslessRGBA(rgba.data(), w, h, 4 * w, &memory) : WebPEncodeRGBA(rgba.data(), w, h, 4 * w, 95, &memory);
    const auto* begin = reinterpret_cast<std::byte*>(memory);
    Bytes out(begin, begin + size);
    WebPFree(memory);
    return out;
}

std::vector<uint8_t> zstd(const std::vector<uint8_t>& bytes) {
    std::vector<uint8_t> out(ZSTD_compressBound(bytes.size()));
    out.resize(ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), 3));
    return out;
}

// 8x8 in BC7 with four levels, each of its own bytes, plain or zstd.
Ktx2Spec bc7_spec(bool compressed) {
    Ktx2Spec spec{.format = 145, .width = 8, .height = 8, .level_count = 4, .scheme = compressed ? 2u : 0u, .model = 134};
    for (uint8_t level = 0; level < 4; ++level) {
        const std::vector<uint8_t> bytes(level == 0 ? 64 : 16, static_cast<uint8_t>(level + 1));
        spec.levels.push_back(compressed ? zstd(bytes) : bytes);
        spec.unpacked_bytes.push_back(bytes.size());
    }
    return spec;
}

Ktx2Spec plain_spec() { return {.format = 43, .width = 2, .height = 1, .levels = {{1, 2, 3, 4, 5, 6, 7, 8}}}; }

std::string ktx2_error(const Ktx2Spec& spec) {
    return error_of([&] { decode_ktx2(make_ktx2(spec), {}, "a.ktx2"); });
}

}  // namespace

TEST(DecodeWebp, lossless_pictures_come_back_exactly_and_lossy_ones_nearly) {
    const std::vector<uint8_t> expected = gradient(24, 17);
    const Texture8 exact = decode_webp(make_webp(24, 17, true));
    EXPECT_EQ(exact.width, 24u);
    EXPECT_EQ(exact.height, 17u);
    EXPECT_EQ(exact.rgba, expected);
    const Texture8 near = decode_webp(make_webp(24, 17, false));
    ASSERT_EQ(near.rgba.size(), expected.size());
    for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(near.rgba[i], expected[i], 20) << i;
    EXPECT_EQ(std::get<Texture8>(decode_image(make_webp(24, 17, true))).rgba, expected);
    EXPECT_EQ(decode_texels(make_webp(24, 17, true)).bytes, expected);
}

TEST(DecodeWebp, animations_are_refused_and_limits_checked_before_decoding) {
    Bytes animated(30);
    const unsigned char header[30] = {'R', 'I', 'F', 'F', 22, 0, 0, 0, 'W', 'E', 'B', 'P', 'V', 'P', '8', 'X', 10, 0, 0, 0, 2, 0, 0, 0, 7, 0, 0, 7, 0, 0};
    std::memcpy(animated.data(), header, 30);
    EXPECT_PART(error_of([&] { decode_webp(animated, {}, "a.webp"); }), "a.webp: is an animated WebP, which is not supported");
    EXPECT_PART(error_of([] { decode_webp(make_webp(24, 17, true), {.max_width = 23}, "a.webp"); }), "the limit is");
    EXPECT_PART(error_of([] { decode_webp(make_webp(24, 17, true), {.max_bytes = 24 * 17 * 4 - 1}, "a.webp"); }), "the limit is");
}

TEST(DecodeWebp, files_that_are_cut_off_say_how_much_is_there) {
    const Bytes whole = make_webp(24, 17, true), cut(whole.begin(), whole.end() - 10);
    EXPECT_PART(error_of([&] { decode_webp(cut, {}, "a.webp"); }), fmt::format("is a damaged WebP: it has {} bytes, its header says {}", cut.size(), whole.size()));
}

TEST(DecodeKtx2, plain_formats_become_rgba8_with_zeros_and_opaque_alpha_for_what_they_lack) {
    struct Case {
        uint32_t format;
        std::vector<uint8_t> stored, rgba;
    };
    for (const Case& c : {Case{9, {1, 2}, {1, 0, 0, 255, 2, 0, 0, 255}}, Case{22, {1, 2, 3, 4}, {1, 2, 0, 255, 3, 4, 0, 255}},
                          Case{29, {1, 2, 3, 4, 5, 6}, {1, 2, 3, 255, 4, 5, 6, 255}}, Case{30, {1, 2, 3, 4, 5, 6}, {3, 2, 1, 255, 6, 5, 4, 255}},
                          Case{37, {1, 2, 3, 4, 5, 6, 7, 8}, {1, 2, 3, 4, 5, 6, 7, 8}}, Case{50, {1, 2, 3, 4, 5, 6, 7, 8}, {3, 2, 1, 4, 7, 6, 5, 8}}}) {
        const Texels texels = decode_ktx2(make_ktx2({.format = c.format, .width = 2, .height = 1, .levels = {c.stored}}));
        EXPECT_EQ(texels.format, TexelFormat::Rgba8);
        EXPECT_EQ(texels.bytes, c.rgba) << c.format;
    }
}

TEST(DecodeKtx2, blocks_are_kept_with_all_levels_finest_first_plain_or_zstd) {
    for (const bool compressed : {false, true}) {
        const Bytes file = make_ktx2(bc7_spec(compressed));
        const Texels texels = decode_ktx2(file);
        EXPECT_EQ(texels.format, TexelFormat::Bc7);
        EXPECT_EQ(texels.level_count, 4u);
        std::vector<uint8_t> expected(64, 1);
        for (uint8_t level = 2; level <= 4; ++level) expected.insert(expected.end(), 16, level);
        EXPECT_EQ(texels.bytes, expected);
        EXPECT_EQ(ktx2_obstacle(file), std::nullopt);
        EXPECT_EQ(std::get<Texture8>(decode_image(file)).rgba.size(), 8u * 8 * 4);
    }
    const std::pair<uint32_t, TexelFormat> formats[] = {{131, TexelFormat::Bc1Rgb}, {134, TexelFormat::Bc1}, {139, TexelFormat::Bc4}};
    for (const auto& [number, format] : formats)
        EXPECT_EQ(decode_ktx2(make_ktx2({.format = number, .width = 3, .height = 5, .model = number == 139 ? 131u : 128u, .levels = {std::vector<uint8_t>(16)}})).format, format);
    // A level count of 0 asks for levels to be made from the one that is there.
    Ktx2Spec spec = plain_spec();
    spec.level_count = 0;
    EXPECT_EQ(decode_ktx2(make_ktx2(spec)).level_count, 1u);
}

TEST(DecodeKtx2, basis_universal_says_what_to_do) {
    Ktx2Spec spec{.format = 0, .width = 4, .height = 4, .scheme = 1, .model = 163, .levels = {std::vector<uint8_t>(8)}};
    EXPECT_PART(ktx2_error(spec), "a.ktx2: is a KTX2 with Basis Universal texels, which is not supported");
    EXPECT_PART(ktx2_error(spec), "BC7");
    spec.scheme = 2, spec.model = 166;
    EXPECT_EQ(ktx2_obstacle(make_ktx2(spec)), "Basis Universal texels");
}

TEST(DecodeKtx2, what_textures_cannot_be_is_refused_by_name) {
    const auto with = [](const std::function<void(Ktx2Spec&)>& change) {
        Ktx2Spec spec = plain_spec();
        change(spec);
        return ktx2_error(spec);
    };
    EXPECT_EQ(with([](Ktx2Spec&) {}), "");
    EXPECT_PART(with([](Ktx2Spec& s) { s.faces = 6; }), "cube map");
    EXPECT_PART(with([](Ktx2Spec& s) { s.layers = 2; }), "array layers");
    EXPECT_PART(with([](Ktx2Spec& s) { s.depth = 2; }), "three-dimensional");
    EXPECT_PART(with([](Ktx2Spec& s) { s.height = 0; }), "one-dimensional");
    EXPECT_PART(with([](Ktx2Spec& s) { s.width = 0; }), "0 pixels wide");
    EXPECT_PART(with([](Ktx2Spec& s) { s.faces = 2; }), "2 faces");
    EXPECT_PART(with([](Ktx2Spec& s) { s.format = 157; }), "ASTC");
    EXPECT_PART(with([](Ktx2Spec& s) { s.format = 143; }), "BC6H");
    EXPECT_PART(with([](Ktx2Spec& s) { s.format = 140; }), "signed BC4");
    EXPECT_PART(with([](Ktx2Spec& s) { s.format = 97; }), "VkFormat 97");
    EXPECT_PART(with([](Ktx2Spec& s) { s.scheme = 3; }), "zlib supercompression");
    EXPECT_PART(with([](Ktx2Spec& s) { s.scheme = 9; }), "unknown supercompression 9");
    EXPECT_PART(with([](Ktx2Spec& s) { s.flags = 1; }), "straight alpha");
    EXPECT_PART(with([](Ktx2Spec& s) { s.model = 134; }), "colour model 134");
    EXPECT_PART(with([](Ktx2Spec& s) { s.level_count = 3; }), "3 levels, too many for 2x1");
    EXPECT_PART(with([](Ktx2Spec& s) { s.keys = {{"KTXorientation", "ru"}}; }), "the other way");
    EXPECT_PART(with([](Ktx2Spec& s) { s.keys = {{"KTXswizzle", "bgra"}}; }), "KTXswizzle 'bgra'");
    EXPECT_EQ(with([](Ktx2Spec& s) { s.keys = {{"KTXswizzle", "rgba"}, {"KTXwriter", "test"}}; }), "");
    EXPECT_PART(with([](Ktx2Spec& s) { s.levels[0].pop_back(); }), "level 0 has 7 bytes");
    EXPECT_PART(with([](Ktx2Spec& s) { s.width = 70000, s.levels[0].resize(280000); }), "the limit is");
}

TEST(DecodeKtx2, zstd_levels_unpack_to_their_size_and_no_more) {
    const auto with = [](std::vector<uint8_t> level, uint64_t unpacked, uint32_t width = 4) {
        return ktx2_error({.format = 37, .width = width, .height = width, .scheme = 2, .levels = {std::move(level)}, .unpacked_bytes = {unpacked}});
    };
    EXPECT_EQ(with(zstd(std::vector<uint8_t>(64)), 64), "");
    EXPECT_PART(with(zstd(std::vector<uint8_t>(65)), 64), "cannot be unpacked");
    EXPECT_PART(with(zstd(std::vector<uint8_t>(63)), 64), "unpacks to 63 bytes, expected 64");
    EXPECT_PART(with(zstd(std::vector<uint8_t>(64)), 65), "expected 64");
    EXPECT_PART(with({1, 2, 3, 4}, 64), "cannot be unpacked");
    EXPECT_PART(with(zstd(std::vector<uint8_t>(64)), 4ull * 8192 * 8192, 8192), "too small for its size");
}

TEST(DecodeKtx2, levels_and_sections_may_not_leave_the_file_or_lie_over_each_other) {
    const auto with = [](size_t offset, uint64_t value, int bytes) {
        Bytes file = make_ktx2(bc7_spec(false));
        for (int i = 0; i < bytes; ++i) file[offset + static_cast<size_t>(i)] = static_cast<std::byte>(value >> (8 * i));
        return error_of([&] { decode_ktx2(file, {}, "a.ktx2"); });
    };
    EXPECT_PART(with(80, uint64_t{1} << 40, 8), "its level has 64 bytes from 1099511627776 on");
    EXPECT_PART(with(88, ~uint64_t{0}, 8), "its level has 18446744073709551615 bytes");
    EXPECT_PART(with(80, 0, 8), "lies over its");
    EXPECT_PART(with(80, 176, 8), "lies over its");
    EXPECT_PART(with(88, 0, 8), "level 0 has no bytes");
    EXPECT_PART(with(48, 4096, 4), "data format descriptor has 28 bytes from 4096 on");
    EXPECT_PART(with(52, 24, 4), "data format descriptor has a wrong size");
    EXPECT_PART(with(60, 4, 4), "key/value data end within an entry");
    EXPECT_PART(with(72, 8, 8), "supercompression data");
    EXPECT_PART(with(16, 2, 4), "type size is 2");
}

namespace {

// Small limits: a changed size must not make the tests slow.
constexpr DecodeLimits kSmall{.max_width = 256, .max_height = 256, .max_pixels = 4096, .max_bytes = 1 << 18};

std::vector<Bytes> small_files() {
    Ktx2Spec spec = plain_spec();
    spec.keys.push_back({"KTXswizzle", "rgba"});
    return {make_webp(9, 7, true), make_webp(9, 7, false), make_ktx2(spec), make_ktx2(bc7_spec(false)), make_ktx2(bc7_spec(true))};
}

}  // namespace

TEST(TextureFiles, cut_at_any_length_they_are_errors_that_name_the_file) {
    for (const Bytes& file : small_files()) {
        ASSERT_EQ(error_of([&] { decode_texels(file, kSmall, "file"); }), "");
        // A WebP may end with a byte of padding that nothing needs.
        for (size_t size = 0; size + 1 < file.size(); ++size) {
            const Bytes cut(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
            ASSERT_TRUE(error_of([&] { decode_texels(cut, kSmall, "file"); }).starts_with("file: ")) << size << " of " << file.size();
        }
    }
}

TEST(TextureFiles, changed_anywhere_they_give_an_image_or_an_error) {
    std::mt19937 rng(5);
    for (const Bytes& file : small_files()) {
        const auto expect_sound = [&](const Bytes& damaged) {
            const std::string message = error_of([&] { decode_image(damaged, kSmall, "file"); });  // another exception or a crash fails the test
            EXPECT_TRUE(message.empty() || message.starts_with("file: ")) << message;
        };
        // Every byte of header and level index, with values that are often wrong in their own way.
        for (size_t i = 0; i < std::min<size_t>(file.size(), 260); ++i)
            for (const unsigned value : {0u, 1u, 0x7Fu, 0x80u, 0xFFu}) {
                Bytes damaged = file;
                damaged[i] = static_cast<std::byte>(value);
                expect_sound(damaged);
            }
        // Every four and eight bytes of it at once.
        for (size_t i = 12; i + 8 <= std::min<size_t>(file.size(), 260); i += 4)
            for (const size_t width : {4u, 8u}) {
                Bytes damaged = file;
                std::fill_n(damaged.begin() + static_cast<std::ptrdiff_t>(i), width, std::byte{0xFF});
                expect_sound(damaged);
            }
        for (int trial = 0; trial < 400; ++trial) {
            Bytes damaged = file;
            for (uint32_t flips = 1 + rng() % 4; flips > 0; --flips) damaged[rng() % damaged.size()] ^= static_cast<std::byte>(1u << (rng() % 8));
            expect_sound(damaged);
        }
    }
}

}  // namespace parhelion::image::texture_decode_test
