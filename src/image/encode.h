#pragma once
// Images to files. The write_ functions go through AtomicFile: a file appears whole or not at all, and a full disk is a clear
// Error. Equal images give equal bytes: no time, host or path goes into a file.
#include <cstddef>
#include <filesystem>
#include <vector>

#include "image/decode.h"
#include "image/image.h"

namespace parhelion::image {

// 8-bit RGB PNG marked as sRGB, with the picture's attributes as tEXt chunks.
std::vector<std::byte> encode_png(const Picture8& picture);
// 8-bit RGBA PNG without any word on its colours, for textures: decode_png gives the same texels back.
std::vector<std::byte> encode_png(const Texture8& texture);
void write_png(const std::filesystem::path& path, const Picture8& picture);

enum class ExrPrecision { Half, Float };

struct EncodedExr {
    std::vector<std::byte> bytes;
    uint64_t clamped = 0;  // values beyond the range of half, written as its largest (65504)
};

// Single-part scanline EXR with ZIP compression: all channels of the image, its exact layers as FLOAT or UINT whatever the
// precision, and its attributes as strings. Throws Error where the image has no channel.
EncodedExr encode_exr(const ImageF& image, ExrPrecision precision);
std::vector<std::byte> encode_uint_exr(const UintImage& image);
// Returns EncodedExr::clamped.
uint64_t write_exr(const std::filesystem::path& path, const ImageF& image, ExrPrecision precision);

}  // namespace parhelion::image
