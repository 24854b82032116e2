// A thin lens and a moving camera against their closed forms. The scene is an emissive quad in the dark and paths do not scatter, so
// a pixel's value is the share of lens points (of moments) from which it sees the quad.
#include <cmath>
#include <numbers>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::camera_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kSize = 48;
constexpr float kNits = 8.0f;

class CameraRays : public GpuTest {
protected:
    // A quad that faces a camera at the origin which looks along -Z, its middle at `center`.
    static Scene quad_scene(glm::vec3 center, glm::vec2 half) {
        SceneEdit edit;
        Primitive quad;
        add_quad(quad, center - glm::vec3(half, 0.0f), {2.0f * half.x, 0.0f, 0.0f}, {0.0f, 2.0f * half.y, 0.0f});
        builtin::add_object(edit, "quad", std::move(quad), edit.add(builtin::lambert("quad", glm::vec3(0.0f), glm::vec3(kNits))));
        return make_scene(std::move(edit));
    }
    static Shot shot(const CameraView& camera, uint32_t samples) {
        return {.view = {.width = kSize, .height = kSize, .max_bounces = 0, .filter = PixelFilter::Point}, .camera = camera, .sample_count = samples};
    }
    // The film's point of a pixel's centre in units of the image's half extents, y up.
    static glm::dvec2 film_point(uint32_t x, uint32_t y) { return {(2.0 * x + 1.0) / kSize - 1.0, 1.0 - (2.0 * y + 1.0) / kSize}; }
    static CameraView along_minus_z(float half_angle) { return look_at({0, 0, 0}, {0, 0, -1}, 2.0f * half_angle); }
};

struct Blur {
    const char* name;
    bool orthographic;
    double quad_depth;
};

// From the point P of the focal plane (depth f), lens point L sees the point L (1 - z/f) + P z/f of depth z. So the pixel sees a quad of
// area A about q if L lies in an area A / (1 - z/f)^2 about (q - P z/f) / (1 - z/f): the share A / (pi R^2 (1 - z/f)^2) of the lens
// where that lies inside the lens, none where it lies outside. In the focal plane this is a disk of diameter 2 R |f/z - 1|. An
// orthographic camera's rays are parallel: its P z/f is P.
TEST_F(CameraRays, a_lens_blurs_a_small_light_to_the_circle_of_confusion_evenly) {
    constexpr double kRadius = 0.8, kFocus = 4.0, kExtent = 0.6;  // half of the focal plane's picture
    constexpr double kQuad = 0.1;                                 // half of the root of the quad's share of the lens
    const Blur cases[] = {{"behind the focus", false, 8.0}, {"before the focus", false, 8.0 / 3.0}, {"orthographic", true, 6.0}};
    for (const Blur& blur : cases) {
        const double z = blur.quad_depth, shrink = std::abs(1.0 - z / kFocus), along = blur.orthographic ? 1.0 : z / kFocus;
        const double reach = kQuad * kRadius * std::sqrt(2.0 * kPi), share = 4.0 * kQuad * kQuad;
        CameraView camera = along_minus_z(static_cast<float>(std::atan(kExtent / kFocus)));
        camera.lens_radius = kRadius;
        camera.focus_distance = kFocus;
        camera.orthographic = blur.orthographic;
        camera.half_extents = glm::vec2(kExtent);
        const glm::dvec2 q = glm::dvec2(0.03, -0.05) * along;  // off the middle
        Stage stage(quad_scene(glm::vec3(q, -z), glm::vec2(static_cast<float>(kQuad * kRadius * shrink * std::sqrt(kPi)))));
        const image::ImageF picture = stage.picture(shot(camera, 256));
        std::vector<double> inner, outer;
        double sum = 0.0;
        for (uint32_t y = 0; y < kSize; ++y)
            for (uint32_t x = 0; x < kSize; ++x) {
                const double value = picture.plane(0)[y * kSize + x];
                sum += value;
                const double distance = glm::length((q - kExtent * film_point(x, y) * along) / shrink);
                if (distance > kRadius + reach + 1e-4) {
                    ASSERT_EQ(value, 0.0) << blur.name << ' ' << x << ' ' << y;
                }
                if (distance < kRadius - reach - 1e-4) (distance < 0.5 * kRadius ? inner : outer).push_back(value);
            }
        ASSERT_GT(inner.size(), 100u) << blur.name;
        ASSERT_GT(outer.size(), 100u) << blur.name;
        expect_mean(inner, kNits * share, 0.05, fmt::format("{}: middle of the circle", blur.name));
        expect_mean(outer, kNits * share, 0.05, fmt::format("{}: rim of the circle", blur.name));
        // All light together: the circle's diameter.
        const double pixel = 2.0 * kExtent / kSize, area = sum * pixel * pixel / (kNits * share);
        const double diameter = 2.0 * kRadius * shrink / along;
        EXPECT_NEAR(2.0 * std::sqrt(area / kPi) / diameter, 1.0, 0.01) << blur.name;
    }
}

TEST_F(CameraRays, a_lens_leaves_the_plane_of_focus_sharp) {
    // Its edges lie 4 mm beyond pixel centres, which 2.74 m of the plane to each side put 114 mm apart.
    const float half = 4.0f * std::tan(0.6f);
    const glm::vec2 right_top(33.0f / kSize * half + 0.004f, 31.0f / kSize * half + 0.004f), left_bottom(-37.0f / kSize * half - 0.004f, -31.0f / kSize * half - 0.004f);
    for (const bool orthographic : {false, true}) {
        Stage stage(quad_scene(glm::vec3(0.5f * (right_top + left_bottom), -4.0f), 0.5f * (right_top - left_bottom)));
        CameraView camera = along_minus_z(0.6f);
        camera.orthographic = orthographic;
        camera.half_extents = glm::vec2(half);
        const image::ImageF pinhole = stage.picture(shot(camera, 16));
        camera.lens_radius = 0.3f;
        camera.focus_distance = 4.0f;
        EXPECT_EQ(share_bit_equal(stage.picture(shot(camera, 16)), pinhole), 1.0);
        camera.focus_distance = 5.0f;
        EXPECT_LT(share_bit_equal(stage.picture(shot(camera, 16)), pinhole), 0.95);
    }
}

// A pixel sees the edge x = 0 of a large quad pass once. Its 64 moments are stratified: the share of them after the edge is exact to one.
TEST_F(CameraRays, a_shutter_blurs_an_edge_by_the_share_of_time_that_it_is_seen) {
    const auto expect_ramp = [&](const CameraView& opens, const CameraView& closes, const auto& lit_share, const char* what) {
        Stage stage(quad_scene({50.0f, 0.0f, -4.0f}, {50.0f, 50.0f}));
        Shot one = shot(opens, 64);
        one.camera_at_close = closes;
        const image::ImageF picture = stage.picture(one);
        size_t ramp = 0;
        for (uint32_t y = 0; y < kSize; ++y)
            for (uint32_t x = 0; x < kSize; ++x) {
                const double expected = std::clamp(lit_share(film_point(x, y)), 0.0, 1.0), value = picture.plane(0)[y * kSize + x] / kNits;
                ramp += expected > 0.0 && expected < 1.0;
                ASSERT_LE(std::abs(value - expected), 1.0 / 64 + 1e-5) << what << ' ' << x << ' ' << y;
            }
        EXPECT_GT(ramp, kSize * kSize / 5u) << what;
    };
    const double half = std::tan(0.3);
    CameraView opens = along_minus_z(0.3f), slid = opens, panned = opens, zoomed = opens;
    opens.position.x = slid.position.x = -0.6f;
    slid.position.x = 0.8f;
    // At depth 4 the pixel looks at x = position + 4 half film.x.
    expect_ramp(opens, slid, [&](glm::dvec2 film) { return (0.8 + 4.0 * half * film.x) / 1.4; }, "slide");

    opens.position.x = 0.0f;
    const auto turned = [&](double angle) {  // to the right
        CameraView view = along_minus_z(0.3f);
        view.forward = {float(std::sin(angle)), 0.0f, float(-std::cos(angle))};
        view.right = {float(std::cos(angle)), 0.0f, float(std::sin(angle))};
        return view;
    };
    panned = turned(0.9);
    expect_ramp(turned(-0.5), panned, [&](glm::dvec2 film) { return (0.9 + std::atan(half * film.x)) / 1.4; }, "pan");

    // From the side, where the edge stands at the angle atan(1/4) = 0.245 to the left: it leaves a growing image.
    opens.position.x = zoomed.position.x = 1.0f;
    zoomed.yfov = 2.0f * std::atan(0.05f);
    opens.yfov = 2.0f * std::atan(0.5f);
    // Half extents go evenly from 0.5 to 0.05: lit while 1 + 4 (0.5 - 0.45 t) film.x > 0.
    expect_ramp(opens, zoomed, [&](glm::dvec2 film) { return film.x >= -0.5 ? 1.0 : 1.0 - (0.5 + 0.25 / film.x) / 0.45; }, "zoom");
}

TEST_F(CameraRays, a_shutter_over_a_still_camera_changes_no_bit) {
    const CameraView camera = framing_view(builtin_stage("builtin:cornell").scene.bounds(), 1.0f);
    Shot one{.view = {.width = 16, .height = 16, .max_bounces = 2}, .camera = camera, .sample_count = 8};
    const image::FilmSums still = builtin_stage("builtin:cornell").render(one);
    one.camera_at_close = camera;
    EXPECT_EQ(builtin_stage("builtin:cornell").render(one).limbs, still.limbs);
}

TEST_F(CameraRays, parts_of_a_range_with_lens_and_shutter_add_up_to_the_whole_bit_for_bit) {
    Stage& stage = builtin_stage("builtin:cornell");
    CameraView opens = framing_view(stage.scene.bounds(), 1.0f), closes = opens;
    opens.lens_radius = 0.05f;
    opens.focus_distance = 3.0f;
    closes.position += glm::vec3(0.2f, 0.1f, -0.3f);
    const auto part = [&](uint32_t first, uint32_t count, uint32_t rows) {
        return stage.render({.view = {.width = 16, .height = 16, .max_bounces = 2}, .camera = opens, .camera_at_close = closes, .first_sample = first, .sample_count = count, .slice_rows = rows, .slice_samples = 24});
    };
    const image::FilmSums a = part(0, 64, 5), b = part(64, 64, 16), whole = part(0, 128, 7);
    EXPECT_NE(a.limbs, b.limbs);
    const image::FilmPart parts[] = {{&b, "second"}, {&a, "first"}};
    EXPECT_EQ(image::merge_films(parts).limbs, whole.limbs);
}

TEST_F(CameraRays, every_way_to_trace_has_the_same_rays_with_lens_and_shutter) {
    Stage& stage = builtin_stage("builtin:cornell");
    CameraView opens = framing_view(stage.scene.bounds(), 1.0f), closes = opens;
    opens.lens_radius = 0.05f;
    opens.focus_distance = 3.0f;
    closes.position.x += 0.3f;
    std::optional<image::ImageF> first;
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        Shot one{.way = way, .view = {.width = 32, .height = 32, .max_bounces = 0, .aovs = {"albedo", "normal"}}, .camera = opens, .camera_at_close = closes, .sample_count = 1};
        const image::ImageF picture = stage.picture(one);
        if (!first) first = picture;
        EXPECT_GE(share_bit_equal(picture, *first), 0.998) << gpu::trace_way_name(way);  // a ray may graze an edge
    }
}

}  // namespace
}  // namespace parhelion::testing::camera_test
