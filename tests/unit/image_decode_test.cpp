// Image files to memory: every format, the limits, and damaged files.
#include "image/decode.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>

#include <gtest/gtest.h>
#include <jpeglib.h>
#include <png.h>

#include "base/error.h"
#include "image/encode.h"
#include "image/film.h"

namespace parhelion::image::image_decode_test {
namespace {

using Bytes = std::vector<std::byte>;

Bytes bytes_of(std::string_view text) {
    const auto* data = reinterpret_cast<const std::byte*>(text.data());
    return {data, data + text.size()};
}

std::string error_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.line;
    }
    return {};
}

struct PngKind {
    int color_type, depth;
    bool interlaced = false, transparent = false;
};

void append_png_bytes(png_structp png, png_bytep data, size_t size) {
    auto* out = static_cast<Bytes*>(png_get_io_ptr(png));
    out->insert(out->end(), reinterpret_cast<std::byte*>(data), reinterpret_cast<std::byte*>(data) + size);
}

// A PNG of any kind; row y consists of the bytes value(y, i).
Bytes make_png(uint32_t width, uint32_t height, const PngKind& kind, const std::function<uint8_t(size_t, size_t)>& value) {
    Bytes out;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(png, &out, append_png_bytes, [](png_structp) {});
    png_set_IHDR(png, info, width, height, kind.depth, kind.color_type, kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    const png_color palette[4] = {{10, 20, 30}, {40, 50, 60}, {70, 80, 90}, {100, 110, 120}};
    if (kind.color_type == PNG_COLOR_TYPE_PALETTE) png_set_PLTE(png, info, palette, 4);
    const png_byte alpha[2] = {255, 7};
    png_color_16 grey{};
    grey.gray = 1;
    if (kind.transparent) png_set_tRNS(png, info, alpha, kind.color_type == PNG_COLOR_TYPE_PALETTE ? 2 : 0, &grey);
    png_write_info(png, info);
    const size_t row_bytes = png_get_rowbytes(png, info);
    std::vector<png_byte> rows(row_bytes * height);
    std::vector<png_bytep> pointers;
    for (size_t y = 0; y < height; ++y) {
        for (size_t i = 0; i < row_bytes; ++i) rows[y * row_bytes + i] = value(y, i);
        pointers.push_back(rows.data() + y * row_bytes);
    }
    png_write_image(png, pointers.data());
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return out;
}

Bytes make_jpeg(uint32_t width, uint32_t height, int components, bool progressive, const std::function<uint8_t(size_t, size_t, int)>& value) {
    jpeg_compress_struct info{};
    jpeg_error_mgr errors{};
    info.err = jpeg_std_error(&errors);
    jpeg_create_compress(&info);
    unsigned char* memory = nullptr;
    unsigned long size = 0;
    jpeg_mem_dest(&info, &memory, &size);
    info.image_width = width;
    info.image_height = height;
    info.input_components = components;
    info.in_color_space = components == 1 ? JCS_GRAYSCALE : components == 3 ? JCS_RGB : JCS_CMYK;
    jpeg_set_defaults(&info);
    jpeg_set_quality(&info, 95, TRUE);
    if (progressive) jpeg_simple_progression(&info);
    jpeg_start_compress(&info, TRUE);
    for (size_t y = 0; y < height; ++y) {
        std::vector<uint8_t> row;
        for (size_t x = 0; x < width; ++x)
            for (int c = 0; c < components; ++c) row.push_back(value(x, y, c));
        JSAMPROW pointer = row.data();
        jpeg_write_scanlines(&info, &pointer, 1);
    }
    jpeg_finish_compress(&info);
    jpeg_destroy_compress(&info);
    const auto* begin = reinterpret_cast<std::byte*>(memory);
    Bytes out(begin, begin + size);
    std::free(memory);
    return out;
}

uint8_t smooth(size_t x, size_t y, int c) { return static_cast<uint8_t>(40 + 5 * x + 3 * y + 20 * static_cast<size_t>(c)); }

std::string hdr_header(std::string_view resolution) { return fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{}\n", resolution); }

// A 16x3 picture in the run-length coding of 1991, runs and literals alternating.
Bytes make_rle_hdr() {
    std::string out = hdr_header("-Y 3 +X 16");
    for (int y = 0; y < 3; ++y) {
        out += std::string("\x02\x02\x00\x10", 4);
        for (int component = 0; component < 4; ++component) {
            const char value = static_cast<char>(component == 3 ? 129 : 10 * y + component);
            out += static_cast<char>(128 + 10);
            out += value;
            out += static_cast<char>(6);
            for (int i = 0; i < 6; ++i) out += component == 3 ? value : static_cast<char>(value + i);
        }
    }
    return bytes_of(out);
}

std::string pixel(int r, int g, int b, int e) {
    return {static_cast<char>(r), static_cast<char>(g), static_cast<char>(b), static_cast<char>(e)};
}

Bytes png_with_header_only(uint32_t width, uint32_t height) {
    Bytes png = make_png(1, 1, {PNG_COLOR_TYPE_RGB_ALPHA, 8}, [](size_t, size_t) { return uint8_t{0}; });
    for (size_t i = 0; i < 4; ++i) {
        png[16 + i] = static_cast<std::byte>(width >> (24 - 8 * i));
        png[20 + i] = static_cast<std::byte>(height >> (24 - 8 * i));
    }
    uint32_t crc = 0xFFFFFFFFu;  // of the IHDR chunk, as PNG 1.2 defines it
    for (size_t i = 12; i < 29; ++i) {
        crc ^= std::to_integer<uint32_t>(png[i]);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xEDB88320u : 0u);
    }
    crc = ~crc;
    for (size_t i = 0; i < 4; ++i) png[29 + i] = static_cast<std::byte>(crc >> (24 - 8 * i));
    return png;
}

Bytes sample_exr() {
    ImageF image = make_image(23, 19, {"R", "G", "B", "albedo.R"});
    for (size_t i = 0; i < image.data.size(); ++i) image.data[i] = static_cast<float>(i * i % 977) / 64.0f;
    return encode_exr(image, ExrPrecision::Half).bytes;
}

}  // namespace

TEST(DecodePng, every_colour_type_and_depth_becomes_rgba8) {
    const auto value = [](size_t y, size_t i) { return static_cast<uint8_t>(16 * y + i); };
    struct Case {
        PngKind kind;
        std::array<uint8_t, 4> pixel_1_of_row_1;
    };
    const Case cases[] = {
        {{PNG_COLOR_TYPE_GRAY, 8}, {17, 17, 17, 255}},       {{PNG_COLOR_TYPE_GRAY_ALPHA, 8}, {18, 18, 18, 19}},
        {{PNG_COLOR_TYPE_RGB, 8}, {19, 20, 21, 255}},        {{PNG_COLOR_TYPE_RGB_ALPHA, 8}, {20, 21, 22, 23}},
        {{PNG_COLOR_TYPE_RGB, 16}, {22, 24, 26, 255}},       {{PNG_COLOR_TYPE_GRAY, 1}, {0, 0, 0, 255}},
        {{PNG_COLOR_TYPE_RGB_ALPHA, 8, true}, {20, 21, 22, 23}}, {{PNG_COLOR_TYPE_RGB, 8, true}, {19, 20, 21, 255}},
    };
    for (const Case& c : cases) {
        const Texture8 texture = decode_png(make_png(5, 3, c.kind, value));
        ASSERT_EQ(texture.width, 5u);
        ASSERT_EQ(texture.height, 3u);
        for (size_t k = 0; k < 4; ++k) EXPECT_EQ(texture.rgba[4 * 6 + k], c.pixel_1_of_row_1[k]) << c.kind.color_type << ' ' << c.kind.depth << ' ' << k;
    }
}

TEST(DecodePng, palettes_and_transparent_colours_are_expanded) {
    const Texture8 palette = decode_png(make_png(4, 1, {PNG_COLOR_TYPE_PALETTE, 2, false, true}, [](size_t, size_t) { return uint8_t{0b00011011}; }));
    EXPECT_EQ(palette.rgba, (std::vector<uint8_t>{10, 20, 30, 255, 40, 50, 60, 7, 70, 80, 90, 255, 100, 110, 120, 255}));
    const Texture8 grey = decode_png(make_png(2, 1, {PNG_COLOR_TYPE_GRAY, 8, false, true}, [](size_t, size_t i) { return static_cast<uint8_t>(i); }));
    EXPECT_EQ(grey.rgba, (std::vector<uint8_t>{0, 0, 0, 255, 1, 1, 1, 0}));
}

TEST(DecodePng, sixteen_bits_are_rounded_to_eight) {
    // 0x00FF is 0.996 of a step of eight bits: rounds to 1, truncation would give 0.
    const Texture8 texture = decode_png(make_png(1, 1, {PNG_COLOR_TYPE_GRAY, 16}, [](size_t, size_t i) { return static_cast<uint8_t>(i == 0 ? 0 : 255); }));
    EXPECT_EQ(texture.rgba[0], 1);
}

TEST(DecodeJpeg, baseline_progressive_and_grey_are_read) {
    for (const bool progressive : {false, true}) {
        const Texture8 texture = decode_jpeg(make_jpeg(24, 17, 3, progressive, smooth));
        ASSERT_EQ(texture.width, 24u);
        ASSERT_EQ(texture.height, 17u);
        for (size_t y = 0; y < 17; ++y)
            for (size_t x = 0; x < 24; ++x)
                for (int c = 0; c < 4; ++c)
                    EXPECT_NEAR(texture.rgba[4 * (24 * y + x) + static_cast<size_t>(c)], c == 3 ? 255 : smooth(x, y, c), 5);
    }
    const Texture8 grey = decode_jpeg(make_jpeg(8, 8, 1, false, [](size_t, size_t, int) { return uint8_t{77}; }));
    EXPECT_EQ((std::vector<uint8_t>(grey.rgba.begin(), grey.rgba.begin() + 4)), (std::vector<uint8_t>{77, 77, 77, 255}));
}

TEST(DecodeJpeg, data_that_end_before_the_picture_are_an_error_although_the_file_goes_on) {
    Bytes jpeg = make_jpeg(24, 17, 3, false, smooth);
    jpeg.erase(jpeg.end() - 42, jpeg.end() - 2);  // the last of the data, but not the end marker
    EXPECT_NE(error_of([&] { decode_jpeg(jpeg, {}, "a.jpg"); }).find("a.jpg: is a damaged JPEG"), std::string::npos);
}

TEST(DecodeJpeg, cmyk_is_refused_clearly) {
    EXPECT_NE(error_of([] { decode_jpeg(make_jpeg(8, 8, 4, false, smooth), {}, "a.jpg"); }).find("a.jpg: is a CMYK JPEG"), std::string::npos);
}

TEST(DecodeHdr, flat_scanlines_are_read_exactly) {
    const ImageF image = decode_hdr(bytes_of(hdr_header("-Y 1 +X 2") + pixel(128, 64, 32, 129) + pixel(255, 1, 0, 0)));
    EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
    EXPECT_EQ(image.data, (std::vector<float>{1.0f, 0.0f, 0.5f, 0.0f, 0.25f, 0.0f}));
}

TEST(DecodeHdr, both_run_length_codings_are_read) {
    const ImageF image = decode_hdr(make_rle_hdr());
    for (size_t y = 0; y < 3; ++y)
        for (size_t x = 0; x < 16; ++x)
            for (size_t c = 0; c < 3; ++c)
                EXPECT_EQ(image.plane(c)[16 * y + x], static_cast<float>(10 * y + c + (x < 10 ? 0 : x - 10)) / 128.0f) << x << ' ' << y << ' ' << c;
    // 1 + 3 + 2 * 256 pixels: a count in two bytes, low byte first.
    const ImageF old = decode_hdr(bytes_of(hdr_header("-Y 1 +X 517") + pixel(128, 64, 32, 129) + pixel(1, 1, 1, 3) + pixel(1, 1, 1, 2) + pixel(0, 0, 128, 128)));
    EXPECT_EQ(old.plane(0)[515], 1.0f);
    EXPECT_EQ(old.plane(0)[516], 0.0f);
    EXPECT_EQ(old.plane(2)[516], 0.5f);
}

TEST(DecodeHdr, all_orientations_put_the_same_pixel_at_the_upper_left) {
    const std::string a = pixel(128, 0, 0, 129), b = pixel(0, 128, 0, 129);  // a: upper left, b: upper right; c, d below
    const std::string c = pixel(0, 0, 128, 129), d = pixel(128, 128, 128, 129);
    const std::pair<const char*, std::string> cases[] = {{"-Y 2 +X 2", a + b + c + d}, {"+Y 2 +X 2", c + d + a + b}, {"-Y 2 -X 2", b + a + d + c},
                                                         {"+Y 2 -X 2", d + c + b + a}, {"+X 2 -Y 2", a + c + b + d}, {"-X 2 +Y 2", d + b + c + a},
                                                         {"+X 2 +Y 2", c + a + d + b}, {"-X 2 -Y 2", b + d + a + c}};
    for (const auto& [resolution, pixels] : cases) {
        const ImageF image = decode_hdr(bytes_of(hdr_header(resolution) + pixels));
        EXPECT_EQ(image.data, (std::vector<float>{1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1})) << resolution;
    }
}

TEST(DecodeHdr, exposure_is_recorded_and_other_colour_formats_are_refused) {
    const ImageF image = decode_hdr(bytes_of("#?RGBE\nEXPOSURE= 2.0\nEXPOSURE=0.25\nEXPOSURE=\n\n-Y 1 +X 1\n" + pixel(128, 128, 128, 129)));
    EXPECT_EQ(image.attributes.at("EXPOSURE"), "0.5");
    EXPECT_EQ(image.data[0], 1.0f);
    EXPECT_NE(error_of([] { decode_hdr(bytes_of("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\nxxxx")); }).find("not supported"), std::string::npos);
}

TEST(DecodeHdr, broken_headers_and_runs_are_refused) {
    for (const char* resolution : {"-Y 4", "Y 4 X 4", "-Y 4 +Y 4", "-Y four +X 4", "-Y 4 +X -4", "-Y 4 +X 99999999999", "", "-Y 0 +X 4"})
        EXPECT_NE(error_of([&] { decode_hdr(bytes_of(hdr_header(resolution) + std::string(64, 'x'))); }), "") << resolution;
    EXPECT_NE(error_of([] { decode_hdr(bytes_of(hdr_header("-Y 1 +X 4") + pixel(1, 1, 1, 4))); }).find("run"), std::string::npos);
    EXPECT_NE(error_of([] { decode_hdr(bytes_of(hdr_header("-Y 1 +X 4") + pixel(9, 1, 1, 4) + pixel(1, 1, 1, 200))); }).find("run"), std::string::npos);
}

TEST(DecodeImage, finds_the_format_by_content) {
    const Bytes png = make_png(2, 2, {PNG_COLOR_TYPE_RGB, 8}, [](size_t, size_t) { return uint8_t{9}; });
    EXPECT_TRUE(std::holds_alternative<Texture8>(decode_image(png)));
    EXPECT_TRUE(std::holds_alternative<Texture8>(decode_image(make_jpeg(8, 8, 3, false, smooth))));
    EXPECT_TRUE(std::holds_alternative<ImageF>(decode_image(make_rle_hdr())));
    EXPECT_TRUE(std::holds_alternative<ImageF>(decode_image(sample_exr())));
    using namespace std::string_view_literals;
    EXPECT_NE(error_of([] { decode_image(bytes_of("RIFF\x10\0\0\0WEBPVP8 "sv), {}, "a.webp"); }).find("a.webp: is a damaged WebP"), std::string::npos);
    EXPECT_NE(error_of([] { decode_image(bytes_of("\xabKTX 20\xbb\r\n\x1a\n"sv)); }).find("is a damaged KTX2"), std::string::npos);
    EXPECT_NE(error_of([] { decode_image(bytes_of("GIF89a"), {}, "a.gif"); }).find("a.gif: is no image of a known format"), std::string::npos);
    EXPECT_NE(error_of([] { decode_image({}); }).find("known format"), std::string::npos);
}

TEST(DecodeImage, limits_are_checked_before_decoding) {
    const DecodeLimits defaults;
    for (const auto& [width, height] : {std::pair{30000u, 30000u}, {40000u, 1u}, {1u, 40000u}, {0x7FFFFFFFu, 0x7FFFFFFFu}})
        EXPECT_NE(error_of([&, w = width, h = height] { decode_png(png_with_header_only(w, h)); }).find("the limit is"), std::string::npos) << width;
    EXPECT_NE(error_of([] { decode_png(png_with_header_only(16000, 16000)); }).find("too small for its size"), std::string::npos);
    EXPECT_NE(error_of([] { decode_hdr(bytes_of(hdr_header("-Y 30000 +X 30000"))); }).find("the limit is"), std::string::npos);

    const DecodeLimits tight{.max_width = 20, .max_height = 20, .max_pixels = 200, .max_bytes = 700};
    const auto png = [](uint32_t w, uint32_t h) { return make_png(w, h, {PNG_COLOR_TYPE_RGB, 8}, [](size_t, size_t) { return uint8_t{9}; }); };
    EXPECT_NO_THROW(decode_png(png(20, 8), tight));
    for (const auto& [width, height] : {std::pair{21u, 1u}, {1u, 21u}, {20u, 11u}, {16u, 11u}}) EXPECT_THROW(decode_png(png(width, height), tight), Error);
    EXPECT_THROW(decode_jpeg(make_jpeg(21, 4, 3, false, smooth), tight), Error);
    EXPECT_NO_THROW(decode_jpeg(make_jpeg(21, 4, 3, false, smooth), {.max_bytes = 21 * 4 * 4}));
    EXPECT_NO_THROW(decode_jpeg(make_jpeg(21, 4, 3, true, smooth), {.max_bytes = 21 * 4 * 10}));
    EXPECT_THROW(decode_jpeg(make_jpeg(21, 4, 3, true, smooth), {.max_bytes = 21 * 4 * 10 - 1}), Error);
    EXPECT_THROW(decode_hdr(make_rle_hdr(), {.max_width = 15}), Error);
    EXPECT_THROW(decode_hdr(make_rle_hdr(), {.max_bytes = 16 * 3 * 12 - 1}), Error);
    EXPECT_THROW(decode_exr(sample_exr(), {.max_pixels = 23 * 19 - 1}), Error);
    EXPECT_THROW(decode_exr(sample_exr(), {.max_bytes = 23 * 19 * 16 - 1}), Error);
    EXPECT_NO_THROW(decode_exr(sample_exr(), {.max_bytes = 23 * 19 * 16}));
}

TEST(DecodeImage, a_header_that_claims_more_than_the_file_holds_is_refused_before_memory_is_taken) {
    ImageF image = make_image(1, 1, {"R"});
    image.attributes["note"] = "hello";
    Bytes exr = encode_exr(image, ExrPrecision::Half).bytes;
    const std::string_view text(reinterpret_cast<const char*>(exr.data()), exr.size());
    const size_t size_at = text.find("note") + 5 + 7;  // name, "string", then the size
    ASSERT_EQ(std::to_integer<int>(exr[size_at]), 5);
    exr[size_at + 3] = std::byte{0x7F};
    EXPECT_NE(error_of([&] { decode_exr(exr); }).find("larger than the file"), std::string::npos);
}

// OpenEXR reads a channel list to its end whatever its size says: with a wrong size it would see other attributes than the check did.
TEST(DecodeImage, an_exr_attribute_with_another_size_than_its_type_has_is_refused) {
    for (const std::string name : {"channels", "pixelAspectRatio", "dataWindow"}) {
        Bytes exr = encode_exr(make_image(1, 1, {"R"}), ExrPrecision::Half).bytes;
        const std::string_view text(reinterpret_cast<const char*>(exr.data()), exr.size());
        const size_t name_at = text.find(name), size_at = text.find('\0', name_at + name.size() + 1) + 1;
        ASSERT_NE(name_at, std::string_view::npos);
        exr[size_at] = static_cast<std::byte>(std::to_integer<int>(exr[size_at]) - 1);
        EXPECT_NE(error_of([&] { decode_exr(exr); }).find("an attribute in the header has a wrong size"), std::string::npos) << name;
    }
}

namespace {

struct Kind {
    const char* name;
    Bytes file;
    std::function<void(std::span<const std::byte>)> decode;
};

// Small limits: a flipped bit in a size must not make the tests slow.
std::vector<Kind> kinds_of_files() {
    static constexpr DecodeLimits kLimits{.max_width = 256, .max_height = 256, .max_pixels = 4096, .max_bytes = 1 << 18};
    const auto noise = [](size_t y, size_t i) { return static_cast<uint8_t>(37 * y + i * i); };
    const auto any = [](std::span<const std::byte> bytes) { decode_image(bytes, kLimits, "file"); };
    FilmSums film = make_film(9, 5, {"R", "depth"}, 0, 64);
    for (size_t i = 0; i < film.limbs.size(); ++i) film.limbs[i] = static_cast<uint32_t>(i * 2654435761u);
    return {{"png", make_png(24, 18, {PNG_COLOR_TYPE_RGB_ALPHA, 8}, noise), any},
            {"palette png", make_png(24, 18, {PNG_COLOR_TYPE_PALETTE, 2, true, true}, noise), any},
            {"jpeg", make_jpeg(24, 18, 3, false, smooth), any},
            {"progressive jpeg", make_jpeg(24, 18, 3, true, smooth), any},
            {"hdr", make_rle_hdr(), any},
            {"exr", sample_exr(), any},
            {"film", encode_film_exr(film), [](std::span<const std::byte> bytes) { decode_film_exr(bytes, kLimits, "file"); }}};
}

}  // namespace

TEST(DecodeImage, truncated_files_are_errors_that_name_the_file) {
    for (const Kind& kind : kinds_of_files()) {
        ASSERT_EQ(error_of([&] { kind.decode(kind.file); }), "") << kind.name;
        for (size_t size = 0; size < kind.file.size(); size += 7) {
            const std::string message = error_of([&] { kind.decode(std::span(kind.file).first(size)); });
            ASSERT_TRUE(message.starts_with("file: ")) << kind.name << " cut to " << size << " of " << kind.file.size() << ": " << message;
        }
    }
}

TEST(DecodeImage, flipped_bits_give_an_image_or_an_error) {
    std::mt19937 rng(11);
    for (const Kind& kind : kinds_of_files()) {
        for (int trial = 0; trial < 400; ++trial) {
            Bytes damaged = kind.file;
            for (uint32_t flips = 1 + rng() % 4; flips > 0; --flips) damaged[rng() % damaged.size()] ^= static_cast<std::byte>(1u << (rng() % 8));
            const std::string message = error_of([&] { kind.decode(damaged); });  // another exception or a crash fails the test
            EXPECT_TRUE(message.empty() || message.starts_with("file: ")) << kind.name << ": " << message;
        }
    }
}

}  // namespace parhelion::image::image_decode_test
