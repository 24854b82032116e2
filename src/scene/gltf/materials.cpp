#include "scene/gltf/materials.h"

#include <cmath>
#include <utility>

#include "scene/gltf/images.h"
#include "scene/gltf/material_extensions.h"

namespace parhelion {

namespace {

AlphaMode read_alpha_mode(GltfDocument& document, const JsonRef& json) {
    const std::string mode = json.string("alphaMode", "OPAQUE");
    if (mode == "MASK") return AlphaMode::Mask;
    if (mode == "BLEND") return AlphaMode::Blend;
    if (mode != "OPAQUE") document.warn(json, fmt::format("alphaMode '{}' is unknown and taken as OPAQUE", escape_name(mode, 20)));
    return AlphaMode::Opaque;
}

// What gltf_write keeps there; of other writers' extras nothing is known, so that what does not fit is passed over.
int read_nested_priority(const JsonRef& material) {
    const std::optional<JsonRef> extras = material.find("extras");
    const std::optional<JsonRef> priority = extras && extras->is_object() ? extras->find(kNestedPriorityKey) : std::nullopt;
    if (!priority || !priority->is_number()) return 0;
    const double value = priority->as_number();
    return std::abs(value) <= kMostNestedPriority && value == std::floor(value) ? static_cast<int>(value) : 0;
}

Material read_material(const MaterialFields& fields, const JsonRef& json) {
    Material material;
    material.name = json.string("name");
    // With specular-glossiness it is a fallback for who does not read that.
    const bool is_fallback = json.extension("KHR_materials_pbrSpecularGlossiness").has_value();
    if (const std::optional<JsonRef> pbr = json.find("pbrMetallicRoughness"); pbr && !is_fallback) {
        material.base_color = fields.color<4>(*pbr, "baseColorFactor", 1.0f, 1.0f);
        material.base_color_texture = fields.texture(*pbr, "baseColorTexture", ColorSpace::Srgb);
        material.metallic = fields.number(*pbr, "metallicFactor", 1.0f, 0.0f, 1.0f);
        material.roughness = fields.number(*pbr, "roughnessFactor", 1.0f, 0.0f, 1.0f);
        material.metal_rough_texture = fields.texture(*pbr, "metallicRoughnessTexture", ColorSpace::Linear);
    }
    material.normal_texture = fields.texture(json, "normalTexture", ColorSpace::Linear);
    if (const std::optional<JsonRef> normal = json.find("normalTexture")) material.normal_scale = normal->number("scale", 1.0f);
    material.occlusion_texture = fields.texture(json, "occlusionTexture", ColorSpace::Linear);
    if (const std::optional<JsonRef> occlusion = json.find("occlusionTexture"))
        material.occlusion_strength = fields.number(*occlusion, "strength", 1.0f, 0.0f, 1.0f);
    material.emission = fields.color<3>(json, "emissiveFactor", 0.0f, 1e30f);
    material.emissive_texture = fields.texture(json, "emissiveTexture", ColorSpace::Srgb);
    material.alpha_mode = read_alpha_mode(fields.document, json);
    material.alpha_cutoff = fields.number(json, "alphaCutoff", 0.5f, 0.0f, MaterialFields::kMost);
    material.double_sided = json.boolean("doubleSided", false);
    material.nested_priority = read_nested_priority(json);
    read_material_extensions(fields, json, material);
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
    for (const uint32_t index : materials) read_material({document, collect}, document.root().at("materials")[index]);
    const std::map<TextureKey, Handle<Texture>> textures = add_textures(document, edit, wanted, keep_encoded);

    const TextureLookup find = [&](const JsonRef& index, ColorSpace space) {
        const auto found = textures.find({index.as_index_of("textures"), space});
        return found == textures.end() ? Handle<Texture>{} : found->second;
    };
    MaterialHandles out;
    for (const uint32_t index : materials) out[index] = edit.add(read_material({document, find}, document.root().at("materials")[index]));
    if (needs_default) out[std::nullopt] = edit.add(Material{.name = "default"});
    return out;
}

bool has_normal_map(const GltfDocument& document, std::optional<uint32_t> material, uint32_t& uv_set) {
    if (!material) return false;
    const JsonRef json = document.root().at("materials")[*material];
    std::optional<TextureInfo> info = find_texture_info(json, "normalTexture", nullptr);
    if (const std::optional<JsonRef> coat = json.extension("KHR_materials_clearcoat"); coat && !info) info = find_texture_info(*coat, "clearcoatNormalTexture", nullptr);
    if (info) uv_set = info->uv_set;
    return info.has_value();
}

}  // namespace parhelion
