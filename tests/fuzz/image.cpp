// One image format; PARHELION_FUZZ_DECODE is its decoder (tests/fuzz/CMakeLists.txt builds a target for each).
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/error.h"
#include "image/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    constexpr parhelion::image::DecodeLimits kLimits{.max_width = 4096, .max_height = 4096, .max_pixels = 1 << 20, .max_bytes = 16 << 20};
    try {
        parhelion::image::PARHELION_FUZZ_DECODE(std::as_bytes(std::span(data, size)), kLimits, "fuzz");
    } catch (const parhelion::Error&) {
        // The answer to a broken file.
    }
    return 0;
}
