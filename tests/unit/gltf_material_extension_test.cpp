// KHR_materials_*: every field, its default, its range, its texture.
#include <gtest/gtest.h>

#include <limits>

#include "gltf_make.h"
#include "image/encode.h"

namespace parhelion::test::gltf_material_extension_test {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// A triangle with this material, and a PNG as texture 0.
GltfMaker with_material(json material) {
    GltfMaker maker;
    maker.add_triangle()["material"] = 0;
    maker.push("materials", std::move(material));
    const image::Picture8 picture{.width = 1, .height = 1, .rgb = {10, 20, 30}};
    maker.push("images", {{"bufferView", maker.view_bytes(image::encode_png(picture))}, {"mimeType", "image/png"}});
    maker.push("textures", {{"source", 0}});
    return maker;
}

GltfMaker with_extension(const std::string& name, json value) { return with_material({{"extensions", {{name, std::move(value)}}}}); }

void expect_same_numbers(const Material& a, const Material& b) {
    const auto numbers = [](const Material& m) {
        std::vector<float> out = {m.metallic, m.roughness, m.normal_scale, m.occlusion_strength, m.ior, m.specular, m.transmission, m.thickness,
                                  m.attenuation_distance, m.dispersion, m.clearcoat, m.clearcoat_roughness, m.clearcoat_normal_scale, m.sheen_roughness,
                                  m.anisotropy, m.anisotropy_rotation, m.iridescence, m.iridescence_ior, m.iridescence_thickness_min, m.iridescence_thickness_max};
        for (const glm::vec3& v : {glm::vec3(m.base_color), m.emission, m.specular_color, m.attenuation_color, m.sheen_color}) out.insert(out.end(), {v.x, v.y, v.z});
        return out;
    };
    EXPECT_EQ(numbers(a), numbers(b));
}

struct Use {
    const char* extension;  // "": the material itself
    const char* key;
    TextureRef Material::*ref;
    ColorSpace space;
};
constexpr ColorSpace kSrgb = ColorSpace::Srgb, kLinear = ColorSpace::Linear;
constexpr Use kUses[] = {
    {"pbr", "baseColorTexture", &Material::base_color_texture, kSrgb},
    {"pbr", "metallicRoughnessTexture", &Material::metal_rough_texture, kLinear},
    {"", "normalTexture", &Material::normal_texture, kLinear},
    {"", "occlusionTexture", &Material::occlusion_texture, kLinear},
    {"", "emissiveTexture", &Material::emissive_texture, kSrgb},
    {"KHR_materials_specular", "specularTexture", &Material::specular_texture, kLinear},
    {"KHR_materials_specular", "specularColorTexture", &Material::specular_color_texture, kSrgb},
    {"KHR_materials_transmission", "transmissionTexture", &Material::transmission_texture, kLinear},
    {"KHR_materials_volume", "thicknessTexture", &Material::thickness_texture, kLinear},
    {"KHR_materials_clearcoat", "clearcoatTexture", &Material::clearcoat_texture, kLinear},
    {"KHR_materials_clearcoat", "clearcoatRoughnessTexture", &Material::clearcoat_roughness_texture, kLinear},
    {"KHR_materials_clearcoat", "clearcoatNormalTexture", &Material::clearcoat_normal_texture, kLinear},
    {"KHR_materials_sheen", "sheenColorTexture", &Material::sheen_color_texture, kSrgb},
    {"KHR_materials_sheen", "sheenRoughnessTexture", &Material::sheen_roughness_texture, kLinear},
    {"KHR_materials_anisotropy", "anisotropyTexture", &Material::anisotropy_texture, kLinear},
    {"KHR_materials_iridescence", "iridescenceTexture", &Material::iridescence_texture, kLinear},
    {"KHR_materials_iridescence", "iridescenceThicknessTexture", &Material::iridescence_thickness_texture, kLinear},
};

json material_with_texture(const Use& use, json info) {
    const std::string extension = use.extension;
    const json part = {{use.key, std::move(info)}};
    return extension.empty() ? part : extension == "pbr" ? json{{"pbrMetallicRoughness", part}} : json{{"extensions", {{extension, part}}}};
}

}  // namespace

TEST(GltfMaterialExtensions, every_number_is_read_into_its_field) {
    const Scene scene = with_material({{"occlusionTexture", {{"index", 0}, {"strength", 0.25}}},
                                       {"emissiveFactor", {1, 0.5, 0}},
                                       {"extensions",
                                        {{"KHR_materials_emissive_strength", {{"emissiveStrength", 8}}},
                                         {"KHR_materials_ior", {{"ior", 1.25}}},
                                         {"KHR_materials_specular", {{"specularFactor", 0.5}, {"specularColorFactor", {0.5, 1, 4}}}},
                                         {"KHR_materials_transmission", {{"transmissionFactor", 0.75}}},
                                         {"KHR_materials_volume", {{"thicknessFactor", 2}, {"attenuationDistance", 0.125}, {"attenuationColor", {0.25, 0.5, 0.75}}}},
                                         {"KHR_materials_clearcoat", {{"clearcoatFactor", 0.5}, {"clearcoatRoughnessFactor", 0.25}, {"clearcoatNormalTexture", {{"index", 0}, {"scale", -2}}}}},
                                         {"KHR_materials_sheen", {{"sheenColorFactor", {0.125, 0.25, 0.5}}, {"sheenRoughnessFactor", 0.375}}},
                                         {"KHR_materials_anisotropy", {{"anisotropyStrength", 0.625}, {"anisotropyRotation", -7}}},
                                         {"KHR_materials_iridescence", {{"iridescenceFactor", 0.5}, {"iridescenceIor", 1.75}, {"iridescenceThicknessMinimum", 300}, {"iridescenceThicknessMaximum", 200}}},
                                         {"KHR_materials_dispersion", {{"dispersion", 0.5}}}}}})
                            .load();
    EXPECT_TRUE(scene.source().warnings.empty());
    const Material& m = only_material(scene);
    Material expected{.occlusion_strength = 0.25f, .emission = {8, 4, 0}, .ior = 1.25f, .specular = 0.5f, .specular_color = {0.5f, 1, 4}, .transmission = 0.75f};
    expected.thickness = 2, expected.attenuation_distance = 0.125f, expected.attenuation_color = {0.25f, 0.5f, 0.75f};
    expected.clearcoat = 0.5f, expected.clearcoat_roughness = 0.25f, expected.clearcoat_normal_scale = -2;
    expected.sheen_color = {0.125f, 0.25f, 0.5f}, expected.sheen_roughness = 0.375f;
    expected.anisotropy = 0.625f, expected.anisotropy_rotation = -7;
    expected.iridescence = 0.5f, expected.iridescence_ior = 1.75f, expected.iridescence_thickness_min = 300, expected.iridescence_thickness_max = 200;
    expected.dispersion = 0.5f;
    expect_same_numbers(m, expected);
}

TEST(GltfMaterialExtensions, an_empty_extension_changes_nothing) {
    json all = json::object();
    for (const char* name : {"emissive_strength", "ior", "specular", "transmission", "volume", "clearcoat", "sheen", "anisotropy", "iridescence", "dispersion"})
        all[std::string("KHR_materials_") + name] = json::object();
    const Scene scene = with_material({{"extensions", all}}).load();
    EXPECT_TRUE(scene.source().warnings.empty());
    expect_same_numbers(only_material(scene), Material{});
    EXPECT_EQ(only_material(scene).attenuation_distance, kInfinity);
    for (const MaterialTexture& texture : material_textures()) EXPECT_FALSE((only_material(scene).*texture.ref).texture);
}

TEST(GltfMaterialExtensions, every_texture_has_its_color_space_its_uv_set_and_its_transform) {
    EXPECT_EQ(std::size(kUses), material_textures().size());
    const json transform = {{"offset", {0.5, 0.25}}, {"scale", {2, 4}}, {"rotation", 0.75}, {"texCoord", 1}};
    for (const Use& use : kUses) {
        const json info = {{"index", 0}, {"extensions", {{"KHR_texture_transform", transform}}}};
        const Scene scene = with_material(material_with_texture(use, info)).load();
        const TextureRef& ref = only_material(scene).*use.ref;
        ASSERT_TRUE(ref.texture) << use.key;
        EXPECT_EQ(scene.get(ref.texture).color_space, use.space) << use.key;
        EXPECT_EQ(ref.uv_set, 1u) << use.key;
        EXPECT_EQ(ref.offset, glm::vec2(0.5f, 0.25f)) << use.key;
        EXPECT_EQ(ref.scale, glm::vec2(2, 4)) << use.key;
        EXPECT_EQ(ref.rotation, 0.75f) << use.key;
        for (const MaterialTexture& texture : material_textures())
            EXPECT_EQ(bool((only_material(scene).*texture.ref).texture), texture.ref == use.ref) << use.key;
        EXPECT_CONTAINS(with_material(material_with_texture(use, json::object())).error(), std::string(use.key) + ": lacks 'index'");
        EXPECT_CONTAINS(with_material(material_with_texture(use, {{"index", 3}})).error(), std::string(use.key) + ".index: names textures[3]");
    }
}

TEST(GltfMaterialExtensions, numbers_out_of_range_are_clamped_with_one_warning) {
    struct Case {
        const char* extension;
        const char* key;
        json value;
        float Material::*field;
        float expected;
    };
    const Case cases[] = {{"KHR_materials_ior", "ior", 0.5, &Material::ior, 1.0f},
                          {"KHR_materials_specular", "specularFactor", 2, &Material::specular, 1.0f},
                          {"KHR_materials_transmission", "transmissionFactor", -1, &Material::transmission, 0.0f},
                          {"KHR_materials_volume", "thicknessFactor", -1, &Material::thickness, 0.0f},
                          {"KHR_materials_volume", "attenuationDistance", 0, &Material::attenuation_distance, kInfinity},
                          {"KHR_materials_volume", "attenuationDistance", -3, &Material::attenuation_distance, kInfinity},
                          {"KHR_materials_clearcoat", "clearcoatFactor", 2, &Material::clearcoat, 1.0f},
                          {"KHR_materials_clearcoat", "clearcoatRoughnessFactor", 2, &Material::clearcoat_roughness, 1.0f},
                          {"KHR_materials_sheen", "sheenRoughnessFactor", 2, &Material::sheen_roughness, 1.0f},
                          {"KHR_materials_anisotropy", "anisotropyStrength", 2, &Material::anisotropy, 1.0f},
                          {"KHR_materials_iridescence", "iridescenceFactor", 2, &Material::iridescence, 1.0f},
                          {"KHR_materials_iridescence", "iridescenceIor", 0.5, &Material::iridescence_ior, 1.0f},
                          {"KHR_materials_iridescence", "iridescenceThicknessMinimum", -1, &Material::iridescence_thickness_min, 0.0f},
                          {"KHR_materials_iridescence", "iridescenceThicknessMaximum", -1, &Material::iridescence_thickness_max, 0.0f},
                          {"KHR_materials_dispersion", "dispersion", -1, &Material::dispersion, 0.0f}};
    for (const Case& c : cases) {
        const Scene scene = with_extension(c.extension, {{c.key, c.value}}).load();
        EXPECT_EQ(only_material(scene).*c.field, c.expected) << c.key;
        ASSERT_EQ(scene.source().warnings.size(), 1u) << c.key;
        EXPECT_CONTAINS(scene.source().warnings[0], std::string("materials[0].extensions.") + c.extension + ": " + c.key + " ");
        EXPECT_CONTAINS(with_extension(c.extension, {{c.key, "high"}}).error(), std::string(c.key) + ": is \"high\", expected a number");
        EXPECT_CONTAINS(with_extension(c.extension, 3).error(), std::string("materials[0].extensions.") + c.extension + ": is 3, expected an object");
    }
}

TEST(GltfMaterialExtensions, colors_out_of_range_are_clamped_and_specular_colors_may_exceed_one) {
    struct Case {
        const char* extension;
        const char* key;
        glm::vec3 Material::*field;
        glm::vec3 expected;
    };
    const Case cases[] = {{"KHR_materials_volume", "attenuationColor", &Material::attenuation_color, {0, 0.5f, 1}},
                          {"KHR_materials_sheen", "sheenColorFactor", &Material::sheen_color, {0, 0.5f, 1}},
                          {"KHR_materials_specular", "specularColorFactor", &Material::specular_color, {0, 0.5f, 3}}};
    for (const Case& c : cases) {
        const Scene scene = with_extension(c.extension, {{c.key, {-1, 0.5, 3}}}).load();
        EXPECT_EQ(only_material(scene).*c.field, c.expected) << c.key;
        EXPECT_EQ(scene.source().warnings.size(), 1u) << c.key;
        EXPECT_CONTAINS(with_extension(c.extension, {{c.key, {1, 1}}}).error(), std::string(c.key) + ": is array, expected an array of 3 numbers");
    }
    EXPECT_TRUE(with_extension("KHR_materials_specular", {{"specularColorFactor", {1, 1, 3}}}).load().source().warnings.empty());
}

TEST(GltfMaterialExtensions, an_ior_of_zero_is_allowed) {
    const Scene scene = with_extension("KHR_materials_ior", {{"ior", 0}}).load();
    EXPECT_EQ(only_material(scene).ior, 0.0f);
    EXPECT_TRUE(scene.source().warnings.empty());
}

TEST(GltfMaterialExtensions, occlusion_strength_is_clamped) {
    const Scene scene = with_material({{"occlusionTexture", {{"index", 0}, {"strength", 2}}}}).load();
    EXPECT_EQ(only_material(scene).occlusion_strength, 1.0f);
    EXPECT_EQ(scene.source().warnings.size(), 1u);
}

TEST(GltfMaterialExtensions, specular_glossiness_becomes_a_dielectric_that_reflects_its_specular_color) {
    const json info = {{"index", 0}};
    GltfMaker maker = with_material(
        {{"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicRoughnessTexture", {{"index", 1}}}}},
         {"extensions",
          {{"KHR_materials_pbrSpecularGlossiness",
            {{"diffuseFactor", {0.5, 0.25, 0.125, 0.75}}, {"diffuseTexture", info}, {"specularFactor", {0.25, 0.5, 1}}, {"glossinessFactor", 0.75}, {"specularGlossinessTexture", info}}}}}});
    // The fallback's own texture is not looked at.
    maker.push("images", {{"bufferView", maker.view_bytes(to_bytes("no image"))}});
    maker.push("textures", {{"source", 1}});
    const json copy = maker.doc["materials"][0];
    maker.push("materials", copy);
    maker.add_triangle()["material"] = 1;
    const Scene scene = maker.load();
    ASSERT_EQ(scene.materials().size(), 2u);
    const Material& m = (*scene.materials().begin()).value;
    EXPECT_EQ(m.base_color, glm::vec4(0.5f, 0.25f, 0.125f, 0.75f));
    EXPECT_EQ(m.metallic, 0.0f);
    EXPECT_EQ(m.roughness, 0.25f);
    EXPECT_EQ(m.ior, 0.0f);
    EXPECT_EQ(m.specular, 1.0f);
    EXPECT_EQ(m.specular_color, glm::vec3(0.25f, 0.5f, 1));
    EXPECT_TRUE(m.base_color_texture.texture);
    EXPECT_EQ(m.base_color_texture.texture, m.specular_color_texture.texture);
    EXPECT_EQ(scene.get(m.base_color_texture.texture).color_space, ColorSpace::Srgb);
    EXPECT_FALSE(m.metal_rough_texture.texture);
    ASSERT_EQ(scene.source().warnings.size(), 1u);
    EXPECT_CONTAINS(scene.source().warnings[0], "KHR_materials_pbrSpecularGlossiness is archived and approximated");
}

}  // namespace parhelion::test::gltf_material_extension_test
