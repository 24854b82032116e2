#include "image/film.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "base/log.h"
#include "base/parallel.h"

namespace parhelion::image {

namespace {

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
    if (!std::ranges::equal(film.exact, other.exact, [](const ExactLayer& a, const ExactLayer& b) { return a.same_kind(b); }))
        refuse(part, fmt::format("has other layers than {}", escape_name(first.name)), "give all parts the same --aov");
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

// Parts from different devices may see another triangle where a pixel's centre lies on an edge.
void warn_of_differences(const FilmPart& part, const FilmPart& first) {
    for (size_t i = 0; i < part.film->exact.size(); ++i) {
        const std::vector<uint32_t>&mine = part.film->exact[i].words, &theirs = first.film->exact[i].words;
        size_t count = 0;
        for (size_t pixel = 0; pixel < mine.size(); ++pixel) count += mine[pixel] != theirs[pixel];
        if (count != 0)
            log(LogLevel::Warn, "{}: {} differs from {}'s in {} pixels (another device?); {}'s is kept", escape_name(part.name),
                escape_name(part.film->exact[i].channel), escape_name(first.name), count, escape_name(first.name));
    }
}

}  // namespace

Fixed96 fixed_from_float(float v) {
    const uint32_t bits = std::bit_cast<uint32_t>(v);
    const uint32_t biased = (bits >> 23) & 0xFFu;
    if (biased == 0) return {};
    const uint64_t mantissa = (bits & 0x7FFFFFu) | 0x800000u;
    const int shift = static_cast<int>(biased) - 127 - 23 + kFixedFractionBits;  // v = mantissa * 2^(shift - 40)
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
    return (bits >> 31) != 0 ? fixed_negate(out) : out;
}

Fixed96 fixed_add(Fixed96 a, Fixed96 b) {
    const uint64_t low = uint64_t{a.low} + b.low;
    const uint64_t mid = uint64_t{a.mid} + b.mid + (low >> 32);
    return {static_cast<uint32_t>(low), static_cast<uint32_t>(mid), static_cast<uint32_t>(a.high + b.high + (mid >> 32))};
}

Fixed96 fixed_negate(Fixed96 v) { return fixed_add({~v.low, ~v.mid, ~v.high}, {1, 0, 0}); }

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

FilmSums merge_films(std::span<const FilmPart> parts) {
    if (parts.empty()) throw Error(ErrorCode::Failed, "there are no parts to merge");
    std::vector<FilmPart> sorted(parts.begin(), parts.end());
    for (const FilmPart& part : parts) check_part(part, parts.front());
    std::stable_sort(sorted.begin(), sorted.end(), [](const FilmPart& a, const FilmPart& b) { return a.film->sample_begin < b.film->sample_begin; });
    check_ranges(sorted);
    for (const FilmPart& part : sorted) warn_of_differences(part, sorted.front());

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
