// The wavefront draws what the reference draws, with as many rays: on the CPU device to the last bit, elsewhere as closely as two
// ways to trace agree (other compilers may round otherwise in another kernel).
#include <cmath>

#include "support/render_fixture.h"

namespace parhelion::testing::wavefront_equality_test {
namespace {

const std::vector<std::string> kAllAovs{"albedo", "normal", "emission", "roughness", "path.*", "variance", "depth", "ids", "motion"};

struct Pair {
    image::FilmSums expected, found;
    RayCounts expected_rays, rays;
};

class WavefrontPictures : public GpuTest {
protected:
    bool is_cpu() const { return device()->caps().type == gpu::DeviceType::Cpu; }

    static Pair draw(Stage& stage, Shot shot) {
        Pair pair;
        const WavefrontOptions options = shot.wavefront.value_or(WavefrontOptions{});
        shot.wavefront.reset();
        pair.expected = stage.render(shot);
        pair.expected_rays = stage.rays;
        shot.wavefront = options;
        pair.found = stage.render(shot);
        pair.rays = stage.rays;
        return pair;
    }
    // Of the pixels of each channel that is a mean over samples.
    static double least_share_equal(const image::ImageF& a, const image::ImageF& b) {
        double least = 1.0;
        for (size_t c = 0; c < b.channels.size(); ++c) {
            double mean = 0.0;
            for (const float v : b.plane(c)) mean += std::abs(v) / static_cast<double>(b.pixel_count());
            size_t equal = 0;
            for (size_t p = 0; p < b.pixel_count(); ++p) {
                const double x = a.plane(c)[p], y = b.plane(c)[p];
                equal += std::abs(x - y) <= 1e-4 * std::max(std::abs(x), std::abs(y)) + 1e-4 * mean;
            }
            least = std::min(least, static_cast<double>(equal) / static_cast<double>(b.pixel_count()));
        }
        return least;
    }
    // `share`: of pixels that are equal where they need not be to the last bit.
    void expect_equal(Stage& stage, Shot shot, double share, const std::string& what, std::span<const gpu::TraceWay> ways = kWays) {
        for (const gpu::TraceWay way : ways) {
            SCOPED_TRACE(fmt::format("{}, {}", what, gpu::trace_way_name(way)));
            shot.way = device()->caps().supports(way) ? way : gpu::TraceWay::Compute;
            const Pair pair = draw(stage, shot);
            const image::ImageF expected = image::resolve_film(pair.expected), found = image::resolve_film(pair.found);
            EXPECT_GT(mean_rgb(expected), 0.0);
            EXPECT_GT(pair.expected_rays.path, uint64_t{shot.view.width} * shot.view.height);
            if (is_cpu()) {
                EXPECT_EQ(differing_words(pair.found, pair.expected), 0u);
                EXPECT_EQ(pair.rays.path, pair.expected_rays.path);
                EXPECT_EQ(pair.rays.shadow, pair.expected_rays.shadow);
            } else {
                EXPECT_GE(least_share_equal(found, expected), share);
                EXPECT_NEAR(double(pair.rays.path) / double(pair.expected_rays.path), 1.0, 0.01);
                EXPECT_NEAR(double(pair.rays.shadow), double(pair.expected_rays.shadow), 0.01 * double(pair.expected_rays.shadow));
            }
        }
    }
};

class WavefrontEquality : public WavefrontPictures, public ::testing::WithParamInterface<const char*> {
protected:
    Stage& stage() const { return builtin_stage(std::string("builtin:") + GetParam(), {.triangles = 20'000}); }
};

TEST_P(WavefrontEquality, it_draws_the_reference_at_one_bounce) {
    expect_equal(stage(), {.view = {.width = 32, .height = 24, .max_bounces = 1, .aovs = kAllAovs}, .sample_count = 3, .wavefront = WavefrontOptions{.connect = ConnectWhen::EachBounce}}, 0.999, GetParam());
}

TEST_P(WavefrontEquality, it_draws_the_reference_at_full_depth) {
    expect_equal(stage(), {.view = {.width = 32, .height = 24, .aovs = kAllAovs}, .sample_count = 1}, 0.97, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Scenes, WavefrontEquality,
                         ::testing::Values("cornell", "textured", "spheres", "glass", "diorama", "many-lights", "reflections", "furnace", "diffuse-box", "leak-box", "forest"),
                         [](const auto& scene) {
                             std::string name = scene.param;
                             std::erase(name, '-');
                             return name;
                         });

struct Setting {
    const char* name;
    void (*apply)(Shot& shot);
};

CameraView camera_of(const Stage& stage) { return view_of((*stage.scene.cameras().begin()).value, 4.0f / 3.0f); }

// What changes the paths, each alone: in scenes with and without layered materials.
const Setting kSettings[] = {
    {"unlimited bounces", [](Shot& s) { s.view.max_bounces = 0xFFFFFFFFu; }},
    {"three bounces without roulette", [](Shot& s) { s.view.max_bounces = 3, s.view.roulette_start = 100; }},
    {"roulette from the first bounce", [](Shot& s) { s.view.roulette_start = 1; }},
    {"Cranley", [](Shot& s) { s.view.sampler = SamplerKind::Cranley; }},
    {"PCG", [](Shot& s) { s.view.sampler = SamplerKind::Pcg; }},
    {"white noise", [](Shot& s) { s.view.sampler = SamplerKind::White; }},
    {"firefly clamp", [](Shot& s) { s.view.firefly_clamp = 0.5f; }},
    {"light sampling alone", [](Shot& s) { s.view.light_sampling = 1; }},
    {"BSDF sampling alone", [](Shot& s) { s.view.light_sampling = 2; }},
    {"point filter", [](Shot& s) { s.view.filter = PixelFilter::Point; }},
    {"ray cones", [](Shot& s) { s.view.texture_lod = TextureLod::Cone; }},
    {"no compensation, no bent normals", [](Shot& s) { s.view.energy_compensation = s.view.normal_correction = false; }},
    {"integer offsets", [](Shot& s) { s.view.spawn_offset = SpawnOffset::Integer; }},
    {"another seed, over the end of a block", [](Shot& s) { s.view.seed = 77, s.first_sample = 62, s.sample_count = 4; }},
    {"a lens", [](Shot& s) { s.camera->lens_radius = 0.05f, s.camera->focus_distance = 2.0f; }},
    {"a moving shutter", [](Shot& s) { s.camera_at_close = s.camera, s.camera_at_close->position += glm::vec3(0.1f, 0.05f, 0.0f); }},
};

// Each in a way of its own: no setting belongs to one, and all ways are gone through above.
TEST_F(WavefrontPictures, every_setting_draws_the_reference) {
    size_t turn = 0;
    for (const char* scene : {"builtin:textured", "builtin:glass"}) {
        Stage& stage = builtin_stage(scene);
        for (const Setting& setting : kSettings) {
            Shot shot{.view = {.width = 20, .height = 15, .aovs = kAllAovs}, .camera = camera_of(stage), .sample_count = 2};
            setting.apply(shot);
            expect_equal(stage, shot, 0.97, fmt::format("{}: {}", scene, setting.name), {&kWays[turn++ % std::size(kWays)], 1});
        }
    }
}

// The paths of both are the same up to roundings, so the difference of the pictures' means has next to no noise.
TEST_F(WavefrontPictures, means_over_many_samples_are_the_references) {
    for (const char* scene : {"builtin:cornell", "builtin:glass"}) {
        const Pair pair = draw(builtin_stage(scene), {.view = {.width = 24, .height = 24}, .sample_count = 64});
        EXPECT_NEAR(mean_rgb(image::resolve_film(pair.found)) / mean_rgb(image::resolve_film(pair.expected)), 1.0, 1e-3) << scene;
        if (is_cpu()) {
            EXPECT_EQ(differing_words(pair.found, pair.expected), 0u) << scene;
        }
    }
}

// What a ray passes is no vertex: a blended sheet between the camera, a lamp's rays and the ground.
TEST_F(WavefrontPictures, blended_surfaces_let_the_same_samples_pass) {
    SceneEdit edit;
    add_veiled_ground(edit, 4.0f, 1.0f, 0.4f);
    edit.set_environment(Environment{.name = "constant", .scale = glm::vec3(2.0f)});
    Stage stage(make_scene(std::move(edit)));
    expect_equal(stage, {.view = {.width = 20, .height = 20, .aovs = kAllAovs}, .camera = camera_from_above(3.0f, 2.0f), .sample_count = 8}, 0.97, "a veil");
}

}  // namespace
}  // namespace parhelion::testing::wavefront_equality_test
