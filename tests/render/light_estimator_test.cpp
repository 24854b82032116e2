// Light sampling alone, BSDF sampling alone and both by MIS have one mean, for each kind of light that rays can hit; and an emitter
// behind a culled face is the same to camera rays, BSDF rays and shadow rays.
#include <cmath>
#include <functional>
#include <map>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::light_estimator_test {
namespace {

// In all scenes the light falls onto a rough metal floor and a Lambert block.
class LightEstimators : public GpuTest {
protected:
    static constexpr uint32_t kSize = 16, kRuns = 32;

    static void add_room(SceneEdit& edit) {
        const auto quad = [&](const char* name, glm::vec3 corner, glm::vec3 u, glm::vec3 v, Material material) {
            Primitive primitive;
            add_quad(primitive, corner, u, v);
            builtin::add_object(edit, name, std::move(primitive), edit.add(std::move(material)));
        };
        quad("floor", {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f}, builtin::glossy("floor", glm::vec3(0.8f, 0.7f, 0.6f), 1.0f, 0.7f));
        Primitive block;
        add_box(block, {-0.4f, 0.0f, -0.5f}, {0.3f, 0.5f, 0.2f});
        builtin::add_object(edit, "block", std::move(block), edit.add(builtin::lambert("block", glm::vec3(0.7f))));
        builtin::add_camera(edit, "front", {0.5f, 1.6f, 3.6f}, {0.0f, 0.3f, 0.0f}, 0.7f);
    }
    // Against MIS. False alarm: 1e-3 a comparison by the mean, 1e-3 by the tiles; 2 comparisons a call.
    static void expect_same(SceneEdit edit, const std::string& what, uint32_t samples = 16, double margin = 0.03) {
        add_room(edit);
        Stage stage(make_scene(std::move(edit)));
        const auto runs = [&](uint32_t mode, uint32_t count) {
            Runs out(kSize, kSize);
            for (uint32_t run = 0; run < count; ++run)
                out.add_run(stage.picture({.view = {.width = kSize, .height = kSize, .seed = 1000 * (mode + 1) + run, .max_bounces = 2, .light_sampling = mode}, .sample_count = samples}).plane(1));
            return out;
        };
        const Runs mis = runs(0, kRuns);
        for (const uint32_t mode : {1u, 2u}) {
            const Equivalence result = equivalence_test(runs(mode, kRuns), mis, margin);
            EXPECT_TRUE(result.passed) << what << (mode == 1 ? ", light sampling: " : ", BSDF sampling: ") << result.text;
        }
    }
    static Material lamp(bool double_sided) {
        Material material = builtin::lambert("lamp", glm::vec3(0.2f), {5.0f, 6.0f, 7.0f});
        material.double_sided = double_sided;
        return material;
    }
    // 16 x 16 texels, most of them black, with a bilinear filter: what shines reaches into black texels' cells.
    static TextureRef lamps_texture(SceneEdit& edit) {
        Image image{.width = 16, .height = 16};
        for (uint32_t y = 0; y < 16; ++y)
            for (uint32_t x = 0; x < 16; ++x) {
                const bool bright = x % 8 < 4 && y % 8 < 4;
                image.texels.insert(image.texels.end(), {uint8_t(bright ? 255 : 0), uint8_t(bright ? 255 - 16 * x : 0), 0, 255});
            }
        return {.texture = edit.add(Texture{.image = edit.add(std::move(image)), .sampler = {.wrap_u = Wrap::MirroredRepeat}}), .offset = {0.3f, 0.1f}, .scale = {1.7f, 1.2f}, .rotation = 0.4f};
    }
};

}  // namespace

TEST_F(LightEstimators, emissive_meshes_of_one_and_two_sides) {
    for (const bool double_sided : {false, true}) {
        SceneEdit edit;
        builtin::add_object(edit, "lamp", make_torus(1.1f, 0.5f, 12, 8), edit.add(lamp(double_sided)), {.translation = {0.0f, 1.3f, 0.0f}, .scale = {1.0f, 0.6f, 1.0f}});
        expect_same(std::move(edit), double_sided ? "two-sided" : "one-sided");
    }
}

TEST_F(LightEstimators, a_lamp_under_a_clear_coat) {
    SceneEdit edit;
    Material coated = lamp(true);
    coated.clearcoat = 1.0f;
    Primitive quad;  // seen from the floor at grazing angles, where the coat takes most
    add_quad(quad, {-1.5f, 0.1f, -1.2f}, {3.0f, 0.0f, 0.0f}, {0.0f, 1.2f, -0.1f});
    builtin::add_object(edit, "lamp", std::move(quad), edit.add(std::move(coated)));
    expect_same(std::move(edit), "coated");
}

TEST_F(LightEstimators, a_textured_emitter_whose_texels_are_mostly_black) {
    for (const uint32_t steps : {1u, 24u}) {
        SceneEdit edit;
        Material material = lamp(false);
        material.emissive_texture = lamps_texture(edit);
        Primitive quad;
        add_textured_quad(quad, {-1.8f, 1.2f, -1.8f}, {3.6f, 0.0f, 0.0f}, {0.0f, 0.0f, 3.6f}, glm::vec2(1.0f), steps);
        builtin::add_object(edit, "lamp", std::move(quad), edit.add(std::move(material)));
        expect_same(std::move(edit), fmt::format("{} quads", steps * steps), 64);
    }
}

// One mesh, three times: stretched, mirrored, and stretched so that its triangles' shares in the world are others than in its table.
TEST_F(LightEstimators, instances_that_are_stretched_and_mirrored) {
    SceneEdit edit;
    Mesh mesh;
    mesh.primitives.push_back(make_sphere(0.45f, 8, false));
    mesh.primitives[0].material = edit.add(lamp(false));
    const Handle<Mesh> handle = edit.add(std::move(mesh));
    const auto place = [&](glm::vec3 at, glm::vec3 scale) {
        glm::mat4 m(1.0f);
        for (int i = 0; i < 3; ++i) m[i][i] = scale[i];
        m[3] = glm::vec4(at, 1.0f);
        edit.add(Instance{.mesh = handle, .place = {.node_from_object = m}});
    };
    place({-0.9f, 1.2f, 0.0f}, {1.0f, 0.3f, 2.5f});
    place({0.9f, 1.2f, 0.1f}, {-1.5f, 1.0f, 1.0f});
    place({0.0f, 1.4f, 0.5f}, {3.0f, 0.2f, -1.0f});
    expect_same(std::move(edit), "instances");
}

TEST_F(LightEstimators, an_image_environment_and_a_wide_sun) {
    SceneEdit edit;
    Environment e{.width = 24, .height = 11, .scale = glm::vec3(1.0f), .rotation = 1.1f};
    for (uint32_t i = 0; i < 24 * 11; ++i) e.radiance.push_back(i % 7 == 0 ? glm::vec3(6.0f, 3.0f, 2.0f) : glm::vec3(0.3f, 0.5f, 0.9f));
    edit.set_environment(std::move(e));
    edit.add(Light{.kind = LightKind::Directional, .intensity = 3.0f, .angular_radius = 0.5f, .place = {.node_from_object = glm::mat4_cast(glm::angleAxis(-1.1f, glm::normalize(glm::vec3(1.0f, 0.3f, 0.0f))))}});
    expect_same(std::move(edit), "environment and sun", 64);
}

// Alpha of a lamp is a chance to meet it: light sampling must know of it.
TEST_F(LightEstimators, a_translucent_and_a_cut_out_lamp) {
    for (const AlphaMode mode : {AlphaMode::Blend, AlphaMode::Mask}) {
        SceneEdit edit;
        Material material = lamp(true);
        material.alpha_mode = mode;
        material.base_color.a = 0.6f;
        Image image{.width = 2, .height = 1, .texels = {255, 255, 255, 255, 255, 255, 255, 100}};
        material.base_color_texture.texture = edit.add(Texture{.image = edit.add(std::move(image))});
        Primitive quad;
        add_textured_quad(quad, {-1.8f, 1.2f, -1.8f}, {3.6f, 0.0f, 0.0f}, {0.0f, 0.0f, 3.6f});
        builtin::add_object(edit, "lamp", std::move(quad), edit.add(std::move(material)));
        expect_same(std::move(edit), mode == AlphaMode::Blend ? "blend" : "mask", 32);
    }
}

// A single-sided face whose back is culled stands between the ground and the lamp, and one between the camera and both. Neither is there:
// the ground has the light that it has without them, by every estimator, and the camera sees the lamp's nits.
TEST_F(LightEstimators, an_emitter_behind_a_culled_face_is_seen_by_rays_of_every_kind) {
    const auto scene = [](bool faces, bool turned) {
        SceneEdit edit;
        const auto quad = [&](const char* name, glm::vec3 corner, glm::vec3 u, glm::vec3 v, Material material) {
            Primitive primitive;
            add_quad(primitive, corner, u, v);
            builtin::add_object(edit, name, std::move(primitive), edit.add(std::move(material)));
        };
        quad("ground", {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f}, builtin::lambert("ground", glm::vec3(0.5f)));
        quad("lamp", {-1.0f, 2.0f, -1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.0f}, lamp(false));
        const Material face = builtin::lambert("face", glm::vec3(0.5f));
        if (faces && !turned) quad("above the ground", {-3.0f, 1.0f, 3.0f}, {6.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -6.0f}, face);  // its front is up: to the lamp
        if (faces && turned) quad("above the ground", {-3.0f, 1.0f, -3.0f}, {6.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 6.0f}, face);
        return make_scene(std::move(edit));
    };
    Stage free(scene(false, false)), behind(scene(true, false)), before(scene(true, true));
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        for (uint32_t mode = 0; mode < 3; ++mode) {
            Shot shot{.way = way, .view = {.width = 8, .height = 8, .max_bounces = 1, .filter = PixelFilter::Point, .light_sampling = mode}, .camera = camera_from_above(0.5f, 0.5f), .sample_count = 64};
            // The same random numbers meet the same light.
            const image::ImageF expected = free.picture(shot), picture = behind.picture(shot);
            for (size_t i = 0; i < expected.data.size(); ++i) ASSERT_NEAR(picture.data[i], expected.data[i], 1e-5f * expected.data[i]) << gpu::trace_way_name(way) << ' ' << mode;
            EXPECT_GT(mean_rgb(picture), 0.1);
            EXPECT_EQ(mean_rgb(before.picture(shot)), 0.0) << gpu::trace_way_name(way) << ' ' << mode;  // its front stops all of them
            shot.camera = look_at({0.1f, 0.4f, 0.1f}, {0.0f, 2.0f, 0.0f}, 0.3f);
            const image::ImageF seen = behind.picture(shot);
            for (const float v : seen.plane(0)) ASSERT_EQ(v, 5.0f) << gpu::trace_way_name(way) << ' ' << mode;
        }
    }
}

}  // namespace parhelion::testing::light_estimator_test
