// What a material reads and from where: channels, colour spaces, UV sets and transforms, vertex colours, normal maps. Constant over
// the picture and without noise, so exact.
#include <cmath>
#include <numbers>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::material_input_test {
namespace {

using Texels = std::vector<glm::u8vec3>;

class MaterialInputs : public GpuTest {
protected:
    static Primitive ground() {
        Primitive p;
        add_textured_quad(p, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
        return p;
    }
    static TextureRef texture(SceneEdit& edit, uint32_t width, const Texels& texels, ColorSpace space = ColorSpace::Linear) {
        Image image{.name = "image", .width = width, .height = uint32_t(texels.size()) / width};
        for (const glm::u8vec3 t : texels) image.texels.insert(image.texels.end(), {t.x, t.y, t.z, 255});
        return {.texture = edit.add(Texture{.name = "texture", .image = edit.add(std::move(image)), .color_space = space})};
    }
    static image::ImageF draw(SceneEdit edit) {
        Stage stage(make_scene(std::move(edit)), {.hardware = false});
        return stage.picture({.view = {.width = 4, .height = 4, .max_bounces = 1, .aovs = {"albedo", "normal", "roughness"}}, .camera = camera_from_above(2.0f, 1.0f), .sample_count = 1});
    }
    static void expect_layer(const image::ImageF& picture, std::initializer_list<const char*> channels, glm::vec3 value, float margin) {
        int c = 0;
        for (const char* channel : channels) {
            for (const float v : picture.plane(picture.find_channel(channel).value())) ASSERT_NEAR(v, value[c], margin) << channel;
            ++c;
        }
    }
    static void expect_albedo(const image::ImageF& picture, glm::vec3 value, float margin = 1e-5f) { expect_layer(picture, {"albedo.R", "albedo.G", "albedo.B"}, value, margin); }
    static void expect_normal(const image::ImageF& picture, glm::vec3 value) { expect_layer(picture, {"normal.X", "normal.Y", "normal.Z"}, value, 1e-5f); }
};

constexpr glm::u8vec3 kRed(255, 0, 0), kGreen(0, 255, 0), kBlue(0, 0, 255), kWhite(255);

}  // namespace

TEST_F(MaterialInputs, a_colour_texture_is_sRGB_and_a_data_texture_linear) {
    for (const ColorSpace space : {ColorSpace::Srgb, ColorSpace::Linear}) {
        SceneEdit edit;
        Material material = builtin::lambert("grey", glm::vec3(1.0f));
        material.base_color_texture = texture(edit, 1, {{64, 128, 192}}, space);
        builtin::add_object(edit, "ground", ground(), edit.add(material));
        const glm::vec3 values = glm::vec3(64, 128, 192) / 255.0f;
        // IEC 61966-2-1.
        const glm::vec3 expected = space == ColorSpace::Linear ? values : glm::pow((values + 0.055f) / 1.055f, glm::vec3(2.4f));
        expect_albedo(draw(std::move(edit)), expected, 2e-3f);
    }
}

TEST_F(MaterialInputs, metal_is_blue_and_roughness_green) {
    SceneEdit edit;
    Material material = builtin::lambert("no metal", glm::vec3(0.5f));
    material.metallic = 1.0f;
    material.roughness = 1.0f;
    material.metal_rough_texture = texture(edit, 1, {{255, 51, 0}});
    builtin::add_object(edit, "ground", ground(), edit.add(material));
    edit.add(Light{.kind = LightKind::Directional,
                   .intensity = std::numbers::pi_v<float>,
                   .place = {.node_from_object = glm::mat4_cast(glm::angleAxis(-0.5f * std::numbers::pi_v<float>, glm::vec3(1, 0, 0)))}});
    const image::ImageF picture = draw(std::move(edit));
    for (const float v : picture.plane(picture.find_channel("roughness").value())) ASSERT_NEAR(v, 0.2f, 1e-5f);
    for (const float v : picture.plane(0)) ASSERT_NEAR(v, 0.5f, 1e-5f) << "Lambert, as no metal has it";
}

TEST_F(MaterialInputs, each_texture_has_its_own_set_of_UVs_and_their_transform) {
    struct Case {
        const char* what;
        uint32_t set;
        glm::vec2 offset, scale;
        float rotation;
        glm::vec3 expected;
    };
    // Red, green over blue, white. UV set 0 is in the middle of red, set 1 of blue.
    const Case cases[] = {
        {"set 0", 0, {0.0f, 0.0f}, {1.0f, 1.0f}, 0.0f, {1, 0, 0}},
        {"set 1", 1, {0.0f, 0.0f}, {1.0f, 1.0f}, 0.0f, {0, 0, 1}},
        {"moved", 0, {0.5f, 0.0f}, {1.0f, 1.0f}, 0.0f, {0, 1, 0}},
        {"scaled", 1, {0.0f, 0.0f}, {3.0f, 1.0f}, 0.0f, {1, 1, 1}},
        // KHR_texture_transform: u' = u cos + v sin, v' = -u sin + v cos; (0.25, 0.75) to (0.75, -0.25).
        {"turned", 1, {0.0f, 0.5f}, {1.0f, 1.0f}, 0.5f * std::numbers::pi_v<float>, {0, 1, 0}},
    };
    for (const Case& c : cases) {
        SCOPED_TRACE(c.what);
        SceneEdit edit;
        Material material = builtin::lambert("squares", glm::vec3(1.0f));
        material.base_color_texture = texture(edit, 2, {kRed, kGreen, kBlue, kWhite});
        material.base_color_texture.uv_set = c.set;
        material.base_color_texture.offset = c.offset;
        material.base_color_texture.scale = c.scale;
        material.base_color_texture.rotation = c.rotation;
        Primitive p = ground();
        p.uv0.assign(p.positions.size(), {0.25f, 0.25f});
        p.uv1.assign(p.positions.size(), {0.25f, 0.75f});
        builtin::add_object(edit, "ground", std::move(p), edit.add(material));
        expect_albedo(draw(std::move(edit)), c.expected);
    }
}

TEST_F(MaterialInputs, vertex_colours_multiply_the_material) {
    SceneEdit edit;
    Primitive p = ground();
    p.colors.assign(p.positions.size(), {1.0f, 0.6f, 0.2f, 1.0f});
    builtin::add_object(edit, "ground", std::move(p), edit.add(builtin::lambert("half", glm::vec3(0.5f))));
    expect_albedo(draw(std::move(edit)), {0.5f, 0.3f, 0.1f});
}

// glTF 2.0, 3.9.4: opaque where alpha is the cutoff or more. Alpha is the material's times the vertex's.
TEST_F(MaterialInputs, a_mask_counts_the_cutoff_itself_and_the_vertices_alpha) {
    for (const float vertex_alpha : {1.0f, 0.0f}) {
        SceneEdit edit;
        Material material = builtin::lambert("mask", glm::vec3(0.5f));
        material.alpha_mode = AlphaMode::Mask;
        material.base_color.a = 0.5f;
        Primitive p = ground();
        p.colors.assign(p.positions.size(), glm::vec4(1.0f, 1.0f, 1.0f, vertex_alpha));
        builtin::add_object(edit, "ground", std::move(p), edit.add(material));
        expect_albedo(draw(std::move(edit)), glm::vec3(0.5f * vertex_alpha));
    }
}

TEST_F(MaterialInputs, an_unlit_surface_has_its_colour_whatever_shines_on_it) {
    SceneEdit edit;
    Material material = builtin::glossy("sign", {0.2f, 0.4f, 0.6f}, 0.5f, 0.3f);
    material.unlit = true;
    builtin::add_object(edit, "ground", ground(), edit.add(material));
    edit.set_environment({.scale = glm::vec3(100.0f)});
    const image::ImageF picture = draw(std::move(edit));
    for (size_t c = 0; c < 3; ++c)
        for (const float v : picture.plane(c)) ASSERT_NEAR(v, 0.2f * float(c + 1), 1e-5f);
}

// A texel's x goes along the tangent, its y along cross(normal, tangent) times the handedness; a mirrored instance is the mirror image.
TEST_F(MaterialInputs, a_normal_map_follows_the_tangent_and_its_handedness) {
    const float kScale = 0.5f;
    const glm::vec2 texel = (glm::vec2(204, 178) / 255.0f * 2.0f - 1.0f) * kScale;
    for (const float handedness : {1.0f, -1.0f})
        for (const float mirror : {1.0f, -1.0f}) {
            SCOPED_TRACE(::testing::Message() << "handedness " << handedness << ", scale of x " << mirror);
            SceneEdit edit;
            Material material = builtin::lambert("bumps", glm::vec3(0.5f));
            material.normal_texture = texture(edit, 1, {{204, 178, 255}});
            material.normal_scale = kScale;
            Primitive p = ground();
            p.tangents.assign(p.positions.size(), {1.0f, 0.0f, 0.0f, handedness});
            const Handle<Instance> object = builtin::add_object(edit, "ground", std::move(p), edit.add(material));
            edit.set_transform(object, glm::scale(glm::mat4(1.0f), {mirror, 1.0f, 1.0f}));
            expect_normal(draw(std::move(edit)), {mirror * texel.x, std::sqrt(1.0f - glm::dot(texel, texel)), -handedness * texel.y});
        }
}

}  // namespace parhelion::testing::material_input_test
