// Textures by the thousand, exchanged, and read as finely as a pixel sees them.
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::texture_test {
namespace {

class Textures : public GpuTest {
protected:
    static Image plain_image(uint32_t size, glm::u8vec3 color) {
        Image image{.name = "plain", .width = size, .height = size};
        for (uint32_t i = 0; i < size * size; ++i) image.texels.insert(image.texels.end(), {color.x, color.y, color.z, 255});
        return image;
    }
    static Material unlit(Handle<Texture> texture) {
        Material material{.name = "unlit"};
        material.base_color_texture.texture = texture;
        material.unlit = true;
        return material;
    }
    static Texture linear(Handle<Image> image) { return {.name = "texture", .image = image, .color_space = ColorSpace::Linear}; }
    static glm::u8vec3 color_of(uint32_t i) { return {uint8_t(i * 7), uint8_t(i >> 3), uint8_t(255 - i % 251)}; }
};

}  // namespace

TEST_F(Textures, more_than_a_thousand_are_each_in_their_place) {
    constexpr uint32_t kSide = 34;  // 1156 squares, each with a texture of its own
    SceneEdit edit;
    Mesh mesh{.name = "squares"};
    for (uint32_t i = 0; i < kSide * kSide; ++i) {
        Primitive square;
        const glm::vec2 p = ground_point(i % kSide, i / kSide, kSide, 1.0f);
        const float half = 1.0f / kSide;
        add_textured_quad(square, {p.x - half, 0.0f, p.y + half}, {2 * half, 0.0f, 0.0f}, {0.0f, 0.0f, -2 * half});
        square.material = edit.add(unlit(edit.add(linear(edit.add(plain_image(1 + i % 3, color_of(i)))))));
        mesh.primitives.push_back(std::move(square));
    }
    edit.add(Instance{.mesh = edit.add(std::move(mesh))});
    Stage stage(make_scene(std::move(edit)), {.hardware = false});
    const image::ImageF picture = stage.picture({.view = {.width = kSide, .height = kSide, .max_bounces = 1, .filter = PixelFilter::Point}, .camera = camera_from_above(2.0f, 1.0f), .sample_count = 1});
    EXPECT_EQ(stage.scene_gpu.stats().textures, kSide * kSide);
    for (uint32_t i = 0; i < kSide * kSide; ++i)
        for (uint32_t c = 0; c < 3; ++c) ASSERT_NEAR(picture.plane(c)[i], color_of(i)[int(c)] / 255.0f, 1e-6f) << "texture " << i;
}

TEST_F(Textures, a_material_gets_another_texture_and_the_old_one_goes) {
    SceneEdit edit;
    Primitive ground;
    add_textured_quad(ground, {-1.0f, 0.0f, 1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -2.0f});
    Handle<Image> image = edit.add(plain_image(4, {255, 0, 0}));
    Handle<Texture> texture = edit.add(linear(image));
    Handle<Material> material = edit.add(unlit(texture));
    builtin::add_object(edit, "ground", std::move(ground), material);
    Scene scene;
    const ChangeSet made = scene.apply(std::move(edit));
    image = made.resolve(image), texture = made.resolve(texture), material = made.resolve(material);
    Stage stage(std::move(scene));
    const Shot shot{.view = {.width = 4, .height = 4, .max_bounces = 1}, .camera = camera_from_above(2.0f, 0.9f), .sample_count = 1};
    EXPECT_EQ(stage.picture(shot).plane(0)[0], 1.0f);
    SceneEdit exchange;
    exchange.set_material(material, unlit(exchange.add(linear(exchange.add(plain_image(8, {0, 255, 0}))))));
    exchange.remove(texture);
    exchange.remove(image);
    stage.step(std::move(exchange));
    const image::ImageF after = stage.picture(shot);
    EXPECT_EQ(after.plane(0)[0], 0.0f);
    EXPECT_EQ(after.plane(1)[0], 1.0f);
    EXPECT_EQ(stage.scene_gpu.stats().textures, 1u);
}

namespace {

// A plane of black and white squares, a texel each, to the horizon; unlit, so that all noise is that of reading the texture.
Scene checkered_plane() {
    SceneEdit edit;
    Image image{.name = "checker", .width = 64, .height = 64};
    for (uint32_t i = 0; i < 64 * 64; ++i) {
        const uint8_t value = (i % 64 + i / 64) % 2 == 0 ? 255 : 0;
        image.texels.insert(image.texels.end(), {value, value, value, 255});
    }
    Material material{.name = "checker", .unlit = true};
    material.base_color_texture.texture = edit.add(Texture{.name = "checker", .image = edit.add(std::move(image)), .color_space = ColorSpace::Linear});
    Primitive plane;
    add_textured_quad(plane, {-500.0f, 0.0f, 500.0f}, {1000.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1000.0f}, glm::vec2(200.0f));
    builtin::add_object(edit, "plane", std::move(plane), edit.add(std::move(material)));
    builtin::add_camera(edit, "over the plane", {0.0f, 1.0f, 0.0f}, {0.0f, 0.6f, -4.0f}, 0.6f);
    return make_scene(std::move(edit));
}

}  // namespace

// 24 pictures of one sample a pixel. The mean at full resolution has a standard error of 0.26 %, the other's is far smaller: false
// alarms of 1e-5.
TEST_F(Textures, ray_cones_take_the_noise_and_leave_the_mean) {
    Stage stage(checkered_plane(), {.hardware = false});
    constexpr uint32_t kSize = 32, kPictures = 24;
    const auto measure = [&](TextureLod lod, double& mean) {
        std::vector<double> sum(kSize * kSize), squares(kSize * kSize);
        for (uint32_t seed = 0; seed < kPictures; ++seed) {
            const image::ImageF picture = stage.picture({.view = {.width = kSize, .height = kSize, .seed = seed, .max_bounces = 1, .texture_lod = lod}, .sample_count = 1});
            mean += mean_rgb(picture) / kPictures;
            for (size_t p = 0; p < sum.size(); ++p) sum[p] += picture.plane(0)[p], squares[p] += double(picture.plane(0)[p]) * picture.plane(0)[p];
        }
        double variance = 0;
        for (size_t p = 0; p < sum.size(); ++p) variance += (squares[p] - sum[p] * sum[p] / kPictures) / (kPictures - 1);
        return variance / double(sum.size());
    };
    double full_mean = 0, cone_mean = 0;
    const double full = measure(TextureLod::Full, full_mean), cone = measure(TextureLod::Cone, cone_mean);
    EXPECT_GT(full, 0.015);
    EXPECT_LT(cone, full / 10);
    EXPECT_NEAR(cone_mean / full_mean, 1.0, 0.012);
}

}  // namespace parhelion::testing::texture_test
