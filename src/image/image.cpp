#include "image/image.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"

namespace parhelion::image {

std::optional<size_t> ImageF::find_channel(std::string_view name) const {
    const auto found = std::find(channels.begin(), channels.end(), name);
    if (found == channels.end()) return std::nullopt;
    return static_cast<size_t>(found - channels.begin());
}

std::span<float> ImageF::add_channel(std::string name) {
    channels.push_back(std::move(name));
    data.resize(channels.size() * pixel_count());
    return plane(channels.size() - 1);
}

ImageF make_image(uint32_t width, uint32_t height, std::vector<std::string> channels) {
    ImageF image{.width = width, .height = height, .channels = std::move(channels)};
    image.data.resize(image.channels.size() * image.pixel_count());
    return image;
}

RgbPlanes rgb_planes(const ImageF& image, std::string_view layer, std::string_view where) {
    const std::string prefix = layer.empty() ? "" : std::string(layer) + ".";
    const auto r = image.find_channel(prefix + "R"), g = image.find_channel(prefix + "G"), b = image.find_channel(prefix + "B");
    if (r && g && b) return {image.plane(*r), image.plane(*g), image.plane(*b)};
    if (const auto y = image.find_channel(prefix + "Y")) return {image.plane(*y), image.plane(*y), image.plane(*y)};
    throw Error(ErrorCode::Failed, fmt::format("has no channels {0}R, {0}G, {0}B", escape_name(prefix)), std::string(where));
}

float srgb_from_linear(float linear) { return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f; }

float linear_from_srgb(float encoded) { return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f); }

ImageF linear_image(const Texture8& texture, bool with_alpha) {
    std::array<float, 256> linear{};
    for (size_t i = 0; i < linear.size(); ++i) linear[i] = linear_from_srgb(static_cast<float>(i) / 255.0f);
    ImageF image = make_image(texture.width, texture.height, {"R", "G", "B"});
    if (with_alpha) image.add_channel("A");
    image.display_referred = true;
    const size_t pixels = image.pixel_count();
    for (size_t c = 0; c < image.channels.size(); ++c)
        for (size_t p = 0; p < pixels; ++p) {
            const uint8_t value = texture.rgba[4 * p + c];
            image.data[c * pixels + p] = c < 3 ? linear[value] : static_cast<float>(value) / 255.0f;
        }
    return image;
}

}  // namespace parhelion::image
