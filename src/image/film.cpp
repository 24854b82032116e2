#include "image/film.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "base/parallel.h"

namespace parhelion::image {

namespace {

constexpr int kFractionBits = 40;

Fixed96 negate(Fixed96 v) { return fixed_add({~v.low, ~v.mid, ~v.high}, {1, 0, 0}); }

std::string range_text(uint64_t begin, uint64_t end) { return fmt::format("{}-{}", begin, end); }

std::string join(const std::vector<std::string>& names) {
    std::string out;
    for (const std::string& name : names) out += (out.empty() ? "" : ", ") + escape_name(name);
    return out;
}

[[noreturn]] void refuse(const FilmPart& part, std::string what, std::string hint = {}) {
    throw Error(ErrorCode::Failed, std::move(what), escape_name(part.name), std::move(hint));
}

// An attribute's value in quotes, or "missing".
std::string shown_attribute(const Attributes& attributes, const std::string& key) {
    const auto found = attributes.find(key);
    return found == attributes.end() ? "missing" : fmt::format("'{}'", escape_name(found->second));
}

void check_attributes(const FilmPart& part, const FilmPart& first) {
    Attributes all = first.film->attributes;
    all.insert(part.film->attributes.begin(), part.film->attributes.end());
    for (const auto& [key, unused] : all) {
        const std::string mine = shown_attribute(part.film->attributes, key), theirs = shown_attribute(first.film->attributes, key);
        if (mine != theirs)
            refuse(part, fmt::format("{} is {} here and {} in {}", escape_name(key), mine, theirs, escape_name(first.name)),
                   "parts must be renders of one picture that differ in their sample range only");
    }
}

void check_part(const FilmPart& part, const FilmPart& first) {
    const FilmSums &film = *part.film, &other = *first.film;
    if (film.width != other.width || film.height != other.height)
        refuse(part, fmt::format("is {}x{} pixels, {} is {}x{}", film.width, film.height, escape_name(first.name), other.width, other.height));
    if (film.channels != other.channels)
        refuse(part, fmt::format("has the channels {}; {} has {}", join(film.channels), escape_name(first.name), join(other.channels)));
    check_attributes(part, first);
    if (film.sample_begin >= film.sample_end) refuse(part, fmt::format("its sample range {} is empty", range_text(film.sample_begin, film.sample_end)));
}

// Parts in order of their ranges, which must follow one another without overlap or gap.
void check_ranges(std::span<const FilmPart> sorted) {
    std::string missing;
    for (size_t i = 1; i < sorted.size(); ++i) {
        const uint64_t end = sorted[i - 1].film->sample_end, begin = sorted[i].film->sample_begin;
        if (begin < end)
            refuse(sorted[i], fmt::format("its samples {} overlap {} of {}", range_text(begin, sorted[i].film->sample_end),
                                          range_text(sorted[i - 1].film->sample_begin, end), escape_name(sorted[i - 1].name)),
                   "give each part once");
        if (begin > end) missing += (missing.empty() ? "" : ", ") + range_text(end, begin);
    }
    if (!missing.empty())
        throw Error(ErrorCode::Failed, "the samples " + missing + " are missing between the parts", {}, "render them with --spp-range");
}

}  // namespace

Fixed96 fixed_from_float(float v) {
    const uint32_t bits = std::bit_cast<uint32_t>(v);
    const uint32_t biased = (bits >> 23) & 0xFFu;
    if (biased == 0) return {};
    const uint64_t mantissa = (bits & 0x7FFFFFu) | 0x800000u;
    const int shift = static_cast<int>(biased) - 127 - 23 + kFractionBits;  // v = mantissa * 2^(shift - 40)
    Fixed96 out;
    if (shift >= 67) {
        out.high = 1u << 26;  // 2^50 * 2^40 = 2^90
    } else if (shift <= 0) {
        out.low = shift > -24 ? static_cast<uint32_t>(mantissa >> -shift) : 0u;
    } else {
        const uint64_t shifted = mantissa << (shift & 31);
        const std::array<uint32_t, 2> words = {static_cast<uint32_t>(shifted), static_cast<uint32_t>(shifted >> 32)};
        if (shift < 32) out = {words[0], words[1], 0};
        else if (shift < 64) out = {0, words[0], words[1]};
        else out = {0, 0, words[0]};
    }
    return (bits >> 31) != 0 ? negate(out) : out;
}

Fixed96 fixed_add(Fixed96 a, Fixed96 b) {
    const uint64_t low = uint64_t{a.low} + b.low;
    const uint64_t mid = uint64_t{a.mid} + b.mid + (low >> 32);
    return {static_cast<uint32_t>(low), static_cast<uint32_t>(mid), static_cast<uint32_t>(a.high + b.high + (mid >> 32))};
}

// Long division of the magnitude with 64 more bits of fraction; what is left beyond the 64 leading quotient bits only decides
// ties, so it becomes a sticky lowest bit, and the conversion of that integer to float is the one rounding.
float fixed_mean(Fixed96 sum, uint64_t count) {
    PARHELION_CHECK(count >= 1 && count <= 0xFFFFFFFFu, "a mean of {} samples", count);
    const bool negative = (sum.high >> 31) != 0;
    if (negative) sum = negate(sum);
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
    const int exponent = 32 * (3 - static_cast<int>(first)) - 64 - kFractionBits;
    const float magnitude = std::ldexp(static_cast<float>(leading | (sticky ? 1u : 0u)), exponent);
    return negative ? -magnitude : magnitude;
}

Fixed96 FilmSums::sum(size_t channel, size_t pixel) const {
    const size_t pixels = pixel_count(), low = 3 * channel * pixels + pixel;
    return {limbs[low], limbs[low + pixels], limbs[low + 2 * pixels]};
}

void FilmSums::set_sum(size_t channel, size_t pixel, Fixed96 value) {
    const size_t pixels = pixel_count(), low = 3 * channel * pixels + pixel;
    limbs[low] = value.low;
    limbs[low + pixels] = value.mid;
    limbs[low + 2 * pixels] = value.high;
}

void FilmSums::add_block(size_t channel, size_t pixel, float block_sum) {
    set_sum(channel, pixel, fixed_add(sum(channel, pixel), fixed_from_float(block_sum)));
}

FilmSums make_film(uint32_t width, uint32_t height, std::vector<std::string> channels, uint64_t sample_begin, uint64_t sample_end) {
    FilmSums film{.width = width, .height = height, .channels = std::move(channels), .sample_begin = sample_begin, .sample_end = sample_end};
    film.limbs.resize(3 * film.channels.size() * film.pixel_count());
    return film;
}

ImageF resolve_film(const FilmSums& film) {
    if (film.sample_begin >= film.sample_end) throw Error(ErrorCode::Failed, "the film holds no samples");
    const uint64_t count = film.sample_end - film.sample_begin;
    ImageF image = make_image(film.width, film.height, film.channels);
    image.attributes = film.attributes;
    const size_t pixels = film.pixel_count();
    parallel_for(film.channels.size() * pixels, 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) image.data[i] = fixed_mean(film.sum(i / pixels, i % pixels), count);
    });
    return image;
}

FilmSums merge_films(std::span<const FilmPart> parts) {
    if (parts.empty()) throw Error(ErrorCode::Failed, "there are no parts to merge");
    std::vector<FilmPart> sorted(parts.begin(), parts.end());
    for (const FilmPart& part : parts) check_part(part, parts.front());
    std::stable_sort(sorted.begin(), sorted.end(), [](const FilmPart& a, const FilmPart& b) { return a.film->sample_begin < b.film->sample_begin; });
    check_ranges(sorted);

    FilmSums merged = *sorted.front().film;
    merged.sample_end = sorted.back().film->sample_end;
    const size_t pixels = merged.pixel_count();
    parallel_for(merged.channels.size() * pixels, 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            Fixed96 sum;
            for (const FilmPart& part : sorted) sum = fixed_add(sum, part.film->sum(i / pixels, i % pixels));
            merged.set_sum(i / pixels, i % pixels, sum);
        }
    });
    return merged;
}

}  // namespace parhelion::image
