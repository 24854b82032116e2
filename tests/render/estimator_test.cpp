// Ways to estimate the same light have the same mean: light sampling, BSDF sampling, both by MIS; with and without roulette; on plain
// surfaces and on those of layers.
#include <algorithm>
#include <functional>
#include <ostream>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "shared/scene.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::estimator_test {
namespace {

class Estimators : public GpuTest {
protected:
    static constexpr uint32_t kSize = 16, kRuns = 32, kReferenceRuns = 48;

    // A glossy floor, a wall and a block under a large lamp: every estimator sees enough of it.
    static Stage& room() {
        shared_device();
        static Stage stage = [] {
            SceneEdit edit;
            const auto quad = [&](glm::vec3 corner, glm::vec3 u, glm::vec3 v, Material material) {
                Primitive primitive;
                add_quad(primitive, corner, u, v);
                builtin::add_object(edit, material.name, std::move(primitive), edit.add(material));
            };
            Material glossy = builtin::lambert("floor", {0.6f, 0.6f, 0.7f});
            glossy.specular = 1.0f;
            glossy.roughness = 0.4f;
            quad({-1.5f, 0.0f, 1.5f}, {3.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -3.0f}, glossy);
            quad({-1.5f, 0.0f, -1.5f}, {3.0f, 0.0f, 0.0f}, {0.0f, 2.0f, 0.0f}, builtin::lambert("wall", {0.7f, 0.3f, 0.2f}));
            quad({-1.0f, 2.0f, -1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.0f}, builtin::lambert("lamp", glm::vec3(0.5f), {4.0f, 5.0f, 6.0f}));
            Primitive block;
            add_box(block, {-0.3f, 0.0f, -0.3f}, {0.4f, 0.7f, 0.3f});
            builtin::add_object(edit, "block", std::move(block), edit.add(builtin::lambert("block", glm::vec3(0.8f))));
            edit.set_environment({.scale = glm::vec3(0.5f)});
            builtin::add_camera(edit, "front", {0.5f, 1.2f, 4.0f}, {0.0f, 0.8f, 0.0f}, 0.8f);
            return Stage(make_scene(std::move(edit)));
        }();
        return stage;
    }

    static Runs runs(uint32_t light_sampling, uint32_t roulette_start, uint32_t first_seed, uint32_t count) {
        Runs out(kSize, kSize);
        for (uint32_t run = 0; run < count; ++run)
            out.add_run(room()
                            .picture({.view = {.width = kSize, .height = kSize, .seed = first_seed + run, .max_bounces = 5, .roulette_start = roulette_start, .light_sampling = light_sampling},
                                      .sample_count = 32})
                            .plane(1));
        return out;
    }
    // Against MIS with roulette, as the program does it. False alarm: 1e-3 a call by the mean, 1e-3 by the tiles.
    static void expect_same(const Runs& test, double margin) {
        static const Runs reference = runs(0, 2, 1000, kReferenceRuns);
        const Equivalence result = equivalence_test(test, reference, margin);
        EXPECT_TRUE(result.passed) << result.text;
    }
};

TEST_F(Estimators, light_sampling_alone_has_the_mean_of_mis) { expect_same(runs(1, 2, 2000, kRuns), 0.01); }
TEST_F(Estimators, bsdf_sampling_alone_has_the_mean_of_mis) { expect_same(runs(2, 2, 3000, kRuns), 0.02); }
TEST_F(Estimators, no_roulette_has_the_mean_of_roulette) { expect_same(runs(0, 1u << 20, 4000, kRuns), 0.01); }
TEST_F(Estimators, roulette_from_the_first_bounce_has_the_same_mean) { expect_same(runs(0, 1, 5000, kRuns), 0.02); }

// What the camera sees and light samples at the first surface are spared; each of the four later light samples adds at most the limit.
TEST_F(Estimators, a_firefly_clamp_limits_what_comes_after_the_first_scattering) {
    const auto picture = [](float clamp, uint32_t bounces) {
        return room().picture({.view = {.width = kSize, .height = kSize, .max_bounces = bounces, .light_sampling = 1, .firefly_clamp = clamp}, .sample_count = 16});
    };
    constexpr float kClamp = 1e-3f;
    const image::ImageF direct = picture(0.0f, 1), all = picture(0.0f, 5), clamped = picture(kClamp, 5);
    EXPECT_EQ(picture(1e30f, 5).data, all.data);
    double most = 0;
    for (size_t p = 0; p < direct.pixel_count(); ++p) {
        const double spared = direct.plane(1)[p], added = clamped.plane(1)[p] - spared;
        ASSERT_GE(added, -1e-5 * spared) << p;
        ASSERT_LE(added, 4 * double(kClamp) / 0.7152 + 1e-5 * spared) << p;  // green's share of luminance
        most = std::max(most, double(all.plane(1)[p]) - spared);
    }
    EXPECT_GT(most, 0.1);  // there was something to clamp
}

// The same on surfaces of layers and of glass: a ball on a floor under a sky, one half of which is bright.
struct Layered {
    const char* name;
    Material material;
    double margin = 0.015;
    uint32_t light_samples = 32;  // of a run that samples lights alone, whose weights are the wildest
    double light_margin = margin;
};
void PrintTo(const Layered& layered, std::ostream* out) { *out << layered.name; }

Material with(Material material, const std::function<void(Material&)>& change) {
    change(material);
    return material;
}

class LayeredEstimators : public GpuTest, public ::testing::WithParamInterface<Layered> {
protected:
    static constexpr uint32_t kSize = 16, kRuns = 32;

    static Scene room(const Material& material) {
        SceneEdit edit;
        Primitive floor;
        add_quad(floor, {-4.0f, -0.8f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
        builtin::add_object(edit, "floor", std::move(floor), edit.add(builtin::lambert("floor", {0.6f, 0.7f, 0.4f})));
        builtin::add_object(edit, "ball", make_sphere(0.8f, 8, false), edit.add(material));
        Environment sky{.width = 8, .height = 4, .scale = glm::vec3(1.0f)};
        for (uint32_t i = 0; i < 32; ++i) sky.radiance.push_back(glm::vec3(i % 8 < 4 ? 1.5f : 0.5f));
        edit.set_environment(std::move(sky));
        builtin::add_camera(edit, "front", {0.3f, 0.5f, 3.0f}, {0.0f, -0.1f, 0.0f}, 0.5f);
        return make_scene(std::move(edit));
    }
    static Runs runs(Stage& stage, uint32_t light_sampling, uint32_t roulette_start, uint32_t first_seed, uint32_t samples) {
        Runs out(kSize, kSize);
        for (uint32_t run = 0; run < kRuns; ++run)
            out.add_run(stage
                            .picture({.view = {.width = kSize, .height = kSize, .seed = first_seed + run, .max_bounces = 5, .roulette_start = roulette_start, .light_sampling = light_sampling},
                                      .sample_count = samples})
                            .plane(1));
        return out;
    }
};

// Against MIS with roulette. False alarm: 1e-3 a comparison by the mean, 1e-3 by the tiles; three comparisons a material.
TEST_P(LayeredEstimators, every_way_to_sample_has_one_mean_with_and_without_roulette) {
    constexpr uint32_t kNever = 1u << 20;
    Stage stage(room(GetParam().material));
    const Runs mis = runs(stage, 0, 2, 1000, 16);
    ASSERT_NE(stage.scene_gpu.features() & shared::kSceneLayers, 0u);
    const auto expect_same = [&](const Runs& test, double margin, const char* what) {
        const Equivalence result = equivalence_test(test, mis, margin);
        EXPECT_TRUE(result.passed) << what << ": " << result.text;
    };
    expect_same(runs(stage, 1, 2, 2000, GetParam().light_samples), GetParam().light_margin, "light sampling alone");
    expect_same(runs(stage, 2, 2, 3000, 16), GetParam().margin, "BSDF sampling alone");
    expect_same(runs(stage, 0, kNever, 4000, 16), GetParam().margin, "no roulette");
}

const Material kPlain = builtin::glossy("ball", {0.8f, 0.6f, 0.5f}, 0.0f, 0.7f);
INSTANTIATE_TEST_SUITE_P(
    Materials, LayeredEstimators,
    ::testing::Values(
        Layered{"rough_glass", with(kPlain, [](Material& m) { m.transmission = m.thickness = m.attenuation_distance = 1.0f, m.attenuation_color = {0.5f, 0.6f, 0.8f}, m.ior = 1.3f; }), 0.02, 96, 0.03},
        Layered{"thin_rough_glass", with(kPlain, [](Material& m) { m.roughness = 0.6f, m.transmission = 0.8f; }), 0.02},
        Layered{"clear_coat", with(kPlain, [](Material& m) { m.clearcoat = 1.0f, m.clearcoat_roughness = 0.5f; })},
        Layered{"sheen", with(kPlain, [](Material& m) { m.sheen_color = {0.9f, 0.8f, 0.7f}, m.sheen_roughness = 0.4f; })},
        Layered{"coat_over_sheen_over_metal",
                with(kPlain, [](Material& m) { m.metallic = 1.0f, m.clearcoat = 0.8f, m.clearcoat_roughness = 0.6f, m.sheen_color = {0.5f, 0.6f, 0.7f}, m.sheen_roughness = 0.5f; })}),
    [](const auto& given) { return std::string(given.param.name); });

}  // namespace
}  // namespace parhelion::testing::estimator_test
