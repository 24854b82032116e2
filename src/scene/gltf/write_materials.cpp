// Materials (3.9) and the extensions KHR_materials_* (each by its own specification in the Khronos glTF registry): what differs from
// its default.
#include <cmath>

#include "scene/gltf/materials.h"
#include "scene/gltf/write_parts.h"

namespace parhelion::gltf {

namespace {

const Material kDefault;

bool is_default(const TextureRef& ref) { return ref.offset == glm::vec2(0.0f) && ref.scale == glm::vec2(1.0f) && ref.rotation == 0.0f; }

// An object of a material: keys only for what differs from its default.
class Fields {
public:
    explicit Fields(Writer& writer) : writer_(writer) {}

    Fields& factor(const char* key, float value, float fallback) {
        if (value != fallback) json_[key] = number(value);
        return *this;
    }
    template <glm::length_t N>
    Fields& color(const char* key, const glm::vec<N, float, glm::defaultp>& value, const glm::vec<N, float, glm::defaultp>& fallback) {
        if (value != fallback) json_[key] = numbers(value);
        return *this;
    }
    Fields& texture(const char* key, const TextureRef& ref, ColorSpace space) {
        if (!ref.texture) return *this;
        const Texture& texture = writer_.scene.get(ref.texture);
        if (texture.color_space != space)
            writer_.warn(fmt::format("texture '{}' is used as {} by a material, but holds {}; readers go by the use", escape_name(texture.name),
                                     space == ColorSpace::Srgb ? "colour" : "data", space == ColorSpace::Srgb ? "data" : "colour"));
        Json info{{"index", writer_.textures.of(ref.texture)}};
        if (ref.uv_set != 0) info["texCoord"] = ref.uv_set;
        if (!is_default(ref)) {
            Fields transform(writer_);
            transform.color("offset", ref.offset, glm::vec2(0.0f)).factor("rotation", ref.rotation, 0.0f).color("scale", ref.scale, glm::vec2(1.0f));
            writer_.extend(info, "KHR_texture_transform", std::move(transform.json_));
        }
        json_[key] = std::move(info);
        return *this;
    }
    // A texture that brings a factor along.
    Fields& texture(const char* key, const TextureRef& ref, const char* factor_key, float value, float fallback) {
        texture(key, ref, ColorSpace::Linear);
        if (ref.texture && value != fallback) json_[key][factor_key] = number(value);
        return *this;
    }
    void attach_to(Json& material, const char* extension) {
        if (!json_.empty()) writer_.extend(material, extension, std::move(json_));
    }
    Json& json() { return json_; }

private:
    Writer& writer_;
    Json json_ = Json::object();
};

constexpr ColorSpace kSrgb = ColorSpace::Srgb, kLinear = ColorSpace::Linear;

// emissiveFactor ends at 1 (5.19). A power of two as the strength changes no bit of what the reader multiplies.
void write_emission(Writer& writer, const Material& m, Fields& out) {
    const float most = std::max(m.emission.x, std::max(m.emission.y, m.emission.z));
    if (!(most > 1.0f)) {
        out.color("emissiveFactor", m.emission, kDefault.emission);
        return;
    }
    int exponent = 0;
    if (std::frexp(most, &exponent) == 0.5f) --exponent;
    const float strength = std::ldexp(1.0f, exponent);
    out.color("emissiveFactor", m.emission / strength, kDefault.emission);
    Fields(writer).factor("emissiveStrength", strength, 1.0f).attach_to(out.json(), "KHR_materials_emissive_strength");
}

void write_core(Writer& writer, const Material& m, Fields& out) {
    Fields pbr(writer);
    pbr.color("baseColorFactor", m.base_color, kDefault.base_color)
        .texture("baseColorTexture", m.base_color_texture, kSrgb)
        .factor("metallicFactor", m.metallic, kDefault.metallic)
        .factor("roughnessFactor", m.roughness, kDefault.roughness)
        .texture("metallicRoughnessTexture", m.metal_rough_texture, kLinear);
    if (!pbr.json().empty()) out.json()["pbrMetallicRoughness"] = std::move(pbr.json());
    out.texture("normalTexture", m.normal_texture, "scale", m.normal_scale, kDefault.normal_scale)
        .texture("occlusionTexture", m.occlusion_texture, "strength", m.occlusion_strength, kDefault.occlusion_strength)
        .texture("emissiveTexture", m.emissive_texture, kSrgb);
    write_emission(writer, m, out);
    if (m.alpha_mode != AlphaMode::Opaque) out.json()["alphaMode"] = m.alpha_mode == AlphaMode::Mask ? "MASK" : "BLEND";
    // The schema ties the cutoff to MASK (5.19.8); elsewhere it has no effect.
    if (m.alpha_mode == AlphaMode::Mask) out.factor("alphaCutoff", m.alpha_cutoff, kDefault.alpha_cutoff);
    if (m.double_sided) out.json()["doubleSided"] = true;
    if (m.nested_priority != 0) out.json()["extras"][kNestedPriorityKey] = m.nested_priority;
    if (m.unlit) writer.extend(out.json(), "KHR_materials_unlit", Json::object());
}

void write_transmissive(Writer& writer, const Material& m, Json& out) {
    Fields(writer)
        .factor("transmissionFactor", m.transmission, kDefault.transmission)
        .texture("transmissionTexture", m.transmission_texture, kLinear)
        .attach_to(out, "KHR_materials_transmission");
    Fields(writer)
        .factor("thicknessFactor", m.thickness, kDefault.thickness)
        .texture("thicknessTexture", m.thickness_texture, kLinear)
        .factor("attenuationDistance", m.attenuation_distance, kDefault.attenuation_distance)
        .color("attenuationColor", m.attenuation_color, kDefault.attenuation_color)
        .attach_to(out, "KHR_materials_volume");
    Fields(writer).factor("dispersion", m.dispersion, kDefault.dispersion).attach_to(out, "KHR_materials_dispersion");
}

void write_coats(Writer& writer, const Material& m, Json& out) {
    Fields(writer)
        .factor("clearcoatFactor", m.clearcoat, kDefault.clearcoat)
        .texture("clearcoatTexture", m.clearcoat_texture, kLinear)
        .factor("clearcoatRoughnessFactor", m.clearcoat_roughness, kDefault.clearcoat_roughness)
        .texture("clearcoatRoughnessTexture", m.clearcoat_roughness_texture, kLinear)
        .texture("clearcoatNormalTexture", m.clearcoat_normal_texture, "scale", m.clearcoat_normal_scale, kDefault.clearcoat_normal_scale)
        .attach_to(out, "KHR_materials_clearcoat");
    Fields(writer)
        .color("sheenColorFactor", m.sheen_color, kDefault.sheen_color)
        .texture("sheenColorTexture", m.sheen_color_texture, kSrgb)
        .factor("sheenRoughnessFactor", m.sheen_roughness, kDefault.sheen_roughness)
        .texture("sheenRoughnessTexture", m.sheen_roughness_texture, kLinear)
        .attach_to(out, "KHR_materials_sheen");
}

void write_reflection(Writer& writer, const Material& m, Json& out) {
    Fields(writer).factor("ior", m.ior, kDefault.ior).attach_to(out, "KHR_materials_ior");
    Fields(writer)
        .factor("specularFactor", m.specular, kDefault.specular)
        .texture("specularTexture", m.specular_texture, kLinear)
        .color("specularColorFactor", m.specular_color, kDefault.specular_color)
        .texture("specularColorTexture", m.specular_color_texture, kSrgb)
        .attach_to(out, "KHR_materials_specular");
    Fields(writer)
        .factor("anisotropyStrength", m.anisotropy, kDefault.anisotropy)
        .factor("anisotropyRotation", m.anisotropy_rotation, kDefault.anisotropy_rotation)
        .texture("anisotropyTexture", m.anisotropy_texture, kLinear)
        .attach_to(out, "KHR_materials_anisotropy");
    Fields(writer)
        .factor("iridescenceFactor", m.iridescence, kDefault.iridescence)
        .texture("iridescenceTexture", m.iridescence_texture, kLinear)
        .factor("iridescenceIor", m.iridescence_ior, kDefault.iridescence_ior)
        .factor("iridescenceThicknessMinimum", m.iridescence_thickness_min, kDefault.iridescence_thickness_min)
        .factor("iridescenceThicknessMaximum", m.iridescence_thickness_max, kDefault.iridescence_thickness_max)
        .texture("iridescenceThicknessTexture", m.iridescence_thickness_texture, kLinear)
        .attach_to(out, "KHR_materials_iridescence");
}

}  // namespace

void write_materials(Writer& writer) {
    for (const auto& [handle, material] : writer.scene.materials()) {
        Fields out(writer);
        out.json() = named(material.name);
        write_core(writer, material, out);
        write_reflection(writer, material, out.json());
        write_transmissive(writer, material, out.json());
        write_coats(writer, material, out.json());
        writer.materials.set(handle, writer.push("materials", std::move(out.json())));
    }
    const std::vector<std::string>& variants = writer.scene.source().variants;
    if (variants.empty()) return;
    Json list = Json::array();
    for (const std::string& name : variants) list.push_back({{"name", name}});
    writer.extend(writer.root, "KHR_materials_variants", {{"variants", std::move(list)}});
}

}  // namespace parhelion::gltf
