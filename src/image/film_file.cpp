// Film sums as EXR files.
#include <algorithm>
#include <charconv>

#include "base/file.h"
#include "image/encode.h"
#include "image/film.h"
#include "image/limits.h"

namespace parhelion::image {

namespace {

// Reserved attributes. The order of channels is kept apart, for EXR sorts them by name.
constexpr std::string_view kVersionKey = "parhelion.film", kBeginKey = "parhelion.sample_begin", kEndKey = "parhelion.sample_end",
                           kChannelsKey = "parhelion.channels", kLayersKey = "parhelion.layers";
constexpr std::string_view kVersion = "1";
constexpr uint64_t kMaxFileBytes = uint64_t{16} << 30;

std::string limb_name(std::string_view channel, size_t limb) { return fmt::format("sum.{}.{}", channel, limb); }
std::string layer_name(std::string_view channel) { return fmt::format("layer.{}", channel); }

// In the list of exact layers: "depth:float,ids.instance:uint".
constexpr std::string_view kWholeSuffix = ":uint", kFloatSuffix = ":float";

// Removes the reserved attribute and returns it.
std::string take(Attributes& attributes, std::string_view key, std::string_view where) {
    const auto found = attributes.find(std::string(key));
    if (found == attributes.end())
        refuse_image(where, fmt::format("is no film: it lacks the attribute {}", key), "only files written with --spp-range can be merged");
    std::string value = std::move(found->second);
    attributes.erase(found);
    return value;
}

uint64_t take_number(Attributes& attributes, std::string_view key, std::string_view where) {
    const std::string text = take(attributes, key, where);
    uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || value > 0xFFFFFFFFu)
        refuse_image(where, fmt::format("is a damaged film: {} is '{}'", key, escape_name(text)));
    return value;
}

std::vector<std::string> split_names(std::string_view text) {
    std::vector<std::string> out;
    while (true) {
        const size_t comma = text.find(',');
        out.emplace_back(text.substr(0, comma));
        if (comma == std::string_view::npos) return out;
        text.remove_prefix(comma + 1);
    }
}

std::span<const uint32_t> plane_of(const UintImage& image, const std::string& name, std::string_view where) {
    const auto found = std::find(image.channels.begin(), image.channels.end(), name);
    if (found == image.channels.end()) refuse_image(where, fmt::format("is a damaged film: it lacks the channel {}", escape_name(name)));
    const size_t pixels = size_t{image.width} * image.height;
    return std::span(image.data).subspan(static_cast<size_t>(found - image.channels.begin()) * pixels, pixels);
}

void copy_limbs(const UintImage& image, FilmSums& film, std::string_view where) {
    const size_t pixels = film.pixel_count();
    for (size_t c = 0; c < film.channels.size(); ++c)
        for (size_t limb = 0; limb < 3; ++limb) {
            const std::span<const uint32_t> source = plane_of(image, limb_name(film.channels[c], limb), where);
            std::copy_n(source.begin(), pixels, film.limbs.begin() + static_cast<std::ptrdiff_t>((3 * c + limb) * pixels));
        }
}

// Removes the list of exact layers, which films without any lack.
std::vector<ExactLayer> take_layers(Attributes& attributes, std::string_view where) {
    std::vector<ExactLayer> layers;
    if (!attributes.contains(std::string(kLayersKey))) return layers;
    for (const std::string& entry : split_names(take(attributes, kLayersKey, where))) {
        const bool whole = entry.ends_with(kWholeSuffix);
        if (!whole && !entry.ends_with(kFloatSuffix)) refuse_image(where, fmt::format("is a damaged film: its layers are '{}'", escape_name(entry)));
        layers.push_back({.channel = entry.substr(0, entry.rfind(':')), .whole = whole});
    }
    return layers;
}

}  // namespace

std::vector<std::byte> encode_film_exr(const FilmSums& film) {
    PARHELION_CHECK(film.limbs.size() == 3 * film.channels.size() * film.pixel_count(), "a film of {}x{} with {} channels and {} limbs", film.width,
                    film.height, film.channels.size(), film.limbs.size());
    UintImage image{.width = film.width, .height = film.height, .data = film.limbs, .attributes = film.attributes};
    std::string names;
    for (const std::string& channel : film.channels) {
        PARHELION_CHECK(!channel.empty() && channel.find(',') == std::string::npos, "a film channel named '{}'", channel);
        for (size_t limb = 0; limb < 3; ++limb) image.channels.push_back(limb_name(channel, limb));
        names += (names.empty() ? "" : ",") + channel;
    }
    std::string layers;
    for (const ExactLayer& layer : film.exact) {
        PARHELION_CHECK(layer.words.size() == film.pixel_count(), "a layer of {} values for {} pixels", layer.words.size(), film.pixel_count());
        image.channels.push_back(layer_name(layer.channel));
        image.data.insert(image.data.end(), layer.words.begin(), layer.words.end());
        layers += fmt::format("{}{}{}", layers.empty() ? "" : ",", layer.channel, layer.whole ? kWholeSuffix : kFloatSuffix);
    }
    const auto set = [&](std::string_view key, std::string value) {
        PARHELION_CHECK(image.attributes.emplace(key, std::move(value)).second, "the attribute {} is the film's own", key);
    };
    set(kVersionKey, std::string(kVersion));
    set(kBeginKey, std::to_string(film.sample_begin));
    set(kEndKey, std::to_string(film.sample_end));
    set(kChannelsKey, names);
    if (!layers.empty()) set(kLayersKey, layers);
    return encode_uint_exr(image);
}

void write_film_exr(const std::filesystem::path& path, const FilmSums& film) { write_file(path, encode_film_exr(film)); }

FilmSums decode_film_exr(std::span<const std::byte> bytes, const DecodeLimits& limits, std::string_view where) {
    if (detect_format(bytes) != Format::Exr) refuse_image(where, "is no film: it is not an EXR", "only files written with --spp-range can be merged");
    // A finished picture is the likely mistake: say so before complaining about its channel types.
    UintImage image;
    try {
        image = decode_uint_exr(bytes, limits, where);
    } catch (const Error& error) {
        if (error.problem.find("not of type UINT") == std::string::npos) throw;
        refuse_image(where, "is no film: it holds a finished picture", "only files written with --spp-range can be merged");
    }
    FilmSums film{.width = image.width, .height = image.height, .attributes = std::move(image.attributes)};
    const std::string version = take(film.attributes, kVersionKey, where);
    if (version != kVersion) refuse_image(where, fmt::format("is a film of version {}; this program reads version {}", escape_name(version), kVersion));
    film.sample_begin = take_number(film.attributes, kBeginKey, where);
    film.sample_end = take_number(film.attributes, kEndKey, where);
    if (film.sample_begin >= film.sample_end) refuse_image(where, "is a damaged film: its sample range is empty");
    film.channels = split_names(take(film.attributes, kChannelsKey, where));
    film.exact = take_layers(film.attributes, where);
    const size_t limb_planes = 3 * film.channels.size();
    if (limb_planes + film.exact.size() != image.channels.size())
        refuse_image(where, fmt::format("is a damaged film: {} channels of sums and layers for {} names", image.channels.size(), film.channels.size() + film.exact.size()));
    film.limbs.resize(limb_planes * film.pixel_count());
    copy_limbs(image, film, where);
    for (ExactLayer& layer : film.exact) {
        const std::span<const uint32_t> words = plane_of(image, layer_name(layer.channel), where);
        layer.words.assign(words.begin(), words.end());
    }
    return film;
}

FilmSums read_film_exr(const std::filesystem::path& path, const DecodeLimits& limits) {
    return decode_film_exr(read_file(path, kMaxFileBytes), limits, path.string());
}

}  // namespace parhelion::image
