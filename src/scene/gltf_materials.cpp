#include "scene/gltf_materials.h"

#include <functional>
#include <utility>

#include "scene/gltf_images.h"

namespace parhelion {

namespace {

// Gives the texture for a glTF texture number; the first pass over the materials only collects what is wanted.
using TextureLookup = std::function<Handle<Texture>(const JsonRef& index, ColorSpace space)>;

struct TextureInfo {
    JsonRef json;
    uint32_t uv_set;
    std::optional<JsonRef> transform;
};

// A textureInfo that can be drawn, with the UV set that KHR_texture_transform may override.
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

TextureRef read_texture_ref(GltfDocument& document, const JsonRef& owner, std::string_view key, ColorSpace space,
                            const TextureLookup& lookup) {
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

// A number that glTF bounds: outside values are pulled in, with a warning.
float bounded(GltfDocument& document, const JsonRef& owner, std::string_view key, float fallback, float min, float max) {
    const float value = owner.number(key, fallback);
    if (value >= min && value <= max) return value;
    document.warn(owner, fmt::format("{} {} is outside {} to {} and was clamped", key, value, min, max));
    return glm::clamp(value, min, max);
}

template <glm::length_t N>
glm::vec<N, float> bounded_vec(GltfDocument& document, const JsonRef& owner, std::string_view key, glm::vec<N, float> fallback, float max) {
    const glm::vec<N, float> value = owner.vec<N>(key, fallback), inside = glm::clamp(value, 0.0f, max);
    if (value != inside) document.warn(owner, fmt::format("{} has a value outside 0 to {}, which was clamped", key, max));
    return inside;
}

AlphaMode read_alpha_mode(GltfDocument& document, const JsonRef& json) {
    const std::string mode = json.string("alphaMode", "OPAQUE");
    if (mode == "MASK") return AlphaMode::Mask;
    if (mode == "BLEND") return AlphaMode::Blend;
    if (mode != "OPAQUE") document.warn(json, fmt::format("alphaMode '{}' is unknown and taken as OPAQUE", escape_name(mode, 20)));
    return AlphaMode::Opaque;
}

void read_extensions(GltfDocument& document, const JsonRef& json, Material& material) {
    constexpr float kMost = 3.4e38f;
    if (const auto strength = json.extension("KHR_materials_emissive_strength"))
        material.emission *= bounded(document, *strength, "emissiveStrength", 1.0f, 0.0f, 1e30f);
    material.unlit = json.extension("KHR_materials_unlit").has_value();
    if (const auto ior = json.extension("KHR_materials_ior")) {
        material.ior = ior->number("ior", 1.5f);
        // 0 is allowed and means a surface that reflects everything.
        if (material.ior != 0.0f) material.ior = bounded(document, *ior, "ior", 1.5f, 1.0f, kMost);
    }
    if (const auto specular = json.extension("KHR_materials_specular")) {
        material.specular = bounded(document, *specular, "specularFactor", 1.0f, 0.0f, 1.0f);
        if (specular->find("specularTexture") || specular->find("specularColorTexture") || specular->find("specularColorFactor"))
            document.warn(*specular, "colours and textures of KHR_materials_specular are not drawn");
    }
    if (const auto transmission = json.extension("KHR_materials_transmission"))
        material.transmission = bounded(document, *transmission, "transmissionFactor", 0.0f, 0.0f, 1.0f);
}

Material read_material(GltfDocument& document, const JsonRef& json, const TextureLookup& lookup) {
    Material material;
    material.name = json.string("name");
    if (const std::optional<JsonRef> pbr = json.find("pbrMetallicRoughness")) {
        material.base_color = bounded_vec<4>(document, *pbr, "baseColorFactor", glm::vec4(1.0f), 1.0f);
        material.base_color_texture = read_texture_ref(document, *pbr, "baseColorTexture", ColorSpace::Srgb, lookup);
        material.metallic = bounded(document, *pbr, "metallicFactor", 1.0f, 0.0f, 1.0f);
        material.roughness = bounded(document, *pbr, "roughnessFactor", 1.0f, 0.0f, 1.0f);
        material.metal_rough_texture = read_texture_ref(document, *pbr, "metallicRoughnessTexture", ColorSpace::Linear, lookup);
    }
    material.normal_texture = read_texture_ref(document, json, "normalTexture", ColorSpace::Linear, lookup);
    if (const std::optional<JsonRef> normal = json.find("normalTexture")) material.normal_scale = normal->number("scale", 1.0f);
    material.emission = bounded_vec<3>(document, json, "emissiveFactor", glm::vec3(0.0f), 1e30f);
    material.emissive_texture = read_texture_ref(document, json, "emissiveTexture", ColorSpace::Srgb, lookup);
    material.alpha_mode = read_alpha_mode(document, json);
    material.alpha_cutoff = bounded(document, json, "alphaCutoff", 0.5f, 0.0f, 3.4e38f);
    material.double_sided = json.boolean("doubleSided", false);
    read_extensions(document, json, material);
    return material;
}

Wrap read_wrap(GltfDocument& document, const JsonRef& json, std::string_view key) {
    switch (const uint64_t value = json.uint(key, 10497, 0xFFFF)) {
        case 33071:
            return Wrap::ClampToEdge;
        case 33648:
            return Wrap::MirroredRepeat;
        case 10497:
            return Wrap::Repeat;
        default:
            document.warn(json, fmt::format("{} {} is unknown and taken as REPEAT", key, value));
            return Wrap::Repeat;
    }
}

Sampler read_sampler(GltfDocument& document, const JsonRef& json) {
    Sampler sampler;
    sampler.wrap_u = read_wrap(document, json, "wrapS");
    sampler.wrap_v = read_wrap(document, json, "wrapT");
    const uint64_t mag = json.uint("magFilter", 9729, 0xFFFF);
    if (mag == 9728)
        sampler.mag = Filter::Nearest;
    else if (mag != 9729)
        document.warn(json, fmt::format("magFilter {} is unknown and taken as LINEAR", mag));
    switch (const uint64_t min = json.uint("minFilter", 9987, 0xFFFF)) {
        case 9728:
            sampler.min = Filter::Nearest, sampler.mip.reset();
            break;
        case 9729:
            sampler.min = Filter::Linear, sampler.mip.reset();
            break;
        case 9984:
            sampler.min = Filter::Nearest, sampler.mip = Filter::Nearest;
            break;
        case 9985:
            sampler.min = Filter::Linear, sampler.mip = Filter::Nearest;
            break;
        case 9986:
            sampler.min = Filter::Nearest, sampler.mip = Filter::Linear;
            break;
        case 9987:
            break;
        default:
            document.warn(json, fmt::format("minFilter {} is unknown and taken as LINEAR_MIPMAP_LINEAR", min));
    }
    return sampler;
}

using TextureKey = std::pair<uint32_t, ColorSpace>;

std::map<TextureKey, Handle<Texture>> add_textures(GltfDocument& document, SceneEdit& edit, const std::set<TextureKey>& wanted, bool keep_encoded) {
    std::map<uint32_t, std::optional<uint32_t>> image_of;  // by texture
    std::set<uint32_t> image_numbers;
    for (const auto& [index, space] : wanted) {
        const auto [entry, first] = image_of.try_emplace(index);
        if (!first) continue;
        entry->second = image_of_texture(document, document.root().at("textures")[index]);
        if (entry->second) image_numbers.insert(*entry->second);
    }
    const std::map<uint32_t, Handle<Image>> images = add_images(document, edit, image_numbers, keep_encoded);
    std::map<TextureKey, Handle<Texture>> out;
    for (const TextureKey& key : wanted) {
        const std::optional<uint32_t> image = image_of.at(key.first);
        if (!image) continue;
        const JsonRef json = document.root().at("textures")[key.first];
        Texture texture{.name = json.string("name"), .image = images.at(*image), .color_space = key.second};
        if (const std::optional<JsonRef> sampler = json.find("sampler"))
            texture.sampler = read_sampler(document, document.entry("samplers", *sampler));
        out[key] = edit.add(std::move(texture));
    }
    return out;
}

}  // namespace

MaterialHandles add_materials(GltfDocument& document, SceneEdit& edit, const std::set<uint32_t>& materials, bool needs_default,
                             bool keep_encoded) {
    std::set<TextureKey> wanted;
    const TextureLookup collect = [&](const JsonRef& index, ColorSpace space) {
        wanted.emplace(index.as_index_of("textures"), space);
        return Handle<Texture>{};
    };
    for (const uint32_t index : materials) read_material(document, document.root().at("materials")[index], collect);
    const std::map<TextureKey, Handle<Texture>> textures = add_textures(document, edit, wanted, keep_encoded);

    const TextureLookup find = [&](const JsonRef& index, ColorSpace space) {
        const auto found = textures.find({index.as_index_of("textures"), space});
        return found == textures.end() ? Handle<Texture>{} : found->second;
    };
    MaterialHandles out;
    for (const uint32_t index : materials) out[index] = edit.add(read_material(document, document.root().at("materials")[index], find));
    if (needs_default) out[std::nullopt] = edit.add(Material{.name = "default"});
    return out;
}

bool has_normal_map(const GltfDocument& document, std::optional<uint32_t> material, uint32_t& uv_set) {
    if (!material) return false;
    const std::optional<TextureInfo> info = find_texture_info(document.root().at("materials")[*material], "normalTexture", nullptr);
    if (info) uv_set = info->uv_set;
    return info.has_value();
}

}  // namespace parhelion
