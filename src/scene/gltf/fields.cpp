#include "scene/gltf/fields.h"

namespace parhelion {

namespace {

std::string range_text(float min, float max) {
    return max == MaterialFields::kMost ? fmt::format("below {}", min) : fmt::format("outside {} to {}", min, max);
}

}  // namespace

std::optional<TextureInfo> find_texture_info(const JsonRef& owner, std::string_view key, GltfDocument* warn_to) {
    const std::optional<JsonRef> json = owner.find(key);
    if (!json) return std::nullopt;
    TextureInfo info{*json, 0, json->extension("KHR_texture_transform")};
    uint64_t uv_set = json->uint("texCoord", 0, 0xFFFF);
    if (info.transform) uv_set = info.transform->uint("texCoord", uv_set, 0xFFFF);
    if (uv_set > 1) {
        if (warn_to != nullptr)
            warn_to->warn(*json, fmt::format("uses TEXCOORD_{}; only sets 0 and 1 are drawn, the texture is left out", uv_set));
        return std::nullopt;
    }
    info.uv_set = static_cast<uint32_t>(uv_set);
    return info;
}

TextureRef MaterialFields::texture(const JsonRef& owner, std::string_view key, ColorSpace space) const {
    TextureRef ref;
    const std::optional<TextureInfo> info = find_texture_info(owner, key, &document);
    if (!info) return ref;
    ref.texture = lookup(info->json.at("index"), space);
    ref.uv_set = info->uv_set;
    if (info->transform) {
        ref.offset = info->transform->vec<2>("offset", glm::vec2(0.0f));
        ref.scale = info->transform->vec<2>("scale", glm::vec2(1.0f));
        ref.rotation = info->transform->number("rotation", 0.0f);
    }
    return ref;
}

float MaterialFields::number(const JsonRef& owner, std::string_view key, float fallback, float min, float max) const {
    const float value = owner.number(key, fallback);
    if (value >= min && value <= max) return value;
    document.warn(owner, fmt::format("{} {} is {} and was clamped", key, value, range_text(min, max)));
    return glm::clamp(value, min, max);
}

void MaterialFields::warn_color(const JsonRef& owner, std::string_view key, float max) const {
    document.warn(owner, fmt::format("{} has a value {}, which was clamped", key, range_text(0.0f, max)));
}

}  // namespace parhelion
