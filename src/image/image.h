#pragma once
// Images in memory.
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace parhelion::image {

// Text that travels with an image, in the EXR header or in text chunks of the PNG: exposure, settings hash, ...
using Attributes = std::map<std::string, std::string>;

// Eight-bit RGBA, rows from the top. The file's own colour space and gamma are not applied.
struct Texture8 {
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> rgba = {};  // 4 * width * height
    Attributes attributes = {};      // of a PNG: its tEXt chunks that stand before the pixels
};

// Eight-bit RGB for display (sRGB), rows from the top.
struct Picture8 {
    uint32_t width = 0, height = 0;
    std::vector<uint8_t> rgb = {};  // 3 * width * height
    Attributes attributes = {};     // names of 1 to 79 letters of ASCII
};

// A layer that is kept and written as it is, whatever the precision of the colours: 32-bit words, floats or whole numbers.
struct ExactLayer {
    std::string channel;      // "depth", "ids.instance"
    bool whole = false;       // the words are whole numbers, else the bits of floats
    std::vector<uint32_t> words = {};  // [y * width + x]

    friend bool operator==(const ExactLayer&, const ExactLayer&) = default;
    bool same_kind(const ExactLayer& other) const { return channel == other.channel && whole == other.whole; }
};

// Float channels as planes, one after the other; each plane row by row from the top. Names follow EXR: "R", "G", "B" of the
// beauty, "albedo.R", "depth" and so on of layers.
struct ImageF {
    uint32_t width = 0, height = 0;
    std::vector<std::string> channels = {};
    std::vector<float> data = {};  // [channel * pixel_count + y * width + x]
    Attributes attributes = {};
    std::vector<ExactLayer> exact = {};  // beside `channels`
    bool display_referred = false;  // from an eight-bit sRGB file: 1.0 is the display's white, not a radiance

    size_t pixel_count() const { return static_cast<size_t>(width) * height; }
    std::optional<size_t> find_channel(std::string_view name) const;
    std::span<const float> plane(size_t channel) const { return std::span(data).subspan(channel * pixel_count(), pixel_count()); }
    std::span<float> plane(size_t channel) { return std::span(data).subspan(channel * pixel_count(), pixel_count()); }
    // Appends a plane of zeros and returns it; spans taken before become invalid.
    std::span<float> add_channel(std::string name);
};

// A zero image with these channels.
ImageF make_image(uint32_t width, uint32_t height, std::vector<std::string> channels);

struct RgbPlanes {
    std::span<const float> r, g, b;
};
// The colour of a layer ("" is the beauty: R, G, B; "albedo": albedo.R, ...). A lone Y stands for all three. Throws Error if the
// image has no such channels; `where` names the image.
RgbPlanes rgb_planes(const ImageF& image, std::string_view layer = {}, std::string_view where = {});

// Luminance of linear Rec.709 (ITU-R BT.709-6, 3.2).
template <class T>
constexpr T luminance(T r, T g, T b) {
    return T(0.2126) * r + T(0.7152) * g + T(0.0722) * b;
}

// The sRGB transfer (IEC 61966-2-1): display value in [0,1] from linear light, and back. Values outside are not clamped.
float srgb_from_linear(float linear);
float linear_from_srgb(float encoded);

// Linear Rec.709 "R", "G", "B" (and "A" where `with_alpha`) of an sRGB picture.
ImageF linear_image(const Texture8& texture, bool with_alpha = false);

}  // namespace parhelion::image
