#pragma once
// Reading the fields of a glTF material: numbers within their ranges, textures as the material uses them.
#include <functional>
#include <limits>
#include <optional>
#include <string_view>

#include "scene/gltf/document.h"
#include "scene/handle.h"
#include "scene/types.h"

namespace parhelion {

// Gives the texture for a glTF texture number; the first pass over the materials only collects what is wanted.
using TextureLookup = std::function<Handle<Texture>(const JsonRef& index, ColorSpace space)>;

struct TextureInfo {
    JsonRef json;
    uint32_t uv_set;
    std::optional<JsonRef> transform;
};

// A textureInfo that can be drawn, with the UV set that KHR_texture_transform may override; others are left out, with a warning.
std::optional<TextureInfo> find_texture_info(const JsonRef& owner, std::string_view key, GltfDocument* warn_to);

// Values outside the range that glTF gives are pulled in, with a warning.
struct MaterialFields {
    static constexpr float kMost = std::numeric_limits<float>::max();  // no upper bound

    GltfDocument& document;
    const TextureLookup& lookup;

    TextureRef texture(const JsonRef& owner, std::string_view key, ColorSpace space) const;
    float number(const JsonRef& owner, std::string_view key, float fallback, float min, float max) const;
    template <glm::length_t N>
    glm::vec<N, float> color(const JsonRef& owner, std::string_view key, float fallback, float max) const {
        const glm::vec<N, float> value = owner.vec<N>(key, glm::vec<N, float>(fallback)), inside = glm::clamp(value, 0.0f, max);
        if (value != inside) warn_color(owner, key, max);
        return inside;
    }

private:
    void warn_color(const JsonRef& owner, std::string_view key, float max) const;
};

}  // namespace parhelion
