// Pictures whose every pixel has a formula.
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::closed_form_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kSize = 16, kUnlimited = 0xFFFFFFFFu, kNoRoulette = 1u << 20;
constexpr float kHalf = 1.0f;                 // half extent of the picture on the ground, metres
constexpr glm::vec3 kAlbedo(0.8f, 0.5f, 0.2f);

class ClosedForm : public GpuTest {
protected:
    static void add_ground(SceneEdit& edit) {
        Primitive ground;
        add_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
        builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", kAlbedo)));
    }
    static Shot from_above(uint32_t samples) {
        return {.view = {.width = kSize, .height = kSize, .max_bounces = 1, .filter = PixelFilter::Point}, .camera = camera_from_above(5.0f, kHalf), .sample_count = samples};
    }
    // A light without extent has no noise: every pixel is albedo / pi x irradiance(point on the ground).
    template <class Irradiance>
    static void expect_irradiance(Light light, const glm::mat4& place, Irradiance irradiance) {
        SceneEdit edit;
        add_ground(edit);
        light.place.node_from_object = place;
        edit.add(std::move(light));
        Stage stage(make_scene(std::move(edit)));
        const image::ImageF picture = stage.picture(from_above(1));
        for (uint32_t y = 0; y < kSize; ++y)
            for (uint32_t x = 0; x < kSize; ++x)
                for (size_t c = 0; c < 3; ++c) {
                    const double expected = double(kAlbedo[int(c)]) / kPi * irradiance(glm::dvec3(ground_point(x, y, kSize, kHalf).x, 0.0, ground_point(x, y, kSize, kHalf).y));
                    ASSERT_NEAR(picture.plane(c)[y * kSize + x], expected, 2e-5 * expected + 1e-6) << x << ' ' << y << ' ' << c;
                }
    }
    static glm::mat4 looking_down_from(glm::vec3 position, float tilt) {  // -Z turned to -Y, then tilted about Z
        glm::mat4 m = glm::mat4_cast(glm::angleAxis(tilt, glm::vec3(0, 0, 1)) * glm::angleAxis(-float(kPi) / 2, glm::vec3(1, 0, 0)));
        m[3] = glm::vec4(position, 1.0f);
        return m;
    }
    static std::vector<double> values(const image::ImageF& picture, size_t channel) {
        const auto plane = picture.plane(channel);
        return {plane.begin(), plane.end()};
    }
};

// Differential element to a parallel rectangle above it with one corner on the element's normal (Howell's catalogue, B-3).
double corner_form_factor(double a, double b) {
    const double ra = std::sqrt(1 + a * a), rb = std::sqrt(1 + b * b);
    return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / (2 * kPi);
}

// A texture whose every texel is this one.
TextureRef add_plain_texture(SceneEdit& edit, glm::u8vec4 texel, ColorSpace space) {
    const Handle<Image> image = edit.add(Image{.width = 1, .height = 1, .texels = {texel.r, texel.g, texel.b, texel.a}});
    return {.texture = edit.add(Texture{.image = image, .color_space = space})};
}

double schlick(double f0, double f90, double cosine) { return f0 + (f90 - f0) * std::pow(1 - cosine, 5); }

// GGX with height-correlated Smith masking over 4 cos_i cos_o (Heitz 2014, 71 to 72 and 99), for directions in one plane.
double ggx(double cos_i, double cos_o, double cos_h, double alpha) {
    const auto lambda = [&](double c) { return 0.5 * (std::sqrt(1 + alpha * alpha * (1 / (c * c) - 1)) - 1); };
    const double d = (alpha * alpha - 1) * cos_h * cos_h + 1;
    return alpha * alpha / (kPi * d * d) / ((1 + lambda(cos_i) + lambda(cos_o)) * 4 * cos_i * cos_o);
}

// What such a surface reflects of light from this cosine, all directions together.
double specular_albedo(double f0, double f90, double cos_o, double alpha) {
    constexpr int kSteps = 300;
    const double sin_o = std::sqrt(1 - cos_o * cos_o);
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const double cos_i = (i + 0.5) / kSteps, sin_i = std::sqrt(1 - cos_i * cos_i), phi = kPi * (j + 0.5) / kSteps;
            const glm::dvec3 wo(sin_o, 0, cos_o), wi(sin_i * std::cos(phi), sin_i * std::sin(phi), cos_i), h = glm::normalize(wo + wi);
            sum += schlick(f0, f90, glm::dot(wi, h)) * ggx(cos_i, cos_o, h.z, alpha) * cos_i;
        }
    return sum * 2 * kPi / (double(kSteps) * kSteps);
}

}  // namespace

TEST_F(ClosedForm, in_a_diffuse_box_each_bounce_adds_a_power_of_the_albedo) {
    const BuiltinOptions box{.albedo = kAlbedo, .emission = glm::vec3(3.0f)};
    for (const uint32_t bounces : {0u, 1u, 2u, 5u}) {
        // BSDF sampling of a Lambert surface has constant weight: there is no noise.
        const image::ImageF picture = builtin_picture(
            "builtin:diffuse-box", {.view = {.width = kSize, .height = kSize, .max_bounces = bounces, .roulette_start = kNoRoulette, .light_sampling = 2}, .sample_count = 2}, box);
        for (size_t c = 0; c < 3; ++c) {
            const double rho = kAlbedo[int(c)], expected = 3.0 * (1 - std::pow(rho, bounces + 1)) / (1 - rho);
            for (const float v : picture.plane(c)) ASSERT_NEAR(v, expected, 1e-5 * expected) << bounces << " bounces, channel " << c;
        }
    }
}

// What a contribution has too much of luminance is dimmed, its colour kept; what the camera sees is left alone, and direct light.
TEST_F(ClosedForm, the_firefly_clamp_dims_what_comes_after_the_first_scattering) {
    const BuiltinOptions box{.albedo = kAlbedo, .emission = glm::vec3(3.0f)};
    const image::ImageF picture = builtin_picture(
        "builtin:diffuse-box", {.view = {.width = kSize, .height = kSize, .max_bounces = 2, .roulette_start = kNoRoulette, .light_sampling = 2, .firefly_clamp = 1.0f}, .sample_count = 2}, box);
    const glm::dvec3 rho(kAlbedo), first = 3.0 * rho, second = 3.0 * rho * rho, rec709(0.2126, 0.7152, 0.0722);
    ASSERT_GT(glm::dot(first, rec709), 1.0);
    ASSERT_LT(glm::dot(second, rec709), 1.0);
    for (size_t c = 0; c < 3; ++c)
        for (const float v : picture.plane(c)) ASSERT_NEAR(v, 3.0 + first[int(c)] / glm::dot(first, rec709) + second[int(c)], 1e-4) << "channel " << c;
}

// Shading normals lean so far that they face a lamp below the surface: neither light nor BSDF samples reach it.
TEST_F(ClosedForm, no_light_from_below_a_surface_whatever_its_shading_normal) {
    SceneEdit edit;
    Primitive ground, lamp;
    add_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    ground.normals.assign(ground.positions.size(), glm::normalize(glm::vec3(0.8f, 0.6f, 0.0f)));
    add_quad(lamp, {-4.0f, -0.5f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", kAlbedo)));
    builtin::add_object(edit, "lamp", std::move(lamp), edit.add(builtin::lambert("lamp", glm::vec3(0.0f), glm::vec3(5.0f))));
    Stage stage(make_scene(std::move(edit)));
    for (const uint32_t light_sampling : {0u, 1u, 2u}) {
        Shot shot = from_above(16);
        shot.view.light_sampling = light_sampling;
        for (const float v : stage.picture(shot).data) ASSERT_EQ(v, 0.0f) << "light sampling " << light_sampling;
    }
}

TEST_F(ClosedForm, a_diffuse_box_has_the_series_as_its_limit) {
    const BuiltinOptions box{.albedo = kAlbedo, .emission = glm::vec3(3.0f)};
    for (const uint32_t light_sampling : {0u, 2u}) {
        const image::ImageF picture = builtin_picture(
            "builtin:diffuse-box", {.view = {.width = 32, .height = 32, .max_bounces = kUnlimited, .light_sampling = light_sampling}, .sample_count = 64}, box);
        expect_sane(picture);
        for (size_t c = 0; c < 3; ++c) expect_mean(values(picture, c), 3.0 / (1 - double(kAlbedo[int(c)])), 0.025, fmt::format("channel {}, light sampling {}", c, light_sampling));
    }
}

TEST_F(ClosedForm, a_white_sphere_vanishes_in_white_light) {
    const BuiltinOptions white{.albedo = glm::vec3(1.0f), .emission = glm::vec3(1.0f)};
    const image::ImageF exact = builtin_picture("builtin:furnace", {.view = {.width = kSize, .height = kSize, .light_sampling = 2}, .sample_count = 4}, white);
    for (const float v : exact.data) ASSERT_NEAR(v, 1.0f, 1e-5f);
    for (const uint32_t light_sampling : {0u, 1u}) {
        const image::ImageF picture = builtin_picture("builtin:furnace", {.view = {.width = 32, .height = 32, .light_sampling = light_sampling}, .sample_count = 128}, white);
        for (size_t c = 0; c < 3; ++c) expect_mean(values(picture, c), 1.0, 0.0025, fmt::format("light sampling {}", light_sampling));
    }
}

TEST_F(ClosedForm, a_rough_metal_sphere_gains_no_light) {
    const BuiltinOptions metal{.albedo = glm::vec3(1.0f), .emission = glm::vec3(1.0f), .roughness = 0.5f, .metallic = 1.0f};
    const image::ImageF picture = builtin_picture("builtin:furnace", {.sample_count = 64}, metal);
    EXPECT_LE(mean_rgb(picture), 1.002);
    EXPECT_GE(mean_rgb(picture), 0.95);
}

TEST_F(ClosedForm, a_rectangle_lights_a_plane_by_its_form_factor) {
    constexpr float kHeight = 1.5f, kHalfX = 0.5f, kHalfZ = 0.8f, kNits = 10.0f;
    SceneEdit edit;
    add_ground(edit);
    Primitive lamp;  // shines down; the camera looks through its back
    add_quad(lamp, {-kHalfX, kHeight, -kHalfZ}, {2 * kHalfX, 0.0f, 0.0f}, {0.0f, 0.0f, 2 * kHalfZ});
    builtin::add_object(edit, "lamp", std::move(lamp), edit.add(builtin::lambert("lamp", glm::vec3(0.0f), glm::vec3(kNits))));
    Stage stage(make_scene(std::move(edit)));
    for (const uint32_t light_sampling : {0u, 1u, 2u}) {
        Shot shot = from_above(256);
        shot.view.light_sampling = light_sampling;
        const image::ImageF picture = stage.picture(shot);
        std::vector<double> ratios;
        for (uint32_t y = 0; y < kSize; ++y)
            for (uint32_t x = 0; x < kSize; ++x) {
                const glm::dvec2 p(ground_point(x, y, kSize, kHalf));
                double form = 0;  // four corners' rectangles, with sign
                for (const double sx : {-1.0, 1.0})
                    for (const double sz : {-1.0, 1.0}) {
                        const double a = sx * (sx * double(kHalfX) - p.x) / double(kHeight), b = sz * (sz * double(kHalfZ) - p.y) / double(kHeight);
                        form += std::copysign(1.0, a) * std::copysign(1.0, b) * corner_form_factor(std::abs(a), std::abs(b));
                    }
                ratios.push_back(picture.plane(0)[y * kSize + x] / (double(kAlbedo.x) * double(kNits) * form));
                EXPECT_NEAR(ratios.back(), 1.0, light_sampling == 2 ? 0.5 : 0.12) << x << ' ' << y;
            }
        expect_mean(ratios, 1.0, light_sampling == 2 ? 0.03 : 0.004, fmt::format("light sampling {}", light_sampling));
    }
}

TEST_F(ClosedForm, a_point_light_falls_off_by_the_square) {
    const glm::dvec3 at(0.3, 1.2, -0.2);
    expect_irradiance({.kind = LightKind::Point, .intensity = 7.0f}, looking_down_from(glm::vec3(at), 0.0f), [&](glm::dvec3 p) {
        const glm::dvec3 d = at - p;
        return 7.0 * d.y / std::pow(glm::length(d), 3);
    });
}

TEST_F(ClosedForm, a_spot_light_has_the_cone_of_its_definition) {
    const glm::dvec3 at(0.1, 1.0, 0.2), axis(std::sin(0.2), -std::cos(0.2), 0.0);
    expect_irradiance({.kind = LightKind::Spot, .intensity = 7.0f, .inner_cone = 0.2f, .outer_cone = 0.6f}, looking_down_from(glm::vec3(at), 0.2f), [&](glm::dvec3 p) {
        const glm::dvec3 d = at - p;
        const double cosine = -glm::dot(axis, glm::normalize(d));
        const double fall = glm::clamp((cosine - std::cos(0.6)) / (std::cos(0.2) - std::cos(0.6)), 0.0, 1.0);
        return 7.0 * fall * fall * d.y / std::pow(glm::length(d), 3);
    });
}

TEST_F(ClosedForm, a_directional_light_gives_its_lux_times_the_cosine) {
    expect_irradiance({.kind = LightKind::Directional, .intensity = 7.0f}, looking_down_from({}, 0.7f), [](glm::dvec3) { return 7.0 * std::cos(0.7); });
}

// A disk at infinity lights like a ray from its middle: the mean cosine over it is the middle's.
TEST_F(ClosedForm, a_sun_gives_its_lux_times_the_cosine_however_it_is_sampled) {
    constexpr float kTilt = 0.5f;
    SceneEdit edit;
    add_ground(edit);
    edit.add(Light{.kind = LightKind::Directional, .intensity = 7.0f, .angular_radius = 0.3f, .place = {.node_from_object = looking_down_from({}, kTilt)}});
    Stage stage(make_scene(std::move(edit)));
    for (const uint32_t light_sampling : {0u, 1u, 2u}) {
        Shot shot = from_above(256);
        shot.view.light_sampling = light_sampling;
        std::vector<double> ratios;
        for (const double v : values(stage.picture(shot), 2)) ratios.push_back(v / (double(kAlbedo.z) / kPi * 7.0 * std::cos(double(kTilt))));
        expect_mean(ratios, 1.0, light_sampling == 2 ? 0.04 : 0.004, fmt::format("light sampling {}", light_sampling));
    }
}

// The real sun's size: light sampling has next to no noise, and its disk is where it should be.
TEST_F(ClosedForm, a_sun_of_half_a_degree_is_seen_with_its_radiance_and_edge) {
    constexpr float kRadius = 0.004625f, kTilt = 0.6f;
    SceneEdit edit;
    add_ground(edit);
    edit.add(Light{.kind = LightKind::Directional, .intensity = 9e4f, .angular_radius = kRadius, .place = {.node_from_object = looking_down_from({}, kTilt)}});
    Stage stage(make_scene(std::move(edit)));
    for (const double v : values(stage.picture(from_above(16)), 0)) ASSERT_NEAR(v, double(kAlbedo.x) / kPi * 9e4 * std::cos(double(kTilt)), 50.0);

    const glm::vec3 to_sun(-std::sin(kTilt), std::cos(kTilt), 0.0f);
    const Shot at_sun{.view = {.width = 33, .height = 33, .filter = PixelFilter::Point}, .camera = look_at({0.0f, 1.0f, 0.0f}, glm::vec3(0.0f, 1.0f, 0.0f) + to_sun, 4.0f * kRadius), .sample_count = 1};
    const image::ImageF picture = stage.picture(at_sun);
    const double nits = 9e4 / (kPi * std::pow(std::sin(double(kRadius)), 2));
    for (uint32_t y = 0; y < 33; ++y)
        for (uint32_t x = 0; x < 33; ++x) {
            const double away = std::hypot(x - 16.0, y - 16.0) / 16.5 * 2;  // in radii of the disk
            const double v = picture.plane(1)[y * 33 + x];
            if (away < 0.98) { EXPECT_NEAR(v, nits, 1e-4 * nits) << x << ' ' << y; }
            if (away > 1.02) { EXPECT_EQ(v, 0.0) << x << ' ' << y; }
        }
}

// KHR_materials_specular: colour and strength, each factor x texture, on a surface that is a quarter metal, lit from 60 degrees. The
// blue of the colour would reflect more than everything and ends at 1.
TEST_F(ClosedForm, a_coloured_specular_surface_reflects_by_its_definition) {
    SceneEdit edit;
    Material material{.base_color = glm::vec4(kAlbedo, 1.0f), .metallic = 0.25f, .roughness = 0.7f, .ior = 3.0f, .specular = 0.8f, .specular_color = {0.5f, 1.0f, 9.0f}};
    material.occlusion_texture = add_plain_texture(edit, {0, 0, 0, 0}, ColorSpace::Linear);
    material.specular_texture = add_plain_texture(edit, {0, 0, 0, 128}, ColorSpace::Linear);
    material.specular_color_texture = add_plain_texture(edit, {255, 188, 255, 0}, ColorSpace::Srgb);
    Primitive ground;
    add_textured_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    builtin::add_object(edit, "ground", std::move(ground), edit.add(std::move(material)));
    const double tilt = kPi / 3;
    edit.add(Light{.kind = LightKind::Directional, .intensity = 7.0f, .place = {.node_from_object = looking_down_from({}, float(tilt))}});
    Stage stage(make_scene(std::move(edit)));
    Shot shot = from_above(1);
    shot.view.energy_compensation = false;
    const image::ImageF picture = stage.picture(shot);
    EXPECT_EQ(stage.scene_gpu.stats().textures, 2u);  // occlusion is not drawn and stays on the host

    const double strength = 0.8 * 128 / 255, green = std::pow((188 / 255.0 + 0.055) / 1.055, 2.4);
    const glm::dvec3 dielectric = glm::min(0.25 * glm::dvec3(0.5, green, 9.0), glm::dvec3(1.0)) * strength;
    const double cos_i = std::cos(tilt), cos_h = std::cos(tilt / 2), alpha = 0.49;
    // Diffuse light gets what the coat leaves on its way in and out, in the channel where it leaves least (Kulla and Conty 2017).
    const auto passes = [&](double cosine) { return 1 - specular_albedo(dielectric.z, strength, cosine, alpha); };
    double passes_average = 0;
    for (int k = 0; k < 32; ++k) passes_average += 2 * passes((k + 0.5) / 32) * (k + 0.5) / 32 / 32;
    for (size_t c = 0; c < 3; ++c) {
        const double base = kAlbedo[int(c)], f0 = 0.75 * dielectric[int(c)] + 0.25 * base, f90 = 0.75 * strength + 0.25;
        const double diffuse = 0.75 * base / kPi * passes(1.0) * passes(cos_i) / passes_average, specular = schlick(f0, f90, cos_h) * ggx(cos_i, 1.0, cos_h, alpha);
        const double expected = 7.0 * cos_i * (diffuse + specular);
        for (const float v : picture.plane(c)) ASSERT_NEAR(v, expected, 1e-3 * expected) << "channel " << c;
    }
}

// KHR_materials_clearcoat: emission * (1 - clearcoat * fresnel), seen at an angle.
TEST_F(ClosedForm, a_clear_coat_dims_the_emission_below_it) {
    for (const double tilt : {0.0, 1.2}) {
        SceneEdit edit;
        Material lamp = builtin::lambert("lamp", glm::vec3(0.0f), {2.0f, 3.0f, 4.0f});
        lamp.clearcoat = 0.75f;
        const glm::vec3 across(5.0f * std::cos(tilt), 5.0f * std::sin(tilt), 0.0f);
        Primitive quad;
        add_quad(quad, -0.5f * across + glm::vec3(0.0f, 0.0f, 4.0f), across, {0.0f, 0.0f, -8.0f});
        builtin::add_object(edit, "lamp", std::move(quad), edit.add(std::move(lamp)));
        Stage stage(make_scene(std::move(edit)));
        Shot shot = from_above(1);
        shot.camera = camera_from_above(5.0f, 0.1f);
        const image::ImageF picture = stage.picture(shot);
        for (const float v : picture.plane(1)) ASSERT_NEAR(v, 3.0 * (1 - 0.75 * schlick(0.04, 1.0, std::cos(tilt))), 1e-5) << tilt;
    }
}

// KHR_materials_specular over transmission, straight from above: the coloured reflectance at normal incidence and what it leaves.
TEST_F(ClosedForm, a_specular_colour_tints_what_glass_reflects) {
    SceneEdit edit;
    Material pane{.base_color = glm::vec4(1.0f), .metallic = 0.0f, .roughness = 0.0f, .specular_color = {0.25f, 1.0f, 0.5f}, .transmission = 1.0f};
    Primitive quad;
    add_quad(quad, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    builtin::add_object(edit, "pane", std::move(quad), edit.add(std::move(pane)));
    edit.set_environment({.scale = glm::vec3(1.0f)});
    Stage stage(make_scene(std::move(edit)));
    const image::ImageF picture = stage.picture(from_above(2048));
    for (size_t c = 0; c < 3; ++c) {
        const std::vector<double> all = values(picture, c);
        expect_mean(all, 0.96 + 0.04 * std::array{0.25, 1.0, 0.5}[c], 0.001, fmt::format("channel {}", c));
    }
}

TEST_F(ClosedForm, lights_of_all_kinds_add_up) {
    SceneEdit edit;
    add_ground(edit);
    edit.add(Light{.kind = LightKind::Point, .intensity = 7.0f, .place = {.node_from_object = looking_down_from({0.0f, 2.0f, 0.0f}, 0.0f)}});
    edit.add(Light{.kind = LightKind::Directional, .intensity = 3.0f, .place = {.node_from_object = looking_down_from({}, 0.5f)}});
    edit.set_environment({.scale = glm::vec3(0.4f)});
    Stage stage(make_scene(std::move(edit)));
    const image::ImageF picture = stage.picture(from_above(256));
    std::vector<double> ratios;
    for (uint32_t y = 0; y < kSize; ++y)
        for (uint32_t x = 0; x < kSize; ++x) {
            const glm::dvec2 p(ground_point(x, y, kSize, kHalf));
            const double lux = 7.0 * 2.0 / std::pow(glm::dot(p, p) + 4.0, 1.5) + 3.0 * std::cos(0.5) + 0.4 * kPi;
            ratios.push_back(picture.plane(1)[y * kSize + x] / (double(kAlbedo.y) / kPi * lux));
        }
    expect_mean(ratios, 1.0, 0.005, "sum of lights");
}

}  // namespace parhelion::testing::closed_form_test
