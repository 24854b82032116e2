#include "image/decode.h"

#include <algorithm>
#include <array>

#include "base/file.h"
#include "image/limits.h"

namespace parhelion::image {

namespace {

constexpr uint64_t kMaxFileBytes = uint64_t{4} << 30;

bool starts_with(std::span<const std::byte> bytes, std::string_view magic, size_t offset = 0) {
    if (bytes.size() < offset + magic.size()) return false;
    return std::equal(magic.begin(), magic.end(), bytes.begin() + static_cast<std::ptrdiff_t>(offset),
                      [](char expected, std::byte found) { return static_cast<std::byte>(expected) == found; });
}

Texels texels_of(Texture8&& texture) { return {.width = texture.width, .height = texture.height, .bytes = std::move(texture.rgba)}; }

// The finest level, within the limits as plain texels too.
Texture8 finest_level(const Texels& texels, const DecodeLimits& limits, std::string_view where) {
    check_limits(texels.width, texels.height, 4, limits, where);
    const auto level = std::span(texels.bytes).first(level_bytes(texels.format, texels.width, texels.height));
    return {.width = texels.width, .height = texels.height, .rgba = decode_to_rgba8(texels.format, texels.width, texels.height, 1, level)};
}

}  // namespace

Format detect_format(std::span<const std::byte> bytes) {
    using namespace std::string_view_literals;
    if (starts_with(bytes, "\x89PNG\r\n\x1a\n"sv)) return Format::Png;
    if (starts_with(bytes, "\xff\xd8\xff"sv)) return Format::Jpeg;
    if (starts_with(bytes, "\x76\x2f\x31\x01"sv)) return Format::Exr;
    if (starts_with(bytes, "#?RADIANCE"sv) || starts_with(bytes, "#?RGBE"sv)) return Format::Hdr;
    if (starts_with(bytes, "RIFF"sv) && starts_with(bytes, "WEBP"sv, 8)) return Format::Webp;
    if (starts_with(bytes, "\xabKTX 20\xbb\r\n\x1a\n"sv)) return Format::Ktx2;
    return Format::Unknown;
}

std::string_view format_name(Format format) {
    static constexpr std::array<std::string_view, 7> kNames = {"unknown", "PNG", "JPEG", "Radiance HDR", "OpenEXR", "WebP", "KTX2"};
    return kNames.at(static_cast<size_t>(format));
}

Decoded decode_image(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    switch (detect_format(bytes)) {
        case Format::Png: return decode_png(bytes, limits, where);
        case Format::Jpeg: return decode_jpeg(bytes, limits, where);
        case Format::Webp: return decode_webp(bytes, limits, where);
        case Format::Ktx2: return finest_level(decode_ktx2(bytes, limits, where), limits, where);
        case Format::Hdr: return decode_hdr(bytes, limits, where);
        case Format::Exr: return decode_exr(bytes, limits, where);
        case Format::Unknown: break;
    }
    refuse_image(where, "is no image of a known format", "PNG, JPEG, WebP, KTX2, Radiance HDR and OpenEXR are read");
}

Texels decode_texels(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    const Format format = detect_format(bytes);
    switch (format) {
        case Format::Png: return texels_of(decode_png(bytes, limits, where));
        case Format::Jpeg: return texels_of(decode_jpeg(bytes, limits, where));
        case Format::Webp: return texels_of(decode_webp(bytes, limits, where));
        case Format::Ktx2: return decode_ktx2(bytes, limits, where);
        default: break;
    }
    refuse_image(where, format == Format::Unknown ? "is no image of a known format" : fmt::format("is a {} image, which textures cannot be", format_name(format)),
                 "textures are PNG, JPEG, WebP or KTX2");
}

ImageF decode_linear(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    Decoded decoded = decode_image(bytes, limits, where);
    if (auto* image = std::get_if<ImageF>(&decoded)) return std::move(*image);
    return linear_image(std::get<Texture8>(decoded));
}

ImageF read_linear(const std::filesystem::path& path, const DecodeLimits& limits) {
    return decode_linear(read_file(path, kMaxFileBytes), limits, path.string());
}

}  // namespace parhelion::image
