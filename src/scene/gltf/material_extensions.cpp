// Ranges, defaults and channels are those of the extensions' own specifications (Khronos glTF registry, extensions/2.0/Khronos).
// Everywhere a factor multiplies its texture; a texture without a factor that is set changes nothing where the factor's default is 0.
#include "scene/gltf/material_extensions.h"

namespace parhelion {

namespace {

constexpr ColorSpace kSrgb = ColorSpace::Srgb, kLinear = ColorSpace::Linear;

// Archived. KHR_materials_specular, "Specular-glossiness materials", has the conversion: a dielectric of ior 0, which reflects
// everything, scaled by the specular colour. What is missing is glossiness by texture (alpha of specularGlossinessTexture).
void read_specular_glossiness(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.base_color = fields.color<4>(json, "diffuseFactor", 1.0f, 1.0f);
    out.base_color_texture = fields.texture(json, "diffuseTexture", kSrgb);
    out.metallic = 0.0f;
    out.roughness = 1.0f - fields.number(json, "glossinessFactor", 1.0f, 0.0f, 1.0f);
    out.ior = 0.0f;
    out.specular_color = fields.color<3>(json, "specularFactor", 1.0f, 1.0f);
    out.specular_color_texture = fields.texture(json, "specularGlossinessTexture", kSrgb);
    fields.document.warn("KHR_materials_pbrSpecularGlossiness is archived and approximated: glossiness textures are not drawn");
}

void read_ior(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.ior = json.number("ior", 1.5f);
    // 0 is allowed and means a surface that reflects everything.
    if (out.ior != 0.0f) out.ior = fields.number(json, "ior", 1.5f, 1.0f, MaterialFields::kMost);
}

void read_specular(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.specular = fields.number(json, "specularFactor", 1.0f, 0.0f, 1.0f);
    out.specular_texture = fields.texture(json, "specularTexture", kLinear);
    // Above 1 it makes up for a low ior; the product with the ior's reflectance is what ends at 1.
    out.specular_color = fields.color<3>(json, "specularColorFactor", 1.0f, MaterialFields::kMost);
    out.specular_color_texture = fields.texture(json, "specularColorTexture", kSrgb);
}

void read_transmission(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.transmission = fields.number(json, "transmissionFactor", 0.0f, 0.0f, 1.0f);
    out.transmission_texture = fields.texture(json, "transmissionTexture", kLinear);
}

void read_volume(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.thickness = fields.number(json, "thicknessFactor", 0.0f, 0.0f, MaterialFields::kMost);
    out.thickness_texture = fields.texture(json, "thicknessTexture", kLinear);
    out.attenuation_color = fields.color<3>(json, "attenuationColor", 1.0f, 1.0f);
    if (!json.find("attenuationDistance")) return;
    // No nearest value inside the range to clamp to: the distance lies above 0.
    const float distance = json.at("attenuationDistance").as_float();
    if (distance > 0.0f)
        out.attenuation_distance = distance;
    else
        fields.document.warn(json, fmt::format("attenuationDistance {} is not above 0 and taken as infinite", distance));
}

void read_clearcoat(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.clearcoat = fields.number(json, "clearcoatFactor", 0.0f, 0.0f, 1.0f);
    out.clearcoat_texture = fields.texture(json, "clearcoatTexture", kLinear);
    out.clearcoat_roughness = fields.number(json, "clearcoatRoughnessFactor", 0.0f, 0.0f, 1.0f);
    out.clearcoat_roughness_texture = fields.texture(json, "clearcoatRoughnessTexture", kLinear);
    out.clearcoat_normal_texture = fields.texture(json, "clearcoatNormalTexture", kLinear);
    if (const std::optional<JsonRef> normal = json.find("clearcoatNormalTexture")) out.clearcoat_normal_scale = normal->number("scale", 1.0f);
}

void read_sheen(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.sheen_color = fields.color<3>(json, "sheenColorFactor", 0.0f, 1.0f);
    out.sheen_color_texture = fields.texture(json, "sheenColorTexture", kSrgb);
    out.sheen_roughness = fields.number(json, "sheenRoughnessFactor", 0.0f, 0.0f, 1.0f);
    out.sheen_roughness_texture = fields.texture(json, "sheenRoughnessTexture", kLinear);
}

void read_anisotropy(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.anisotropy = fields.number(json, "anisotropyStrength", 0.0f, 0.0f, 1.0f);
    out.anisotropy_rotation = json.number("anisotropyRotation", 0.0f);
    out.anisotropy_texture = fields.texture(json, "anisotropyTexture", kLinear);
}

void read_iridescence(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.iridescence = fields.number(json, "iridescenceFactor", 0.0f, 0.0f, 1.0f);
    out.iridescence_texture = fields.texture(json, "iridescenceTexture", kLinear);
    out.iridescence_ior = fields.number(json, "iridescenceIor", 1.3f, 1.0f, MaterialFields::kMost);
    // Between the two by the texture, the maximum without one; the minimum may be the greater one.
    out.iridescence_thickness_min = fields.number(json, "iridescenceThicknessMinimum", 100.0f, 0.0f, MaterialFields::kMost);
    out.iridescence_thickness_max = fields.number(json, "iridescenceThicknessMaximum", 400.0f, 0.0f, MaterialFields::kMost);
    out.iridescence_thickness_texture = fields.texture(json, "iridescenceThicknessTexture", kLinear);
}

void read_dispersion(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.dispersion = fields.number(json, "dispersion", 0.0f, 0.0f, MaterialFields::kMost);
}

void read_emissive_strength(const MaterialFields& fields, const JsonRef& json, Material& out) {
    out.emission *= fields.number(json, "emissiveStrength", 1.0f, 0.0f, 1e30f);
}

void read_unlit(const MaterialFields&, const JsonRef&, Material& out) { out.unlit = true; }

struct Reader {
    const char* name;
    void (*read)(const MaterialFields& fields, const JsonRef& json, Material& out);
};
// Specular-glossiness comes first: what the others say of the same fields counts.
constexpr Reader kReaders[] = {
    {"KHR_materials_pbrSpecularGlossiness", read_specular_glossiness},
    {"KHR_materials_emissive_strength", read_emissive_strength},
    {"KHR_materials_unlit", read_unlit},
    {"KHR_materials_ior", read_ior},
    {"KHR_materials_specular", read_specular},
    {"KHR_materials_transmission", read_transmission},
    {"KHR_materials_volume", read_volume},
    {"KHR_materials_clearcoat", read_clearcoat},
    {"KHR_materials_sheen", read_sheen},
    {"KHR_materials_anisotropy", read_anisotropy},
    {"KHR_materials_iridescence", read_iridescence},
    {"KHR_materials_dispersion", read_dispersion},
};

}  // namespace

void read_material_extensions(const MaterialFields& fields, const JsonRef& json, Material& material) {
    for (const Reader& reader : kReaders)
        if (const std::optional<JsonRef> extension = json.extension(reader.name)) reader.read(fields, *extension, material);
}

}  // namespace parhelion
