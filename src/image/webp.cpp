// WebP through libwebp (container: RFC 9649, 2).
#include <webp/decode.h>

#include "image/limits.h"

namespace parhelion::image {

namespace {

[[noreturn]] void refuse_status(VP8StatusCode status, std::string_view where) {
    switch (status) {
        case VP8_STATUS_NOT_ENOUGH_DATA:
        case VP8_STATUS_SUSPENDED: refuse_image(where, "is a damaged WebP: its data end before the picture does", "the file is cut off");
        case VP8_STATUS_OUT_OF_MEMORY: refuse_image(where, "is a WebP that needs more memory than there is");
        case VP8_STATUS_UNSUPPORTED_FEATURE: refuse_image(where, "is a WebP with a feature that is not supported", "save it again, or as PNG");
        default: refuse_image(where, "is a damaged WebP: its data make no sense");
    }
}

// The container says how long it is; the decoder alone would forgive what is missing behind the picture.
void check_length(std::span<const std::byte> bytes, std::string_view where) {
    if (bytes.size() < 12) refuse_image(where, "is a damaged WebP: its header is cut off");
    uint64_t length = 8;
    for (size_t i = 0; i < 4; ++i) length += uint64_t(std::to_integer<uint32_t>(bytes[4 + i])) << (8 * i);
    if (length > bytes.size())
        refuse_image(where, fmt::format("is a damaged WebP: it has {} bytes, its header says {}", bytes.size(), length), "the file is cut off");
}

}  // namespace

Texture8 decode_webp(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    check_length(bytes, where);
    const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
    WebPDecoderConfig config;
    if (!WebPInitDecoderConfig(&config)) refuse_image(where, "cannot be read: this libwebp is another than Parhelion was built with");
    const VP8StatusCode header = WebPGetFeatures(data, bytes.size(), &config.input);
    if (header != VP8_STATUS_OK) refuse_status(header, where);
    if (config.input.has_animation) refuse_image(where, "is an animated WebP, which is not supported", "save one of its pictures as WebP or PNG");

    Texture8 out{.width = static_cast<uint32_t>(config.input.width), .height = static_cast<uint32_t>(config.input.height)};
    check_limits(out.width, out.height, 4, limits, where);
    out.rgba.resize(size_t{4} * out.width * out.height);
    config.output.colorspace = MODE_RGBA;
    config.output.is_external_memory = 1;
    config.output.u.RGBA = {out.rgba.data(), static_cast<int>(4 * out.width), out.rgba.size()};
    const VP8StatusCode status = WebPDecode(data, bytes.size(), &config);
    WebPFreeDecBuffer(&config.output);
    if (status != VP8_STATUS_OK) refuse_status(status, where);
    return out;
}

}  // namespace parhelion::image
