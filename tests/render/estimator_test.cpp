// Ways to estimate the same light have the same mean: light sampling, BSDF sampling, both by MIS; with and without roulette.
#include <algorithm>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing {
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

}  // namespace
}  // namespace parhelion::testing
