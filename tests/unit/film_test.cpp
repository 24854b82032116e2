// The film's exact sums: arithmetic, merging, files.
#include "image/film.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "base/error.h"
#include "base/hash.h"
#include "image/encode.h"
#include "shared/view.h"

namespace parhelion::image::film_test {
namespace {

using Int128 = __int128;

Int128 to_integer(Fixed96 v) {
    const auto high = static_cast<Int128>(static_cast<int32_t>(v.high));
    return (high << 64) | (static_cast<Int128>(v.mid) << 32) | static_cast<Int128>(v.low);
}

Fixed96 from_integer(Int128 v) { return {static_cast<uint32_t>(v), static_cast<uint32_t>(v >> 32), static_cast<uint32_t>(v >> 64)}; }

// Positive floats whose logarithms are uniform, some negated.
float random_float(std::mt19937_64& rng, double min_exponent, double max_exponent) {
    const double v = std::exp2(std::uniform_real_distribution(min_exponent, max_exponent)(rng));
    return static_cast<float>((rng() & 3) == 0 ? -v : v);
}

// The error text of `action`, or "" if it succeeds.
template <class Action>
std::string error_of(const Action& action) {
    try {
        action();
    } catch (const Error& error) {
        return error.line;
    }
    return {};
}

// What one renderer run over [begin, end) leaves: per-sample values are a hash of (sample, channel, pixel), blocks of 64.
FilmSums render(uint64_t begin, uint64_t end) {
    FilmSums film = make_film(5, 3, {"R", "G", "B", "albedo.R", "roughness"}, begin, end);
    film.attributes = {{"settings_hash", "0123"}, {"exposure_ev100", "3.5"}};
    film.exact = {{"depth", false, {}}, {"ids.instance", true, {}}};
    for (size_t p = 0; p < film.pixel_count(); ++p) {
        film.exact[0].words.push_back(std::bit_cast<uint32_t>(p == 3 ? std::numeric_limits<float>::infinity() : 0.1f * static_cast<float>(p)));
        film.exact[1].words.push_back(0xFFFFFFFFu - static_cast<uint32_t>(p));
    }
    for (size_t c = 0; c < film.channels.size(); ++c)
        for (size_t p = 0; p < film.pixel_count(); ++p)
            for (uint64_t block = begin; block < end; block += 64) {
                float sum = 0.0f;
                for (uint64_t s = block; s < std::min(end, block + 64); ++s) {
                    const uint64_t bits = Hasher{}.add(s).add(c).add(p).value();
                    sum += std::ldexp(static_cast<float>(bits >> 40) - 5e6f, static_cast<int>(bits % 41) - 40);
                }
                film.add_block(c, p, sum);
            }
    return film;
}

bool same(const FilmSums& a, const FilmSums& b) {
    return a.width == b.width && a.height == b.height && a.channels == b.channels && a.sample_begin == b.sample_begin && a.sample_end == b.sample_end &&
           a.limbs == b.limbs && a.exact == b.exact && a.attributes == b.attributes;
}

FilmSums merge(std::initializer_list<FilmSums> films) {
    std::vector<FilmPart> parts;
    for (const FilmSums& film : films) parts.push_back({&film, fmt::format("part{}.exr", parts.size())});
    return merge_films(parts);
}

}  // namespace

TEST(Film, a_float_becomes_its_exact_integer_rounded_toward_zero) {
    std::mt19937_64 rng(1);
    for (int i = 0; i < 200000; ++i) {
        const float v = random_float(rng, -60.0, 49.999);
        const auto expected = static_cast<Int128>(std::ldexp(static_cast<long double>(v), 40));  // exact, truncates
        ASSERT_TRUE(to_integer(fixed_from_float(v)) == expected) << v;
    }
    for (const float v : {0.0f, -0.0f, 1e-40f, -1e-45f}) EXPECT_EQ(fixed_from_float(v), Fixed96{}) << v;
}

TEST(Film, a_float_beyond_the_range_saturates) {
    const Int128 limit = static_cast<Int128>(1) << 90;
    const float inf = std::numeric_limits<float>::infinity();
    for (const float v : {std::ldexp(1.0f, 50), std::ldexp(1.5f, 50), 1e20f, 3e38f, inf}) {
        EXPECT_TRUE(to_integer(fixed_from_float(v)) == limit) << v;
        EXPECT_TRUE(to_integer(fixed_from_float(-v)) == -limit) << v;
    }
    EXPECT_TRUE(to_integer(fixed_from_float(std::nextafter(std::ldexp(1.0f, 50), 0.0f))) < limit);
}

TEST(Film, addition_carries_through_all_limbs) {
    std::mt19937_64 rng(2);
    for (int i = 0; i < 100000; ++i) {
        const Int128 a = (static_cast<Int128>(static_cast<int64_t>(rng())) << 24) | static_cast<Int128>(rng() >> 40);
        const Int128 b = static_cast<Int128>(static_cast<int64_t>(rng())) << (rng() % 24);
        ASSERT_TRUE(to_integer(fixed_add(from_integer(a), from_integer(b))) == a + b);
    }
    EXPECT_EQ(fixed_add({0xFFFFFFFFu, 0xFFFFFFFFu, 0}, {1, 0, 0}), (Fixed96{0, 0, 1}));
    EXPECT_EQ(fixed_add({0, 0xFFFFFFFFu, 0}, {0, 1, 0}), (Fixed96{0, 0, 1}));
    EXPECT_EQ(fixed_add({0xFFFFFFFFu, 0xFFFFFFFFu, 0xFFFFFFFFu}, {1, 0, 0}), Fixed96{});
}

TEST(Film, the_mean_is_the_nearest_float_of_the_exact_quotient) {
    std::mt19937_64 rng(3);
    for (int i = 0; i < 100000; ++i) {
        const auto sum = static_cast<Int128>(static_cast<int64_t>(rng()) >> (rng() % 60));
        const uint64_t count = 1 + rng() % 4096;
        const float mean = fixed_mean(from_integer(sum), count);
        // |mean * count * 2^40 - sum| in units of 2^-24, exactly: float mantissas shifted into integers.
        const auto error = [&](float candidate) {
            int exponent = 0;
            const auto mantissa = static_cast<Int128>(std::ldexp(std::frexp(candidate, &exponent), 24));
            const int shift = exponent - 24 + 40 + 24;
            EXPECT_GE(shift, 0);
            const Int128 difference = (mantissa << shift) * static_cast<Int128>(count) - (sum << 24);
            return difference < 0 ? -difference : difference;
        };
        if (mean == 0.0f || std::abs(mean) < 1e-11f) continue;
        ASSERT_TRUE(error(mean) <= error(std::nextafter(mean, 1e30f)) && error(mean) <= error(std::nextafter(mean, -1e30f))) << mean;
    }
    EXPECT_EQ(fixed_mean(fixed_from_float(12.5f), 1), 12.5f);
    EXPECT_EQ(fixed_mean(fixed_from_float(-3.0f), 4), -0.75f);
    EXPECT_EQ(fixed_mean({1, 0, 0}, 0xFFFFFFFFu), static_cast<float>(std::ldexp(1.0 / 4294967295.0, -40)));
    EXPECT_EQ(fixed_mean({}, 7), 0.0f);
    // 2^24 + 1 lies halfway between two floats; a last bit of the sum more decides against rounding to even.
    const float even = std::ldexp(1.0f, 24), next = std::nextafter(even, 1e30f);
    EXPECT_EQ(fixed_mean(from_integer((static_cast<Int128>(1) << 64) + (static_cast<Int128>(1) << 40)), 1), even);
    EXPECT_EQ(fixed_mean(from_integer((static_cast<Int128>(1) << 64) + (static_cast<Int128>(1) << 40) + 1), 1), next);
}

TEST(Film, any_split_of_the_samples_merges_to_the_same_bits) {
    const FilmSums whole = render(0, 640);
    std::mt19937_64 rng(4);
    for (int trial = 0; trial < 20; ++trial) {
        std::vector<uint64_t> cuts = {0, 640};
        for (int i = 0; i < 4; ++i) cuts.push_back(64 * (rng() % 11));
        std::sort(cuts.begin(), cuts.end());
        cuts.erase(std::unique(cuts.begin(), cuts.end()), cuts.end());
        std::vector<FilmSums> films;
        for (size_t i = 1; i < cuts.size(); ++i) films.push_back(render(cuts[i - 1], cuts[i]));
        std::shuffle(films.begin(), films.end(), rng);
        std::vector<FilmPart> parts;
        for (const FilmSums& film : films) parts.push_back({&film, "part"});
        ASSERT_TRUE(same(merge_films(parts), whole));
    }
}

TEST(Film, merging_in_stages_equals_merging_at_once) {
    EXPECT_TRUE(same(merge({merge({render(64, 128), render(128, 320)}), render(0, 64)}), render(0, 320)));
}

TEST(Film, merging_refuses_what_does_not_fit_and_says_why) {
    EXPECT_NE(error_of([] { merge({}); }).find("no parts"), std::string::npos);
    EXPECT_NE(error_of([] { merge({render(0, 128), render(64, 192)}); }).find("part1.exr: its samples 64-192 overlap 0-128 of part0.exr"), std::string::npos);
    EXPECT_NE(error_of([] { merge({render(0, 64), render(0, 64)}); }).find("overlap"), std::string::npos);
    EXPECT_NE(error_of([] { merge({render(0, 64), render(256, 320), render(128, 192)}); }).find("the samples 64-128, 192-256 are missing"), std::string::npos);
    FilmSums other = render(64, 128);
    other.attributes["settings_hash"] = "4567";
    EXPECT_NE(error_of([&] { merge({render(0, 64), other}); }).find("part1.exr: settings_hash is '4567' here and '0123' in part0.exr"), std::string::npos);
    other = render(64, 128);
    other.attributes.erase("settings_hash");
    EXPECT_NE(error_of([&] { merge({render(0, 64), other}); }).find("settings_hash is missing here"), std::string::npos);
    other = render(64, 128);
    other.channels[3] = "normal.X";
    EXPECT_NE(error_of([&] { merge({render(0, 64), other}); }).find("has the channels"), std::string::npos);
    EXPECT_NE(error_of([&] { merge({render(0, 64), make_film(4, 3, other.channels, 64, 128)}); }).find("is 4x3 pixels"), std::string::npos);
}

TEST(Film, resolving_gives_the_mean_of_the_samples) {
    FilmSums film = make_film(2, 1, {"R", "G"}, 64, 72);
    film.attributes["exposure_ev100"] = "1";
    film.add_block(0, 0, 24.0f);
    film.add_block(0, 0, -8.0f);
    film.add_block(1, 1, 4.0f);
    const ImageF image = resolve_film(film);
    EXPECT_EQ(image.channels, film.channels);
    EXPECT_EQ(image.attributes, film.attributes);
    EXPECT_EQ(image.data, (std::vector<float>{2.0f, 0.0f, 0.0f, 0.5f}));
    film.sample_end = film.sample_begin;
    EXPECT_THROW(resolve_film(film), Error);
}

TEST(Film, exact_layers_are_those_of_the_first_samples) {
    FilmSums first = render(0, 64), second = render(64, 128);
    EXPECT_EQ(resolve_film(first).exact, first.exact);
    second.exact[1].words[2] = 7;  // another device saw another triangle
    const FilmPart parts[] = {{&second, "second"}, {&first, "first"}};
    EXPECT_EQ(merge_films(parts).exact, first.exact);
    second.exact.pop_back();
    EXPECT_NE(error_of([&] { merge_films(parts); }).find("other layers"), std::string::npos);
}

// (1 + 2 + 3 + 6)^2 = 144, 1 + 4 + 9 + 36 = 50: the variance of four samples is (50 - 144 / 4) / 3, their mean's a quarter of it.
TEST(Film, sums_of_squares_become_the_variance_of_the_mean) {
    FilmSums film = make_film(2, 2, {"R", "squares.R", "squares_large.R"}, 0, 4);
    const auto add = [&](size_t pixel, std::initializer_list<double> samples) {
        for (const double v : samples) {
            film.add_block(0, pixel, static_cast<float>(v));
            if (v * v < shared::kLargeSquareFrom) film.add_block(1, pixel, static_cast<float>(v * v));
            else film.add_block(2, pixel, static_cast<float>(v * v * shared::kLargeSquareScale));
        }
    };
    add(0, {1, 2, 3, 6});
    add(1, {100, 200, 300, 1e9});  // the sun among them
    add(2, {0x1p-20, 0x1p-20, 0x1p-20, 0});
    add(3, {1, 1, 1, 0x1p42});
    static_assert(kLargeSquareScale == shared::kLargeSquareScale);
    const ImageF picture = resolve_film(film);
    EXPECT_EQ(picture.channels, (std::vector<std::string>{"R"}));
    ASSERT_EQ(picture.exact.size(), 1u);
    EXPECT_EQ(picture.exact[0].channel, "variance.R");
    const auto variance = [&](size_t pixel) { return std::bit_cast<float>(picture.exact[0].words[pixel]); };
    EXPECT_FLOAT_EQ(variance(0), 14.0f / 12);
    EXPECT_NEAR(variance(1) / ((1e18 + 140000 - (1e9 + 600) * (1e9 + 600) / 4) / 12), 1.0, 1e-6);
    EXPECT_FLOAT_EQ(variance(2), 0x1p-40f * (3 - 9.0f / 4) / 12);
    EXPECT_EQ(variance(3), std::numeric_limits<float>::infinity()) << "beyond what the sums hold, said loudly";
    film.sample_end = 1;
    EXPECT_EQ(std::bit_cast<float>(resolve_film(film).exact[0].words[0]), std::numeric_limits<float>::infinity()) << "one sample says nothing of the variance";
    film.channels[2] = "other";
    EXPECT_THROW(resolve_film(film), Error);
}

TEST(Film, rounding_does_not_make_a_variance_negative) {
    EXPECT_EQ(variance_of_mean(fixed_from_float(3.0f), fixed_from_float(2.9999f), {}, 3), 0.0f);
}

TEST(Film, a_film_survives_its_file_with_its_channel_order) {
    const FilmSums film = render(64, 256);
    const std::vector<std::byte> bytes = encode_film_exr(film);
    EXPECT_TRUE(same(decode_film_exr(bytes), film));
    EXPECT_EQ(bytes, encode_film_exr(merge({render(128, 256), render(64, 128)}))) << "merged parts and the whole must give one file";
}

TEST(Film, reading_refuses_files_that_are_no_film) {
    ImageF picture = make_image(4, 4, {"R", "G", "B"});
    EXPECT_NE(error_of([&] { decode_film_exr(encode_exr(picture, ExrPrecision::Float).bytes, {}, "a.exr"); }).find("a.exr: is no film"), std::string::npos);
    const std::string text = "not an image";
    EXPECT_NE(error_of([&] { decode_film_exr(std::as_bytes(std::span(text)), {}, "a.txt"); }).find("is no film"), std::string::npos);
    UintImage odd{.width = 1, .height = 1, .channels = {"sum.R.0", "sum.R.1"}, .data = {1, 2}};
    EXPECT_NE(error_of([&] { decode_film_exr(encode_uint_exr(odd)); }).find("lacks the attribute"), std::string::npos);
    odd.attributes = {{"parhelion.film", "1"}, {"parhelion.sample_begin", "0"}, {"parhelion.sample_end", "64"}, {"parhelion.channels", "R"}};
    EXPECT_NE(error_of([&] { decode_film_exr(encode_uint_exr(odd)); }).find("damaged film"), std::string::npos);
    odd.channels.push_back("sum.G.2");
    odd.data.push_back(3);
    EXPECT_NE(error_of([&] { decode_film_exr(encode_uint_exr(odd)); }).find("lacks the channel sum.R.2"), std::string::npos);
    for (const char* end : {"0", "-1", "64x", "", "99999999999"}) {
        UintImage bad = odd;
        bad.channels[2] = "sum.R.2";
        bad.attributes["parhelion.sample_end"] = end;
        EXPECT_NE(error_of([&] { decode_film_exr(encode_uint_exr(bad)); }).find("damaged film"), std::string::npos) << end;
    }
    for (const char* layers : {"depth", "depth:half", "depth:float", ""}) {
        UintImage bad = odd;
        bad.channels[2] = "sum.R.2";
        bad.attributes["parhelion.layers"] = layers;
        EXPECT_NE(error_of([&] { decode_film_exr(encode_uint_exr(bad)); }).find("damaged film"), std::string::npos) << layers;
    }
    odd.attributes["parhelion.film"] = "2";
    EXPECT_NE(error_of([&] { decode_film_exr(encode_uint_exr(odd)); }).find("version 2"), std::string::npos);
}

}  // namespace parhelion::image::film_test
