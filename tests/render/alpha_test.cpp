// Alpha masks have the same holes in every way to trace; what a ray meets of translucent triangles is a function of its key alone.
#include <random>

#include "lib/hash.glsl"

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"
#include "support/trace_rays.h"

namespace parhelion::testing::alpha_test {
namespace {

class AlphaMasks : public GpuTest {
protected:
    static constexpr uint32_t kTexels = 64;
    // A sheet whose mask lets about this share through.
    static Scene sheet(float open) {
        SceneEdit edit;
        std::mt19937 random(3);
        Image noise{.name = "noise", .width = kTexels, .height = kTexels, .texels = std::vector<uint8_t>(size_t(kTexels) * kTexels * 4, 255)};
        for (size_t i = 3; i < noise.texels.size(); i += 4) noise.texels[i] = static_cast<uint8_t>(random() >> 24);
        Material material = builtin::lambert("sheet", glm::vec3(0.5f));
        material.double_sided = true;
        material.alpha_mode = AlphaMode::Mask;
        material.alpha_cutoff = open;
        material.base_color_texture.texture = edit.add(Texture{.image = edit.add(std::move(noise)), .sampler = {.mag = Filter::Nearest, .min = Filter::Nearest}});
        Primitive quad;
        add_textured_quad(quad, {-1.0f, -1.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 2.0f, 0.0f}, glm::vec2(1.0f), 8);
        builtin::add_object(edit, "sheet", std::move(quad), edit.add(std::move(material)));
        return make_scene(std::move(edit));
    }
};

}  // namespace

TEST_F(AlphaMasks, of_six_densities_have_the_same_holes_in_every_way_to_trace) {
    std::mt19937 random(17);
    const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
    std::vector<TestRay> rays;
    for (uint32_t i = 0; i < 20000; ++i) rays.push_back({{1.9f * unit() - 0.95f, 1.9f * unit() - 0.95f, 2.0f}, glm::vec3(0.0f, 0.0f, -1.0f)});
    for (const float open : {0.05f, 0.2f, 0.4f, 0.6f, 0.8f, 0.95f}) {
        Stage stage(sheet(open));
        const std::vector<TestFound> expected = trace_rays(stage, gpu::TraceWay::Compute, rays);
        size_t hits = 0;
        for (const TestFound& f : expected) hits += f.hit();
        EXPECT_NEAR(double(hits) / double(rays.size()), 1.0 - double(open), 0.03);
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            const std::vector<TestFound> found = trace_rays(stage, way, rays);
            size_t same = 0;
            for (size_t i = 0; i < rays.size(); ++i) same += found[i].hit() == expected[i].hit() && found[i].visible_now == !expected[i].hit();
            EXPECT_GE(double(same) / double(rays.size()), 0.9999) << gpu::trace_way_name(way) << ", open " << open;
        }
    }
}

// Eight meshes of two geometries of three triangles, all across one beam of rays, which may ask them in any order and more than once:
// each ray meets the first that its number is for, and is stopped for light exactly if there is one.
TEST_F(AlphaMasks, a_ray_meets_the_first_translucent_triangle_whose_number_says_so_however_often_it_is_asked) {
    constexpr float kAlpha = 0.04f;
    constexpr uint32_t kMeshes = 8, kGeometries = 2, kTriangles = 3, kRays = 8192;
    SceneEdit edit;
    Material veil = builtin::lambert("veil", glm::vec3(0.5f));
    veil.double_sided = true;
    veil.alpha_mode = AlphaMode::Blend;
    veil.base_color.a = kAlpha;
    const Handle<Material> material = edit.add(std::move(veil));
    for (uint32_t m = 0; m < kMeshes; ++m) {
        Mesh mesh;
        for (uint32_t g = 0; g < kGeometries; ++g) {
            Primitive& primitive = mesh.primitives.emplace_back();
            primitive.material = material;
            for (uint32_t t = 0; t < kTriangles; ++t) {
                const float z = -float((m * kGeometries + g) * kTriangles + t);
                primitive.positions.insert(primitive.positions.end(), {{-3.0f, -3.0f, z}, {3.0f, -3.0f, z}, {0.0f, 5.0f, z}});
                primitive.triangles.push_back(glm::uvec3(0, 1, 2) + 3 * t);
            }
        }
        edit.add(Instance{.mesh = edit.add(std::move(mesh))});
    }
    Stage stage(make_scene(std::move(edit)));
    // The ray's index is its key.
    const auto expected = [](uint32_t ray) {
        for (uint32_t m = 0; m < kMeshes; ++m)
            for (uint32_t g = 0; g < kGeometries; ++g)
                for (uint32_t t = 0; t < kTriangles; ++t)
                    if (shared::hash_alpha(ray, m, g, t) < kAlpha) return glm::uvec2(m, t);
        return glm::uvec2(0xFFFFFFFFu);
    };
    const std::vector<TestRay> rays(kRays, {{0.1f, 0.2f, 1.0f}, {0.0f, 0.0f, -1.0f}});
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        const std::vector<TestFound> found = trace_rays(stage, way, rays);
        for (uint32_t i = 0; i < kRays; ++i) {
            const glm::uvec2 first = expected(i);
            ASSERT_EQ(found[i].instance, first.x) << gpu::trace_way_name(way) << ", ray " << i;
            if (found[i].hit()) {
                ASSERT_EQ(found[i].primitive, first.y) << gpu::trace_way_name(way) << ", ray " << i;
            }
            ASSERT_EQ(found[i].visible_now, !found[i].hit()) << gpu::trace_way_name(way) << ", ray " << i;
            ASSERT_EQ(found[i].visible_before, !found[i].hit()) << gpu::trace_way_name(way) << ", ray " << i;
        }
    }
}

// The camera's ray and the ray that leaves the ground cross one black veil under a white sky, each with a chance of its own.
TEST_F(AlphaMasks, the_rays_of_two_bounces_pass_a_veil_independently) {
    constexpr float kAlpha = 0.4f;
    SceneEdit edit;
    add_veiled_ground(edit, 900.0f, 1.0f, kAlpha);
    edit.set_environment({.scale = glm::vec3(1.0f)});
    Stage stage(make_scene(std::move(edit)));
    // BSDF sampling in constant light: nothing but the veil is random.
    const image::ImageF picture = stage.picture({.view = {.width = 32, .height = 32, .max_bounces = 1, .light_sampling = 2}, .camera = camera_from_above(2.0f, 0.5f), .sample_count = 128});
    const auto plane = picture.plane(0);
    expect_mean({plane.begin(), plane.end()}, (1.0 - double(kAlpha)) * (1.0 - double(kAlpha)), 0.02, "crossed twice");
}

}  // namespace parhelion::testing::alpha_test
