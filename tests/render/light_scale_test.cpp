// A million emissive triangles and ten thousand punctual lights: they load, every one is found as often as its share says, and the
// light is what a formula says.
#include <cmath>
#include <ctime>
#include <numbers>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/light_samples.h"
#include "support/statistics.h"

namespace parhelion::testing::light_scale_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kSize = 8;
constexpr float kHalf = 1.0f, kAlbedo = 0.5f;

class LightScale : public GpuTest {
protected:
    static void add_ground(SceneEdit& edit) {
        Primitive ground;
        add_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
        builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(kAlbedo))));
    }
    template <class Irradiance>
    static void expect_light(Stage& stage, uint32_t samples, double margin, Irradiance irradiance) {
        const image::ImageF picture = stage.picture({.view = {.width = kSize, .height = kSize, .max_bounces = 1, .filter = PixelFilter::Point, .light_sampling = 1},
                                                     .camera = camera_from_above(0.05f, kHalf),
                                                     .sample_count = samples});
        std::vector<double> ratios;
        for (uint32_t y = 0; y < kSize; ++y)
            for (uint32_t x = 0; x < kSize; ++x)
                ratios.push_back(double(picture.plane(1)[y * kSize + x]) / (double(kAlbedo) / kPi * irradiance(glm::dvec2(ground_point(x, y, kSize, kHalf)))));
        expect_mean(ratios, 1.0, margin, "light sampling");
    }
    // Alpha 1e-4. In groups of neighbours, so that each expects enough.
    static void expect_picks(const std::vector<double>& share, const std::vector<uint32_t>& picked) {
        constexpr size_t kGroups = 250;
        std::vector<double> expected(kGroups), seen(kGroups);
        for (size_t i = 0; i < share.size(); ++i) expected[i * kGroups / share.size()] += share[i] * double(picked.size());
        for (const uint32_t i : picked) ++seen[size_t(i) * kGroups / share.size()];
        const ChiSquare test = chi_square_test(seen, expected);
        EXPECT_GE(test.p, 1e-4) << test.text;
    }
};

}  // namespace

// A rectangle of 1000 x 500 cells under a texture that is black on its left half; rows of cells grow towards one end.
TEST_F(LightScale, a_million_emissive_triangles) {
    constexpr uint32_t kColumns = 1000, kRows = 500;
    Primitive lamp;
    const auto row_at = [](double t) { return t * (0.4 + 0.6 * t); };  // cells of two and a half to four times the first's length
    for (uint32_t y = 0; y <= kRows; ++y)
        for (uint32_t x = 0; x <= kColumns; ++x) {
            const double u = double(x) / kColumns, v = row_at(double(y) / kRows);
            lamp.positions.emplace_back(-1.2 + 2.4 * u, 1.2, -1.0 + 2.0 * v);
            lamp.uv0.emplace_back(u, v);
        }
    for (uint32_t y = 0; y < kRows; ++y)
        for (uint32_t x = 0; x < kColumns; ++x) {
            const uint32_t i = y * (kColumns + 1) + x, below = i + kColumns + 1;
            lamp.triangles.push_back({i, i + 1, below});
            lamp.triangles.push_back({i + 1, below + 1, below});
        }

    SceneEdit edit;
    add_ground(edit);
    Material material = builtin::lambert("lamp", glm::vec3(0.0f), glm::vec3(10.0f));
    Image image{.width = 2, .height = 1, .texels = {0, 0, 0, 255, 255, 255, 255, 255}};
    material.emissive_texture.texture = edit.add(Texture{.image = edit.add(std::move(image)), .sampler = {.wrap_u = Wrap::ClampToEdge, .wrap_v = Wrap::ClampToEdge, .mag = Filter::Nearest}});
    builtin::add_object(edit, "lamp", std::move(lamp), edit.add(std::move(material)));
    const std::clock_t start = std::clock();
    Stage stage(make_scene(std::move(edit)), {.hardware = false});
    const std::vector<LightResult> samples = sample_lights(stage, 1 << 17, 3);
    const double seconds = double(std::clock() - start) / CLOCKS_PER_SEC;
    RecordProperty("seconds", std::to_string(seconds));
    EXPECT_LT(seconds, 30.0);  // of all cores, our own bottom level included; about 4
    EXPECT_EQ(stage.scene_gpu.stats().emissive_triangles, 1'000'000u);

    // The scene has an order of its own for a mesh's triangles.
    const Primitive* drawn = nullptr;
    for (const auto& [handle, mesh] : stage.scene.meshes())
        if (mesh.triangle_count == 1'000'000) drawn = &mesh.primitives[0];
    ASSERT_NE(drawn, nullptr);
    std::vector<double> share, brightest_u;
    for (const glm::uvec3& t : drawn->triangles) {
        const glm::dvec3 a(drawn->positions[t.x]), b(drawn->positions[t.y]), c(drawn->positions[t.z]);
        brightest_u.push_back(std::max({drawn->uv0[t.x].x, drawn->uv0[t.y].x, drawn->uv0[t.z].x}));
        share.push_back(brightest_u.back() > 0.5001 ? 0.5 * glm::length(glm::cross(b - a, c - a)) / 2.4 : 0.0);
    }
    std::vector<uint32_t> picked;
    for (const LightResult& r : samples) {
        // Cells beside the border, within reach of the filter's rounding, are there too, for what it might be.
        ASSERT_GT(brightest_u[r.triangle], 0.49);
        if (share[r.triangle] == 0) continue;
        picked.push_back(r.triangle);
        ASSERT_NEAR(r.probability, share[r.triangle], 0.01 * share[r.triangle]);
    }
    EXPECT_GT(picked.size(), samples.size() * 99 / 100);
    expect_picks(share, picked);
    expect_light(stage, 8192, 0.004, [](glm::dvec2 p) {
        const auto corner = [](double a, double b) {  // Howell's catalogue, B-3
            const double ra = std::sqrt(1 + a * a), rb = std::sqrt(1 + b * b);
            return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / (2 * kPi);
        };
        double form = 0;
        for (const double x : {0.0, 1.2})
            for (const double z : {-1.0, 1.0}) {
                const double a = (x - p.x) / 1.2, b = (z - p.y) / 1.2;
                form += (x > 0 ? 1.0 : -1.0) * (z > 0 ? 1.0 : -1.0) * std::copysign(1.0, a) * std::copysign(1.0, b) * corner(std::abs(a), std::abs(b));
            }
        return kPi * 10.0 * form;
    });
}

TEST_F(LightScale, ten_thousand_punctual_lights) {
    constexpr uint32_t kSide = 100;
    SceneEdit edit;
    add_ground(edit);
    struct Point {
        glm::dvec3 at;
        double candela;
    };
    std::vector<Point> lights;
    double total = 0;
    for (uint32_t i = 0; i < kSide * kSide; ++i) {
        const Point& light = lights.emplace_back(Point{{(i % kSide + 0.5) / kSide * 3 - 1.5, 1.5, (double(i / kSide) + 0.5) / kSide * 3 - 1.5}, 0.001 * (1 + i % 9)});
        glm::mat4 place(1.0f);
        place[3] = glm::vec4(light.at, 1.0f);
        edit.add(Light{.kind = LightKind::Point, .intensity = float(light.candela), .place = {.node_from_object = place}});
        total += light.candela;
    }
    const std::clock_t start = std::clock();
    Stage stage(make_scene(std::move(edit)), {.hardware = false});
    const std::vector<LightResult> samples = sample_lights(stage, 1 << 17, 4);
    EXPECT_LT(double(std::clock() - start) / CLOCKS_PER_SEC, 5.0);
    EXPECT_EQ(stage.scene_gpu.stats().emitters, kSide * kSide);

    // Emitters stand in the order of the scene's lights, which is that of the edit.
    std::vector<uint32_t> picked;
    std::vector<double> share;
    for (const Point& light : lights) share.push_back(light.candela / total);
    for (const LightResult& r : samples) {
        picked.push_back(r.emitter);
        ASSERT_NEAR(r.probability, share[r.emitter], 1e-4 * share[r.emitter]);
        ASSERT_NEAR(r.target_ws.x, lights[r.emitter].at.x, 1e-6);
    }
    expect_picks(share, picked);
    expect_light(stage, 4096, 0.006, [&](glm::dvec2 p) {
        double lux = 0;
        for (const Point& light : lights) {
            const glm::dvec3 d = light.at - glm::dvec3(p.x, 0, p.y);
            lux += light.candela * d.y / std::pow(glm::length(d), 3);
        }
        return lux;
    });
}

// By flux: area in the world x sides x what the texture shows. What shows nothing is no emitter.
TEST_F(LightScale, emitters_are_picked_by_what_they_really_emit) {
    SceneEdit edit;
    const auto texture = [&](std::vector<uint8_t> texels) {
        Image image{.width = static_cast<uint32_t>(texels.size() / 4), .height = 1, .texels = std::move(texels)};
        return TextureRef{.texture = edit.add(Texture{.image = edit.add(std::move(image)), .sampler = {.wrap_u = Wrap::ClampToEdge, .wrap_v = Wrap::ClampToEdge, .mag = Filter::Nearest}})};
    };
    double next_x = 0;
    const auto add = [&](Material material, glm::vec3 scale) {  // a unit square at x in [next_x, next_x + 1], before it is scaled
        Primitive quad;
        add_textured_quad(quad, {0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f});
        builtin::add_object(edit, "lamp", std::move(quad), edit.add(std::move(material)), {.translation = {float(next_x), 1.0f, 0.0f}, .scale = scale});
        next_x += 10;
    };
    Material plain = builtin::lambert("plain", glm::vec3(0.0f), glm::vec3(10.0f)), two_sided = plain, half = plain, black = plain;
    two_sided.double_sided = true;
    half.emissive_texture = texture({0, 0, 0, 255, 255, 255, 255, 255});
    black.emissive_texture = texture({0, 0, 0, 255});
    add(plain, glm::vec3(1.0f));
    add(plain, {2.0f, 1.0f, 3.0f});
    add(two_sided, glm::vec3(1.0f));
    add(half, glm::vec3(1.0f));
    add(half, {1.0f, 7.0f, 4.0f});
    add(black, glm::vec3(2.0f));
    Stage stage(make_scene(std::move(edit)), {.hardware = false});
    const std::vector<double> flux = {1, 6, 2, 0.5, 2, 0};
    std::vector<double> seen(flux.size()), expected;
    constexpr uint32_t kSamples = 1 << 16;
    for (const LightResult& r : sample_lights(stage, kSamples, 6, {20.0f, 0.0f, 0.5f})) ++seen[size_t(std::lround(r.target_ws.x) / 10)];
    for (const double f : flux) expected.push_back(f / 11.5 * kSamples);
    const ChiSquare test = chi_square_test(seen, expected);  // alpha 1e-4
    EXPECT_GE(test.p, 1e-4) << test.text;
    EXPECT_EQ(stage.scene_gpu.stats().emitters, 5u);
}

// What does not shine takes no samples from what does.
TEST_F(LightScale, one_bright_triangle_among_a_hundred_thousand_black_ones_takes_all_samples) {
    constexpr uint32_t kCells = 224;  // 100352 triangles
    SceneEdit edit;
    Primitive panel;
    add_textured_quad(panel, {-1.0f, 1.2f, -1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.0f}, glm::vec2(1.0f), kCells);
    Material material = builtin::lambert("panel", glm::vec3(0.0f), glm::vec3(10.0f));
    Image image{.width = kCells, .height = kCells, .texels = std::vector<uint8_t>(size_t(4) * kCells * kCells)};
    const size_t bright = 4 * (size_t(100) * kCells + 37);
    for (size_t c = 0; c < 4; ++c) image.texels[bright + c] = 255;
    material.emissive_texture.texture = edit.add(Texture{.image = edit.add(std::move(image))});
    builtin::add_object(edit, "panel", std::move(panel), edit.add(std::move(material)));
    Stage stage(make_scene(std::move(edit)), {.hardware = false});
    // The bilinear filter takes the texel's light to its neighbours' middles: nine cells, and what devices may round.
    double light = 0;
    const std::vector<LightResult> samples = sample_lights(stage, 1 << 14, 5);
    std::vector<double> values;
    for (const LightResult& r : samples) {
        const glm::dvec2 at = (glm::dvec2(r.target_ws.x, r.target_ws.z) + 1.0) / 2.0 * double(kCells);  // cells; the image's rows run against z
        ASSERT_NEAR(at.x, 37.5, 2.1);
        ASSERT_NEAR(at.y, kCells - 100.5, 2.1);
        const double distance = glm::length(glm::dvec3(r.target_ws));
        values.push_back(double(r.radiance.g) / double(r.pdf) * std::pow(distance, 3) / 1.2);  // per solid angle to per area
        light += values.back();
    }
    EXPECT_GT(light, 0.0);
    expect_mean(values, 10.0 * 4.0 / (kCells * kCells), 0.05, "panel");  // nits x square metres of the texel's tent
}

}  // namespace parhelion::testing::light_scale_test
