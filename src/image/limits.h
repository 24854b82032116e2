#pragma once
// Inside the image library: the check that every decoder makes before it allocates.
#include <string>
#include <string_view>

#include "base/error.h"
#include "image/decode.h"

namespace parhelion::image {

[[noreturn]] inline void refuse_image(std::string_view where, std::string what, std::string hint = {}) {
    throw Error(ErrorCode::Failed, std::move(what), escape_name(where), std::move(hint));
}

// Throws unless an image of this size, at bytes_per_pixel decoded, is inside the limits.
inline void check_limits(uint64_t width, uint64_t height, uint64_t bytes_per_pixel, const DecodeLimits& limits, std::string_view where) {
    if (width == 0 || height == 0) refuse_image(where, fmt::format("is an empty image ({}x{})", width, height));
    if (width > limits.max_width || height > limits.max_height)
        refuse_image(where, fmt::format("is {}x{} pixels; the limit is {}x{}", width, height, limits.max_width, limits.max_height));
    const uint64_t pixels = width * height;
    if (pixels > limits.max_pixels) refuse_image(where, fmt::format("has {} pixels; the limit is {}", pixels, limits.max_pixels));
    if (bytes_per_pixel > limits.max_bytes / pixels)
        refuse_image(where, fmt::format("needs {} bytes for each of {} pixels; the limit is {} bytes in all", bytes_per_pixel, pixels, limits.max_bytes));
}

}  // namespace parhelion::image
