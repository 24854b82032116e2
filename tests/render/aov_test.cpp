// What else the film keeps: path classes, and the first surface's values.
#include <array>
#include <bit>
#include <cmath>
#include <set>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::aov_test {
namespace {

class Aovs : public GpuTest {
protected:
    static std::span<const float> plane(const image::ImageF& picture, const std::string& channel) { return picture.plane(picture.find_channel(channel).value()); }
};

constexpr std::array<std::string_view, 6> kClasses = {"emission", "direct_diffuse", "direct_specular", "indirect_diffuse", "indirect_specular", "transmission"};

// A built-in scene with all classes of paths that must occur in it; the others must not.
struct SceneClasses {
    const char* scene;
    std::set<std::string_view> classes;
};
const SceneClasses kSceneClasses[] = {
    {"builtin:cornell", {"emission", "direct_diffuse", "indirect_diffuse"}},
    {"builtin:furnace", {"emission", "direct_diffuse"}},
    {"builtin:textured", {"emission", "direct_diffuse", "direct_specular", "indirect_diffuse", "indirect_specular"}},
    {"builtin:spheres", {"emission", "direct_diffuse", "direct_specular", "indirect_diffuse", "indirect_specular"}},
    {"builtin:reflections", {"direct_diffuse", "direct_specular", "indirect_diffuse", "indirect_specular"}},
    {"builtin:glass", {"direct_diffuse", "direct_specular", "indirect_diffuse", "indirect_specular", "transmission"}},
};

TEST_F(Aovs, path_classes_sum_to_the_beauty) {
    for (const SceneClasses& expected : kSceneClasses) {
        const image::ImageF picture = builtin_picture(expected.scene, {.view = {.width = 32, .height = 32, .aovs = {"path.*"}}, .sample_count = 8});
        std::set<std::string_view> found;
        for (const char* c : {"R", "G", "B"})
            for (size_t p = 0; p < picture.pixel_count(); ++p) {
                double sum = 0;
                for (const std::string_view name : kClasses) {
                    const float value = plane(picture, fmt::format("path.{}.{}", name, c))[p];
                    if (value != 0.0f) found.insert(name);
                    sum += value;
                }
                ASSERT_NEAR(plane(picture, c)[p], sum, 1e-5 * sum + 1e-7) << expected.scene << ' ' << p;
            }
        EXPECT_EQ(found, expected.classes) << expected.scene;
    }
}

TEST_F(Aovs, more_than_a_film_holds_is_refused_before_memory_is_asked_for) {
    try {
        View view(device(), {.width = 32768, .height = 32768, .aovs = {"path.*"}});
        ADD_FAILURE() << "there is a film";
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Usage);
        EXPECT_NE(error.line.find("32768x32768 pixels with 21 channels is more than a film holds"), std::string::npos) << error.line;
    }
}

// The estimate of one run is right on average: its mean over pixels and runs against the spread of the runs themselves. Four samples
// each, so that N for N - 1 would be a quarter too little. A right estimate fails by chance with p < 1e-4 (expect_mean).
TEST_F(Aovs, variance_is_that_of_independent_runs) {
    constexpr uint32_t kRuns = 64, kSize = 16, kSamples = 4;
    Stage& stage = builtin_stage("builtin:textured");
    std::vector<std::vector<double>> means(size_t{kSize} * kSize);
    std::vector<double> estimates(means.size());
    for (uint32_t run = 0; run < kRuns; ++run) {
        const image::ImageF picture = stage.picture({.view = {.width = kSize, .height = kSize, .seed = run, .max_bounces = 2, .sampler = SamplerKind::Pcg, .aovs = {"variance"}}, .sample_count = kSamples});
        ASSERT_EQ(picture.exact.at(1).channel, "variance.G");
        for (size_t p = 0; p < means.size(); ++p) {
            means[p].push_back(plane(picture, "G")[p]);
            estimates[p] += std::bit_cast<float>(picture.exact[1].words[p]) / double(kRuns);
        }
    }
    double spread = 0;
    for (const std::vector<double>& values : means) spread += moments(values).variance / static_cast<double>(means.size());
    std::vector<double> ratios;
    for (size_t p = 0; p < means.size(); ++p) ratios.push_back(1 + (estimates[p] - moments(means[p]).variance) / spread);
    expect_mean(ratios, 1.0, 0.2, "estimated over true variance");
}

// Pixels that a lamp covers in part: a share of the samples sees all of it, the others nothing, so that the mean alone tells the
// variance. Two channels are so bright that their squares go to the sum of large ones.
TEST_F(Aovs, variance_of_a_lamps_edge_follows_from_its_mean) {
    SceneEdit edit;
    const glm::vec3 emission(1e3f, 100.0f, 2e9f);
    Primitive lamp;
    add_quad(lamp, {-4.0f, 0.0f, 4.0f}, {4.1f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    builtin::add_object(edit, "lamp", std::move(lamp), edit.add(builtin::lambert("lamp", glm::vec3(0.0f), emission)));
    Stage stage(make_scene(std::move(edit)));
    constexpr uint32_t kSamples = 96;
    const image::ImageF picture = stage.picture({.view = {.width = 3, .height = 3, .max_bounces = 0, .aovs = {"variance"}}, .camera = camera_from_above(2.0f, 1.0f), .sample_count = kSamples});
    for (size_t c = 0; c < 3; ++c)
        for (size_t p = 0; p < picture.pixel_count(); ++p) {
            const double share = picture.plane(c)[p] / emission[static_cast<int>(c)], scale = emission[static_cast<int>(c)];
            ASSERT_NEAR(share, p % 3 == 0 ? 1.0 : p % 3 == 1 ? 0.65 : 0.0, p % 3 == 1 ? 0.2 : 1e-6) << p;
            const double expected = share * (1 - share) / (kSamples - 1) * scale * scale;
            ASSERT_NEAR(std::bit_cast<float>(picture.exact.at(c).words[p]), expected, 1e-5 * expected + 1e-8 * scale * scale) << c << ' ' << p;
        }
}

TEST_F(Aovs, asking_for_more_does_not_change_the_beauty) {
    const Shot plain{.sample_count = 4}, all{.view = {.width = 32, .height = 32, .aovs = {"path.*", "albedo", "normal", "emission", "roughness", "variance", "depth", "ids", "motion"}}, .sample_count = 4};
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
}  // namespace parhelion::testing::aov_test
