#include "scene/gltf/meshopt.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include <meshoptimizer.h>

#include "base/error.h"

namespace parhelion {

namespace {

enum class Coding { Attributes, Triangles, Indices };
enum class Filter { None, Octahedral, Quaternion, Exponential, Color };

template <class E, size_t N>
E one_of(const JsonRef& json, const std::array<std::string_view, N>& names) {
    const auto found = std::find(names.begin(), names.end(), json.as_string());
    if (found == names.end()) json.fail(fmt::format("'{}' is not known", escape_name(json.as_string(), 20)));
    return static_cast<E>(found - names.begin());
}

struct Layout {
    Coding mode;
    Filter filter = Filter::None;
    uint64_t count, stride;
};

// The rules of the extension ("For the extension object to be valid, ..."): the library takes them for granted.
Layout read_layout(const JsonRef& view, const JsonRef& json) {
    constexpr std::array<std::string_view, 3> kModes = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
    constexpr std::array<std::string_view, 5> kFilters = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"};
    Layout out{.mode = one_of<Coding>(json.at("mode"), kModes),
               .count = json.at("count").as_uint(std::numeric_limits<uint32_t>::max()),
               .stride = json.at("byteStride").as_uint(256)};
    if (const std::optional<JsonRef> filter = json.find("filter")) out.filter = one_of<Filter>(*filter, kFilters);
    const auto require = [&](bool good, std::string_view rule) {
        if (!good)
            json.fail(fmt::format("its byteStride of {} and count of {} do not fit its mode and filter", out.stride, out.count),
                      std::string(rule));
    };
    const uint64_t s = out.stride;
    if (out.mode == Coding::Attributes) {
        require(s >= 4 && s % 4 == 0, "byteStride is 4, 8, ... 256 for ATTRIBUTES");
        require((out.filter != Filter::Octahedral && out.filter != Filter::Color) || s == 4 || s == 8,
                "byteStride is 4 or 8 for this filter");
        require(out.filter != Filter::Quaternion || s == 8, "byteStride is 8 for QUATERNION");
    } else {
        require(s == 2 || s == 4, "byteStride is 2 or 4 for indices");
        require(out.mode != Coding::Triangles || out.count % 3 == 0, "count is a multiple of 3 for TRIANGLES");
        if (out.filter != Filter::None) json.fail("has a filter, which only ATTRIBUTES can have");
    }
    if (const uint64_t length = view.at("byteLength").as_uint(1ull << 53); length != out.count * s)
        json.fail(fmt::format("unfolds to {} x {} bytes, but the buffer view has {}", out.count, s, length));
    return out;
}

// KHR_meshopt_compression, filter 4: Y, Co, Cg and alpha of K bits, K being told by the highest bit of the alpha.
template <class T>
void decode_color_filter(std::vector<std::byte>& bytes) {
    using Signed = std::make_signed_t<T>;
    constexpr float kMax = static_cast<float>(std::numeric_limits<T>::max());
    for (size_t at = 0; at + 4 * sizeof(T) <= bytes.size(); at += 4 * sizeof(T)) {
        T in[4];
        std::memcpy(in, bytes.data() + at, sizeof(in));
        const int all_bits = (1 << std::bit_width(in[3])) - 1;
        const int y = in[0], co = static_cast<Signed>(in[1]), cg = static_cast<Signed>(in[2]), a = in[3] & (all_bits >> 1);
        const float scale = all_bits == 0 ? 0.0f : kMax / static_cast<float>(all_bits);
        const int color[4] = {y + co - cg, y + cg, y - co - cg, a << 1 | (a & 1)};
        for (int c = 0; c < 4; ++c) in[c] = static_cast<T>(std::clamp(std::round(static_cast<float>(color[c]) * scale), 0.0f, kMax));
        std::memcpy(bytes.data() + at, in, sizeof(in));
    }
}

void apply_filter(const Layout& layout, std::vector<std::byte>& bytes) {
    switch (layout.filter) {
        case Filter::None:
            break;
        case Filter::Octahedral:
            meshopt_decodeFilterOct(bytes.data(), layout.count, layout.stride);
            break;
        case Filter::Quaternion:
            meshopt_decodeFilterQuat(bytes.data(), layout.count, layout.stride);
            break;
        case Filter::Exponential:
            meshopt_decodeFilterExp(bytes.data(), layout.count, layout.stride);
            break;
        case Filter::Color:
            if (layout.stride == 4)
                decode_color_filter<uint8_t>(bytes);
            else
                decode_color_filter<uint16_t>(bytes);
            break;
    }
}

// Every stream starts with its codec (high four bits) and version (low four).
[[noreturn]] void fail_to_decode(const JsonRef& json, Coding mode, std::span<const std::byte> bytes) {
    constexpr unsigned kCodecs[] = {0xA, 0xE, 0xD}, kVersionsKnown[] = {0, 1, 1};
    const unsigned first = bytes.empty() ? 0u : std::to_integer<unsigned>(bytes[0]);
    const unsigned version = first & 15u;
    if (first >> 4 == kCodecs[static_cast<size_t>(mode)] && version > kVersionsKnown[static_cast<size_t>(mode)])
        json.fail(fmt::format("is compressed with version {} of its codec, which meshoptimizer {}.{} cannot read", version,
                              MESHOPTIMIZER_VERSION / 1000, MESHOPTIMIZER_VERSION / 10 % 100),
                  "compress the scene with EXT_meshopt_compression, which has version 0");
    json.fail("its compressed data are damaged", "the file is damaged: export it again");
}

}  // namespace

std::optional<JsonRef> meshopt_compression_of(const JsonRef& view) {
    const std::optional<JsonRef> khr = view.extension("KHR_meshopt_compression");
    return khr ? khr : view.extension("EXT_meshopt_compression");
}

std::vector<std::byte> decode_meshopt(SceneFiles& files, const JsonRef& view, const JsonRef& compression,
                                      std::span<const std::byte> bytes) {
    const Layout layout = read_layout(view, compression);
    files.charge(layout.count * layout.stride, compression.where());
    std::vector<std::byte> out(layout.count * layout.stride);
    const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
    int result = 0;
    switch (layout.mode) {
        case Coding::Attributes:
            result = meshopt_decodeVertexBuffer(out.data(), layout.count, layout.stride, data, bytes.size());
            break;
        case Coding::Triangles:
            result = meshopt_decodeIndexBuffer(out.data(), layout.count, layout.stride, data, bytes.size());
            break;
        case Coding::Indices:
            result = meshopt_decodeIndexSequence(out.data(), layout.count, layout.stride, data, bytes.size());
            break;
    }
    if (result != 0) fail_to_decode(compression, layout.mode, bytes);
    apply_filter(layout, out);
    return out;
}

}  // namespace parhelion
