// What else the film keeps: path classes, and the first surface's values.
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing {
namespace {

class Aovs : public GpuTest {
protected:
    static std::span<const float> plane(const image::ImageF& picture, const std::string& channel) { return picture.plane(picture.find_channel(channel).value()); }
};

TEST_F(Aovs, path_classes_sum_to_the_beauty) {
    for (const char* scene : {"builtin:cornell", "builtin:textured", "builtin:spheres"}) {
        const image::ImageF picture = builtin_picture(scene, {.view = {.width = 32, .height = 32, .aovs = {"path.*"}}, .sample_count = 8});
        for (const char* c : {"R", "G", "B"})
            for (size_t p = 0; p < picture.pixel_count(); ++p) {
                double sum = 0;
                for (const char* group : {"emission", "direct_diffuse", "direct_specular", "indirect_diffuse", "indirect_specular", "transmission"})
                    sum += plane(picture, fmt::format("path.{}.{}", group, c))[p];
                ASSERT_NEAR(plane(picture, c)[p], sum, 1e-5 * sum + 1e-7) << scene << ' ' << p;
            }
        const auto total = [&](const char* channel) {
            double sum = 0;
            for (const float v : plane(picture, channel)) sum += v;
            return sum;
        };
        EXPECT_GT(total("path.direct_diffuse.G"), 0.0) << scene;
        EXPECT_GT(total("path.indirect_diffuse.G"), 0.0) << scene;
        if (scene != std::string("builtin:cornell")) {
            EXPECT_GT(total("path.direct_specular.G"), 0.0) << scene;
        }
        EXPECT_EQ(total("path.transmission.G"), 0.0) << scene;
    }
}

TEST_F(Aovs, asking_for_more_does_not_change_the_beauty) {
    const Shot plain{.sample_count = 4}, all{.view = {.width = 32, .height = 32, .aovs = {"path.*", "albedo", "normal", "emission", "roughness"}}, .sample_count = 4};
    const image::FilmSums &a = builtin_film("builtin:textured", plain), &b = builtin_film("builtin:textured", all);
    EXPECT_EQ(a.limbs, std::vector<uint32_t>(b.limbs.begin(), b.limbs.begin() + static_cast<ptrdiff_t>(a.limbs.size())));
}

TEST_F(Aovs, one_bounce_has_no_indirect_light) {
    const image::ImageF picture = builtin_picture("builtin:textured", {.view = {.width = 32, .height = 32, .max_bounces = 1, .aovs = {"path.*"}}, .sample_count = 4});
    for (const char* channel : {"path.indirect_diffuse.R", "path.indirect_specular.R"})
        for (const float v : plane(picture, channel)) ASSERT_EQ(v, 0.0f);
}

TEST_F(Aovs, the_first_surface_is_the_material_as_it_is) {
    SceneEdit edit;
    Material material = builtin::lambert("all", {0.25f, 0.5f, 0.75f}, {1.0f, 2.0f, 3.0f});
    material.roughness = 0.375f;
    Primitive ground;
    add_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    builtin::add_object(edit, "ground", std::move(ground), edit.add(material));
    Stage stage(make_scene(std::move(edit)));
    const image::ImageF picture =
        stage.picture({.view = {.width = 16, .height = 16, .aovs = {"albedo", "normal", "roughness", "emission"}}, .camera = camera_from_above(2.0f, 1.0f), .sample_count = 3});
    const std::pair<const char*, float> expected[] = {{"albedo.R", 0.25f}, {"albedo.G", 0.5f}, {"albedo.B", 0.75f}, {"normal.X", 0.0f}, {"normal.Y", 1.0f}, {"normal.Z", 0.0f},
                                                      {"roughness", 0.375f}, {"emission.R", 1.0f}, {"emission.G", 2.0f}, {"emission.B", 3.0f}};
    for (const auto& [channel, value] : expected)
        for (const float v : plane(picture, channel)) ASSERT_NEAR(v, value, 1e-6f) << channel;
}

TEST_F(Aovs, normals_are_unit_and_face_the_camera) {
    const image::ImageF picture = builtin_picture("builtin:cornell", {.view = {.width = 32, .height = 32, .filter = PixelFilter::Point, .aovs = {"normal"}}, .sample_count = 1});
    uint32_t surfaces = 0;
    for (size_t p = 0; p < picture.pixel_count(); ++p) {
        const glm::vec3 n(plane(picture, "normal.X")[p], plane(picture, "normal.Y")[p], plane(picture, "normal.Z")[p]);
        if (n == glm::vec3(0.0f)) continue;  // sky
        ++surfaces;
        ASSERT_NEAR(glm::length(n), 1.0f, 1e-5f) << p;
    }
    EXPECT_GT(surfaces, picture.pixel_count() / 2);
}

}  // namespace
}  // namespace parhelion::testing
