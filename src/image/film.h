#pragma once
// The film: exact sums of samples. Each channel of each pixel is a 96-bit two's complement integer in units of 2^-40, so adding
// blocks of samples is associative, and any split of a sample range merges to the same bits. The shaders' mirror of the
// arithmetic is shaders/lib/fixed_point.glsl. A sum overflows only beyond 2^55.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "image/decode.h"
#include "image/image.h"

namespace parhelion::image {

inline constexpr int kFixedFractionBits = 40;

struct Fixed96 {
    uint32_t low = 0, mid = 0, high = 0;
    friend bool operator==(const Fixed96&, const Fixed96&) = default;
};

// v * 2^40 rounded toward zero; |v| >= 2^50, infinities and NaN saturate to 2^50 with v's sign; subnormals are 0.
Fixed96 fixed_from_float(float v);
Fixed96 fixed_add(Fixed96 a, Fixed96 b);
Fixed96 fixed_negate(Fixed96 v);
// sum / 2^40 / count, rounded once to the nearest float. 1 <= count < 2^32.
float fixed_mean(Fixed96 sum, uint64_t count);

struct FilmSums {
    uint32_t width = 0, height = 0;
    std::vector<std::string> channels = {};
    uint64_t sample_begin = 0, sample_end = 0;  // half open, by sample index
    std::vector<uint32_t> limbs = {};                // limb l (low to high) of channel c of pixel p: [(3 c + l) * pixel_count + p]
    std::vector<ExactLayer> exact = {};              // layers that samples do not change: what is under the pixel's centre
    Attributes attributes = {};                      // what the picture depends on (settings hash, seed, ...): parts that differ do not merge

    size_t pixel_count() const { return static_cast<size_t>(width) * height; }
    Fixed96 sum(size_t channel, size_t pixel) const;
    void set_sum(size_t channel, size_t pixel, Fixed96 value);
    // Adds one block's float sum, as the add_block pass does.
    void add_block(size_t channel, size_t pixel, float block_sum);
};

FilmSums make_film(uint32_t width, uint32_t height, std::vector<std::string> channels, uint64_t sample_begin, uint64_t sample_end);

// Sums of squares of channel C are kept in two channels, kSquaresPrefix + C and kLargeSquaresPrefix + C, for squares range twice as
// far as the samples: those of samples below kLargeSquareFrom in the first, the others times kLargeSquareScale in the second. Both
// factors are powers of two, so nothing is lost by the division.
inline constexpr std::string_view kSquaresPrefix = "squares.", kLargeSquaresPrefix = "squares_large.";
inline constexpr double kLargeSquareScale = 0x1p-32;

// An unbiased estimate of the variance of the mean of `count` independent samples: (sum of squares - sum^2 / count) / (count (count - 1)),
// not below 0. +infinity for a single sample, and where large squares add up to more than 2^82: a square may have been beyond
// what a block holds.
float variance_of_mean(Fixed96 sum, Fixed96 squares, Fixed96 large_squares, uint64_t count);

// The mean of every channel, with the film's exact layers and attributes; sums of squares become exact layers "variance.<channel>".
// `samples_of_rows` tells how many samples each row's sums hold, none: all of the film's range. Throws Error for an empty range.
ImageF resolve_film(const FilmSums& film, std::span<const uint64_t> samples_of_rows = {});

struct FilmPart {
    const FilmSums* film = nullptr;
    std::string name;  // for messages: the file
};
// The film of all parts' ranges together; the order of the parts does not matter. Throws Error for no parts, ranges that overlap
// or leave a gap (says which samples are missing), and parts of different size, channels or attributes (says which). Exact layers
// are those of the first samples; the log warns where another part's differ.
FilmSums merge_films(std::span<const FilmPart> parts);

// A film as EXR: UINT channels "sum.<channel>.<0|1|2>", "layer.<channel>" of exact layers, and the range in the header. Appears whole or not at all.
void write_film_exr(const std::filesystem::path& path, const FilmSums& film);
std::vector<std::byte> encode_film_exr(const FilmSums& film);

// Throws Error for a file that is no film, is damaged, or is over the limits.
FilmSums read_film_exr(const std::filesystem::path& path, const DecodeLimits& limits = {});
FilmSums decode_film_exr(std::span<const std::byte> bytes, const DecodeLimits& limits = {}, std::string_view where = {});

}  // namespace parhelion::image
