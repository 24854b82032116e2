// Pictures from exact sums: means and variances.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "image/film.h"

namespace parhelion::image {

namespace {

bool is_negative(Fixed96 v) { return (v.high >> 31) != 0; }

double to_double(Fixed96 v) {
    const bool negative = is_negative(v);
    if (negative) v = fixed_negate(v);
    const double magnitude = std::ldexp(v.high, 64 - kFixedFractionBits) + std::ldexp(v.mid, 32 - kFixedFractionBits) + std::ldexp(v.low, -kFixedFractionBits);
    return negative ? -magnitude : magnitude;
}

constexpr size_t kGrain = 65536;
constexpr size_t kNoChannel = std::numeric_limits<size_t>::max();

size_t channel_of(const FilmSums& film, const std::string& name) {
    const auto found = std::find(film.channels.begin(), film.channels.end(), name);
    return found == film.channels.end() ? kNoChannel : static_cast<size_t>(found - film.channels.begin());
}

bool holds_squares(std::string_view channel) { return channel.starts_with(kSquaresPrefix) || channel.starts_with(kLargeSquaresPrefix); }

ExactLayer resolve_variance(const FilmSums& film, const std::string& channel, std::span<const uint64_t> samples_of_rows) {
    const size_t sums = channel_of(film, channel), squares = channel_of(film, std::string(kSquaresPrefix) + channel),
                 large = channel_of(film, std::string(kLargeSquaresPrefix) + channel);
    if (sums == kNoChannel || large == kNoChannel)
        throw Error(ErrorCode::Failed, fmt::format("the film holds squares of {} without what belongs to them", escape_name(channel)));
    ExactLayer layer{.channel = "variance." + channel, .words = std::vector<uint32_t>(film.pixel_count())};
    parallel_for(layer.words.size(), kGrain, [&](size_t begin, size_t end) {
        for (size_t p = begin; p < end; ++p)
            layer.words[p] = std::bit_cast<uint32_t>(
                variance_of_mean(film.sum(sums, p), film.sum(squares, p), film.sum(large, p), samples_of_rows[p / film.width]));
    });
    return layer;
}

}  // namespace

// Long division of the magnitude with 64 more bits of fraction; what is left beyond the 64 leading quotient bits only decides
// ties, so it becomes a sticky lowest bit, and the conversion of that integer to float is the one rounding.
float fixed_mean(Fixed96 sum, uint64_t count) {
    PARHELION_CHECK(count >= 1 && count <= 0xFFFFFFFFu, "a mean of {} samples", count);
    const bool negative = is_negative(sum);
    if (negative) sum = fixed_negate(sum);
    const std::array<uint32_t, 5> numerator = {sum.high, sum.mid, sum.low, 0, 0};
    std::array<uint32_t, 5> quotient{};
    uint64_t remainder = 0;
    for (size_t i = 0; i < numerator.size(); ++i) {
        const uint64_t value = (remainder << 32) | numerator[i];
        quotient[i] = static_cast<uint32_t>(value / count);
        remainder = value % count;
    }
    size_t first = 0;
    while (first < 3 && quotient[first] == 0) ++first;
    const uint64_t leading = (uint64_t{quotient[first]} << 32) | quotient[first + 1];
    bool sticky = remainder != 0;
    for (size_t i = first + 2; i < quotient.size(); ++i) sticky = sticky || quotient[i] != 0;
    // quotient[4] is worth 2^-64 of a unit; quotient[first + 1] is 3 - first words above it.
    const int exponent = 32 * (3 - static_cast<int>(first)) - 64 - kFixedFractionBits;
    const float magnitude = std::ldexp(static_cast<float>(leading | (sticky ? 1u : 0u)), exponent);
    return negative ? -magnitude : magnitude;
}

// In double: block sums are floats, whose roundings are far larger.
float variance_of_mean(Fixed96 sum, Fixed96 squares, Fixed96 large_squares, uint64_t count) {
    constexpr double kMostOfABlock = 0x1p50;
    const double large = to_double(large_squares);
    if (count < 2 || large >= kMostOfABlock || large < 0) return std::numeric_limits<float>::infinity();
    const double total = to_double(sum), n = static_cast<double>(count);
    const double spread = to_double(squares) + large / kLargeSquareScale - total * total / n;
    return static_cast<float>(std::max(spread, 0.0) / (n * (n - 1)));
}

ImageF resolve_film(const FilmSums& film, std::span<const uint64_t> samples_of_rows) {
    if (film.sample_begin >= film.sample_end) throw Error(ErrorCode::Failed, "the film holds no samples");
    const std::vector<uint64_t> all(film.height, film.sample_end - film.sample_begin);
    if (samples_of_rows.empty()) samples_of_rows = all;
    PARHELION_CHECK(samples_of_rows.size() == film.height, "{} counts for {} rows", samples_of_rows.size(), film.height);

    std::vector<size_t> means;
    for (size_t c = 0; c < film.channels.size(); ++c)
        if (!holds_squares(film.channels[c])) means.push_back(c);
    ImageF image{.width = film.width, .height = film.height, .attributes = film.attributes};
    for (const size_t c : means) image.channels.push_back(film.channels[c]);
    const size_t pixels = film.pixel_count();
    image.data.resize(means.size() * pixels);
    parallel_for(image.data.size(), kGrain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            image.data[i] = fixed_mean(film.sum(means[i / pixels], i % pixels), samples_of_rows[i % pixels / film.width]);
    });
    for (const std::string& channel : film.channels)
        if (channel.starts_with(kSquaresPrefix))
            image.exact.push_back(resolve_variance(film, channel.substr(kSquaresPrefix.size()), samples_of_rows));
    image.exact.insert(image.exact.end(), film.exact.begin(), film.exact.end());
    return image;
}

}  // namespace parhelion::image
