#pragma once
// Image files to memory, with limits that are checked before anything is decoded. The format is found by content, not by name.
// Every function throws Error for a file that is damaged, truncated, unsupported or over the limits; `where` names it there.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "image/image.h"
#include "image/texels.h"

namespace parhelion::image {

struct DecodeLimits {
    uint32_t max_width = 32768, max_height = 32768;
    uint64_t max_pixels = uint64_t{1} << 28;  // 16384 x 16384
    uint64_t max_bytes = uint64_t{1} << 30;   // of the decoded image
};

enum class Format { Unknown, Png, Jpeg, Hdr, Exr, Webp, Ktx2 };
Format detect_format(std::span<const std::byte> bytes);
std::string_view format_name(Format format);

// Any PNG as RGBA: palettes, grey and tRNS expanded, 16 bits a channel reduced to 8 (rounded). Gamma and colour profiles are not
// applied (glTF 2.0, 3.8.4.3 asks for that).
Texture8 decode_png(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});
// Baseline and progressive JPEG, grey or colour. EXIF orientation is not applied.
Texture8 decode_jpeg(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});
// Lossy and lossless WebP, with alpha or without; its first picture only, so that an animated one is refused.
Texture8 decode_webp(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});
// KTX2, two-dimensional: R8, RG8, RGB8, BGR8, RGBA8 and BGRA8 as Rgba8; BC1, BC3, BC4, BC5 and BC7 as they are; all stored levels, plain
// or zstd. No Basis Universal, arrays, cube maps; rows must run from the top (KTXorientation rd) with straight alpha.
Texels decode_ktx2(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});
// What in a KTX2 of sound structure decode_ktx2 does not read ("Basis Universal texels"), from its header alone; none if it does.
std::optional<std::string> ktx2_obstacle(std::span<const std::byte> bytes, std::string_view where = {});
// Radiance RGBE, flat and both run-length codings, all eight orientations, to R, G, B = mantissa * 2^(exponent - 136), as other
// renderers read it. EXPOSURE lines are kept as the attribute "EXPOSURE" and not applied.
ImageF decode_hdr(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});
// The first part of an EXR: all channels as float (UINT converted), the data window, string attributes. No deep data, no
// subsampled chroma.
ImageF decode_exr(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});

// UINT channels of an EXR, exactly. Throws if a channel is of another type.
struct UintImage {
    uint32_t width = 0, height = 0;
    std::vector<std::string> channels = {};  // in order of their names
    std::vector<uint32_t> data = {};         // [channel * pixel_count + pixel]
    Attributes attributes = {};
};
UintImage decode_uint_exr(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});

using Decoded = std::variant<Texture8, ImageF>;
// Any supported format. Of a KTX2 the finest level, blocks decoded.
Decoded decode_image(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});

// Whatever a texture may be made of: PNG, JPEG, WebP, KTX2.
Texels decode_texels(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});

// Any supported format as linear float; eight-bit formats count as sRGB and become R, G, B.
ImageF decode_linear(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});
ImageF read_linear(const std::filesystem::path& path, const DecodeLimits& limits = {});

}  // namespace parhelion::image
