// Materials, textures, samplers, images.
#include <gtest/gtest.h>

#include <chrono>

#include "gltf_make.h"
#include "image/encode.h"

namespace parhelion::test::gltf_material_test {

namespace {

std::vector<std::byte> png(uint8_t red, uint32_t size = 2) {
    image::Picture8 picture{.width = size, .height = size};
    for (uint32_t i = 0; i < size * size; ++i) picture.rgb.insert(picture.rgb.end(), {red, 20, 30});
    return image::encode_png(picture);
}

GltfMaker with_material(json material) {
    GltfMaker maker;
    maker.add_triangle()["material"] = 0;
    maker.push("materials", std::move(material));
    return maker;
}

// A PNG as texture 0 over image 0.
void add_texture(GltfMaker& maker) {
    maker.push("images", {{"bufferView", maker.view_bytes(png(10))}, {"mimeType", "image/png"}});
    maker.push("textures", {{"source", 0}});
}

}  // namespace

TEST(GltfMaterials, factors_have_the_defaults_of_gltf_and_are_read) {
    const Scene plain = with_material(json::object()).load();
    const Material& d = only_material(plain);
    EXPECT_EQ(d.base_color, glm::vec4(1));
    EXPECT_EQ(d.metallic, 1.0f);
    EXPECT_EQ(d.roughness, 1.0f);
    EXPECT_EQ(d.emission, glm::vec3(0));
    EXPECT_EQ(d.alpha_mode, AlphaMode::Opaque);
    EXPECT_EQ(d.alpha_cutoff, 0.5f);
    EXPECT_FALSE(d.double_sided || d.unlit);
    EXPECT_EQ(d.ior, 1.5f);
    EXPECT_EQ(d.specular, 1.0f);

    const Scene full = with_material({{"name", "all"},
                                      {"pbrMetallicRoughness",
                                       {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"metallicFactor", 0.25}, {"roughnessFactor", 0.75}}},
                                      {"emissiveFactor", {1, 0.5, 0}},
                                      {"alphaMode", "MASK"},
                                      {"alphaCutoff", 0.25},
                                      {"doubleSided", true},
                                      {"extensions",
                                       {{"KHR_materials_emissive_strength", {{"emissiveStrength", 10}}},
                                        {"KHR_materials_unlit", json::object()},
                                        {"KHR_materials_ior", {{"ior", 1.33}}},
                                        {"KHR_materials_specular", {{"specularFactor", 0.5}}},
                                        {"KHR_materials_transmission", {{"transmissionFactor", 0.9}}}}}})
                           .load();
    const Material& m = only_material(full);
    EXPECT_EQ(m.name, "all");
    EXPECT_EQ(m.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
    EXPECT_EQ(m.metallic, 0.25f);
    EXPECT_EQ(m.roughness, 0.75f);
    EXPECT_EQ(m.emission, glm::vec3(10, 5, 0));
    EXPECT_EQ(m.alpha_mode, AlphaMode::Mask);
    EXPECT_EQ(m.alpha_cutoff, 0.25f);
    EXPECT_TRUE(m.double_sided && m.unlit);
    EXPECT_EQ(m.ior, 1.33f);
    EXPECT_EQ(m.specular, 0.5f);
    EXPECT_EQ(m.transmission, 0.9f);
}

TEST(GltfMaterials, values_out_of_range_are_clamped_with_a_warning) {
    const Scene scene =
        with_material({{"pbrMetallicRoughness", {{"metallicFactor", 2}, {"baseColorFactor", {-1, 0, 0, 1}}}}, {"alphaMode", "GLOW"}})
            .load();
    EXPECT_EQ(only_material(scene).metallic, 1.0f);
    EXPECT_EQ(only_material(scene).base_color.x, 0.0f);
    EXPECT_EQ(scene.source().warnings.size(), 3u);
    EXPECT_CONTAINS(with_material({{"pbrMetallicRoughness", {{"metallicFactor", "high"}}}}).error(),
                    "materials[0].pbrMetallicRoughness.metallicFactor: is \"high\", expected a number");
}

TEST(GltfMaterials, textures_know_their_color_space_and_one_image_may_have_two) {
    GltfMaker maker =
        with_material({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}, {"metallicRoughnessTexture", {{"index", 0}}}}},
                       {"emissiveTexture", {{"index", 0}}}});
    add_texture(maker);
    const Scene scene = maker.load();
    const Material& m = only_material(scene);
    EXPECT_EQ(scene.images().size(), 1u);
    EXPECT_EQ(scene.textures().size(), 2u);
    EXPECT_EQ(m.base_color_texture.texture, m.emissive_texture.texture);
    EXPECT_EQ(scene.get(m.base_color_texture.texture).color_space, ColorSpace::Srgb);
    EXPECT_EQ(scene.get(m.metal_rough_texture.texture).color_space, ColorSpace::Linear);
    const Image& image = scene.get(scene.get(m.metal_rough_texture.texture).image);
    EXPECT_EQ(image.width, 2u);
    EXPECT_EQ(image.texels[0], 10);
    EXPECT_EQ(image.texels[3], 255);
}

TEST(GltfMaterials, samplers_are_read_and_unknown_modes_are_warnings) {
    struct Case {
        int min;
        Filter filter;
        std::optional<Filter> mip;
    };
    const Case cases[] = {{9728, Filter::Nearest, std::nullopt},    {9729, Filter::Linear, std::nullopt},
                          {9984, Filter::Nearest, Filter::Nearest}, {9985, Filter::Linear, Filter::Nearest},
                          {9986, Filter::Nearest, Filter::Linear},  {9987, Filter::Linear, Filter::Linear}};
    for (const Case& c : cases) {
        GltfMaker maker = with_material({{"emissiveTexture", {{"index", 0}}}});
        add_texture(maker);
        maker.push("samplers", {{"minFilter", c.min}, {"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}});
        maker.doc["textures"][0]["sampler"] = 0;
        const Scene scene = maker.load();
        const Sampler& sampler = (*scene.textures().begin()).value.sampler;
        EXPECT_EQ(sampler.min, c.filter);
        EXPECT_EQ(sampler.mip, c.mip);
        EXPECT_EQ(sampler.mag, Filter::Nearest);
        EXPECT_EQ(sampler.wrap_u, Wrap::ClampToEdge);
        EXPECT_EQ(sampler.wrap_v, Wrap::MirroredRepeat);
        maker.doc["samplers"][0]["wrapS"] = 1;
        EXPECT_EQ(maker.load().source().warnings.size(), 1u);
    }
}

TEST(GltfMaterials, texture_transforms_are_read_and_turn_counter_clockwise_as_seen) {
    GltfMaker maker = with_material(
        {{"emissiveTexture",
          {{"index", 0},
           {"texCoord", 0},
           {"extensions",
            {{"KHR_texture_transform", {{"offset", {0.5, 0.25}}, {"scale", {2, 4}}, {"rotation", 0.75}, {"texCoord", 1}}}}}}}});
    add_texture(maker);
    const Scene scene = maker.load();
    const TextureRef& ref = only_material(scene).emissive_texture;
    EXPECT_EQ(ref.uv_set, 1u);
    EXPECT_EQ(ref.offset, glm::vec2(0.5f, 0.25f));
    EXPECT_EQ(ref.scale, glm::vec2(2, 4));
    EXPECT_EQ(ref.rotation, 0.75f);

    TextureRef quarter{.rotation = 1.5707963f};
    // v points down in the image: a quarter turn takes right (1, 0) to up (0, -1).
    const glm::vec3 turned = uv_transform(quarter) * glm::vec3(1, 0, 1);
    EXPECT_NEAR(turned.x, 0.0f, 1e-6f);
    EXPECT_NEAR(turned.y, -1.0f, 1e-6f);
    const glm::vec3 all = uv_transform(TextureRef{.offset = {1, 2}, .scale = {2, 3}, .rotation = 1.5707963f}) * glm::vec3(1, 1, 1);
    EXPECT_NEAR(all.x, 1.0f + 3.0f, 1e-6f);
    EXPECT_NEAR(all.y, 2.0f - 2.0f, 1e-6f);
}

TEST(GltfMaterials, texture_coordinate_sets_beyond_the_second_leave_the_texture_out) {
    GltfMaker maker = with_material({{"emissiveTexture", {{"index", 0}, {"texCoord", 2}}}});
    add_texture(maker);
    const Scene scene = maker.load();
    EXPECT_FALSE(only_material(scene).emissive_texture.texture);
    ASSERT_EQ(scene.source().warnings.size(), 1u);
    EXPECT_CONTAINS(scene.source().warnings[0], "TEXCOORD_2");
}

TEST(GltfMaterials, images_that_cannot_be_decoded_are_errors_with_a_name) {
    GltfMaker maker = with_material({{"emissiveTexture", {{"index", 0}}}});
    add_texture(maker);
    std::vector<std::byte> cut = png(10, 64);
    cut.resize(cut.size() / 2);
    maker.doc["images"][0]["bufferView"] = maker.view_bytes(cut);
    EXPECT_CONTAINS(maker.error(), "test.gltf: images[0]: ");
    maker.doc["images"][0]["bufferView"] = maker.view_bytes(to_bytes("GIF89a..."));
    EXPECT_CONTAINS(maker.error(), "test.gltf: images[0]: is no image of a known format");
    maker.doc["images"][0] = json::object();
    EXPECT_CONTAINS(maker.error(), "images[0]: has neither a uri nor a bufferView");
    maker.doc["images"][0] = {{"uri", "data:image/png;base64," + base64(png(77))}};
    EXPECT_EQ(maker.error(), "");
    maker.doc["textures"][0].erase("source");
    EXPECT_EQ(maker.load().source().warnings.size(), 1u);
    maker.doc["textures"][0]["source"] = 5;
    EXPECT_CONTAINS(maker.error(), "textures[0].source: names images[5]");
}

// A file may name one broken image thousands of times: the first of them ends the reading.
TEST(GltfMaterials, a_thousand_broken_images_are_refused_within_seconds) {
    GltfMaker maker;
    // 1500 x 1500 zeros and then no end.
    std::vector<std::byte> cut = png(0, 1500);
    cut.resize(cut.size() - 20);
    const int view = maker.view_bytes(cut);
    const json triangle = maker.add_triangle();
    json primitives = json::array();
    for (int i = 0; i < 1000; ++i) {
        maker.push("images", {{"bufferView", view}});
        maker.push("textures", {{"source", i}});
        maker.push("materials", {{"emissiveTexture", {{"index", i}}}});
        json primitive = triangle;
        primitive["material"] = i;
        primitives.push_back(std::move(primitive));
    }
    maker.doc["meshes"][0]["primitives"] = std::move(primitives);
    const auto start = std::chrono::steady_clock::now();
    EXPECT_CONTAINS(maker.error(), "images[0]");
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 10.0);
}

TEST(GltfMaterials, only_what_the_scene_shows_is_decoded) {
    GltfMaker maker = with_material(json::object());
    add_texture(maker);
    maker.doc["images"][0]["bufferView"] = maker.view_bytes(to_bytes("no image"));
    maker.push("materials", {{"emissiveTexture", {{"index", 0}}}});
    EXPECT_EQ(maker.error(), "");
    maker.doc["meshes"][0]["primitives"][0]["material"] = 1;
    EXPECT_CONTAINS(maker.error(), "images[0]");
}

}  // namespace parhelion::test::gltf_material_test
