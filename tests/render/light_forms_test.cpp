// Every kind of light against its closed form on a Lambert plane: by light sampling alone, by BSDF sampling alone where a ray can hit
// the light, and by both (MIS). Means within 0.3 %, with four standard errors to spare (expect_mean): 0 bias fails by chance with
// p < 1e-4 each. The rectangle, point and spot lights at every pixel are in closed_form_test.cpp.
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::light_forms_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kSize = 8;
constexpr float kHalf = 1.0f;  // half extent of the picture on the ground, metres
constexpr float kAlbedo = 0.5f, kNits = 10.0f;
constexpr const char* kNames[] = {"MIS", "light sampling", "BSDF sampling"};

class LightForms : public GpuTest {
protected:
    // At a point of the ground (y = 0, normal +Y): lux.
    using Irradiance = std::function<double(glm::dvec2)>;

    static void add_ground(SceneEdit& edit) {
        Primitive ground;
        add_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
        builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(kAlbedo))));
    }
    static void add_lamp(SceneEdit& edit, Primitive primitive, Material material, const Transform& local = {}) {
        builtin::add_object(edit, "lamp", std::move(primitive), edit.add(std::move(material)), local);
    }
    static Material lamp(bool double_sided = false) {
        Material material = builtin::lambert("lamp", glm::vec3(0.0f), glm::vec3(kNits));
        material.double_sided = double_sided;
        return material;
    }
    // samples[mode]: a pixel's number of samples, 0: not in this mode.
    static void expect_forms(SceneEdit edit, const Irradiance& irradiance, const std::string& what, std::array<uint32_t, 3> samples = {1024, 4096, 2048}, double margin = 0.003) {
        add_ground(edit);
        Stage stage(make_scene(std::move(edit)));
        for (uint32_t mode = 0; mode < 3; ++mode) {
            if (samples[mode] == 0) continue;
            const image::ImageF picture = stage.picture({.view = {.width = kSize, .height = kSize, .max_bounces = 1, .filter = PixelFilter::Point, .light_sampling = mode},
                                                         .camera = camera_from_below_lamps(),
                                                         .sample_count = samples[mode]});
            std::vector<double> ratios;
            for (uint32_t y = 0; y < kSize; ++y)
                for (uint32_t x = 0; x < kSize; ++x)
                    ratios.push_back(double(picture.plane(1)[y * kSize + x]) / (double(kAlbedo) / kPi * irradiance(glm::dvec2(ground_point(x, y, kSize, kHalf)))));
            expect_mean(ratios, 1.0, margin, fmt::format("{} by {}", what, kNames[mode]));
        }
    }
    static CameraView camera_from_below_lamps() { return camera_from_above(0.05f, kHalf); }
    static glm::mat4 looking_down_from(glm::vec3 position, float tilt) {  // -Z turned to -Y, then tilted about Z
        glm::mat4 m = glm::mat4_cast(glm::angleAxis(tilt, glm::vec3(0, 0, 1)) * glm::angleAxis(-float(kPi) / 2, glm::vec3(1, 0, 0)));
        m[3] = glm::vec4(position, 1.0f);
        return m;
    }
    // A regular polygon, facing down, about (0, height, 0).
    static Primitive disk(float radius, float height, uint32_t sides) {
        Primitive out;
        out.positions.push_back({0.0f, height, 0.0f});
        for (uint32_t i = 0; i < sides; ++i) {
            const double turn = 2 * kPi * i / sides;
            out.positions.push_back({float(radius * std::cos(turn)), height, float(radius * std::sin(turn))});
            out.triangles.push_back({0, 1 + i, 1 + (i + 1) % sides});
        }
        return out;
    }
};

// Differential element to a polygon of constant radiance (Lambert 1760; Arvo 1995, (4.4)): no part below the horizon.
double polygon_irradiance(const std::vector<glm::dvec3>& corners, glm::dvec3 p, double nits) {
    glm::dvec3 sum(0.0);
    for (size_t i = 0; i < corners.size(); ++i) {
        const glm::dvec3 a = glm::normalize(corners[i] - p), b = glm::normalize(corners[(i + 1) % corners.size()] - p), n = glm::cross(a, b);
        sum += std::atan2(glm::length(n), glm::dot(a, b)) * glm::normalize(n);
    }
    return 0.5 * nits * std::abs(sum.y);
}

// Differential element to a parallel disk on whose axis it is `away` from (Howell's catalogue, B-12).
double disk_form_factor(double radius, double height, double away) {
    const double h = height / radius, z = away / radius, s = 1 + h * h + z * z;  // in radii
    return 0.5 * (1 + (1 - z * z - h * h) / std::sqrt(s * s - 4 * z * z));
}

double mean_over_triangles(const Primitive& primitive, glm::dvec3 p) {
    double lux = 0;
    for (const glm::uvec3& t : primitive.triangles) {
        const glm::dvec3 a(primitive.positions[t.x]), b(primitive.positions[t.y]), c(primitive.positions[t.z]);
        if (glm::dot(glm::cross(b - a, c - a), p - a) <= 0) continue;  // shows its back
        lux += polygon_irradiance({a, b, c}, p, double(kNits));
    }
    return lux;
}

}  // namespace

TEST_F(LightForms, a_rectangle) {
    SceneEdit edit;
    Primitive quad;
    add_quad(quad, {-1.2f, 1.2f, -1.0f}, {2.4f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.0f});
    add_lamp(edit, std::move(quad), lamp());
    expect_forms(std::move(edit), [](glm::dvec2 p) {
        return polygon_irradiance({{-1.2, 1.2, -1.0}, {1.2, 1.2, -1.0}, {1.2, 1.2, 1.0}, {-1.2, 1.2, 1.0}}, {p.x, 0, p.y}, double(kNits));
    }, "rectangle", {2048, 8192, 4096});
}

// 256 sides: its area is 1e-4 less than the disk's.
TEST_F(LightForms, a_disk) {
    SceneEdit edit;
    add_lamp(edit, disk(1.2f, 1.0f, 256), lamp());
    expect_forms(std::move(edit), [](glm::dvec2 p) { return kPi * double(kNits) * disk_form_factor(1.2, 1.0, glm::length(p)) * (1 - 1.0e-4); }, "disk");
}

// A sphere wholly above the horizon lights by its solid angle's projection: pi L (r / d)^2 cos (Howell's catalogue, B-25). Made of
// triangles it is smaller: each pixel is expected to have what the triangles give, and the sphere is held against these.
TEST_F(LightForms, a_sphere_as_a_triangle_mesh) {
    const Primitive sphere = make_sphere(0.9f, 24, false);
    const glm::dvec3 middle(0.2, 1.7, -0.1);
    const auto mesh = [&](glm::dvec2 p) { return mean_over_triangles(sphere, glm::dvec3(p.x, 0, p.y) - middle); };
    const auto round = [&](glm::dvec2 p) {
        const double d = glm::length(glm::dvec3(p.x, 0, p.y) - middle);
        return kPi * double(kNits) * 0.81 / (d * d) * middle.y / d;
    };
    for (const glm::dvec2 p : {glm::dvec2(0.0), glm::dvec2(0.9, -0.8)}) EXPECT_NEAR(mesh(p), round(p), 0.01 * round(p));
    SceneEdit edit;
    add_lamp(edit, sphere, lamp(), {.translation = glm::vec3(middle)});
    expect_forms(std::move(edit), mesh, "sphere", {4096, 16384, 4096});
}

// A flat ring of forty quads, whose front is down in the world however its instance is stretched, turned over or mirrored.
TEST_F(LightForms, a_mesh_under_transforms_that_stretch_and_mirror) {
    const auto ring_facing = [](bool up) {
        Primitive ring;
        for (uint32_t i = 0; i < 40; ++i) {
            const double turn = 2 * kPi * i / 40;
            for (const double r : {0.5, 1.1}) ring.positions.push_back({float(r * std::cos(turn)), 0.0f, float(r * std::sin(turn))});
            const uint32_t next = (i + 1) % 40 * 2;
            ring.triangles.push_back({2 * i, 2 * i + 1, next + 1});
            ring.triangles.push_back({2 * i, next + 1, next});
        }
        if (up)
            for (glm::uvec3& t : ring.triangles) std::swap(t.y, t.z);
        return ring;
    };
    struct Case {
        const char* name;
        glm::vec3 scale;
        bool up, double_sided;
    };
    for (const Case& c : {Case{"stretched", {1.4f, 1.0f, 0.7f}, false, false}, Case{"mirrored along", {-1.4f, 1.0f, 0.7f}, false, false}, Case{"mirrored through", {1.4f, -1.0f, 0.7f}, true, false},
                          Case{"two-sided", {1.4f, 1.0f, 0.7f}, true, true}}) {
        SceneEdit edit;
        const Primitive ring = ring_facing(c.up);
        const glm::vec3 middle(0.1f, 1.1f, 0.0f);
        add_lamp(edit, ring, lamp(c.double_sided), {.translation = middle, .scale = c.scale});
        const auto lux = [&](glm::dvec2 p) {
            double sum = 0;
            for (const glm::uvec3& t : ring.triangles) {
                const auto at = [&](uint32_t i) { return glm::dvec3(ring.positions[i] * c.scale + middle); };
                sum += polygon_irradiance({at(t.x), at(t.y), at(t.z)}, {p.x, 0, p.y}, double(kNits));
            }
            return sum;
        };
        expect_forms(std::move(edit), lux, c.name, {1024, 2048, 4096});
    }
}

TEST_F(LightForms, nothing_behind_a_lamp_of_one_side) {
    SceneEdit edit;
    add_ground(edit);
    Primitive quad;
    add_quad(quad, {-1.0f, 1.0f, 1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -2.0f});  // shines up
    add_lamp(edit, std::move(quad), lamp());
    Stage stage(make_scene(std::move(edit)));
    for (uint32_t mode = 0; mode < 3; ++mode)
        EXPECT_EQ(mean_rgb(stage.picture({.view = {.width = kSize, .height = kSize, .max_bounces = 1, .light_sampling = mode}, .camera = camera_from_below_lamps(), .sample_count = 64})), 0.0) << kNames[mode];
}

// Each texel of a nearest filter is a rectangle of its own; some are black, some dim. As two triangles that all texels share,
// and with a quad to each texel.
TEST_F(LightForms, a_textured_emitter) {
    constexpr uint32_t kTexels = 4;
    const uint8_t grey[kTexels * kTexels] = {255, 0, 188, 230, 200, 150, 0, 255, 220, 210, 0, 170, 240, 130, 190, 205};
    for (const uint32_t steps : {1u, kTexels}) {
        SceneEdit edit;
        Image image{.width = kTexels, .height = kTexels};
        for (const uint8_t g : grey) image.texels.insert(image.texels.end(), {g, g, g, 255});
        Material material = lamp();
        material.emissive_texture.texture = edit.add(Texture{.image = edit.add(std::move(image)), .sampler = {.wrap_u = Wrap::ClampToEdge, .wrap_v = Wrap::ClampToEdge, .mag = Filter::Nearest, .min = Filter::Nearest}});
        Primitive quad;
        add_textured_quad(quad, {-1.4f, 1.0f, -1.2f}, {2.8f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.4f}, glm::vec2(1.0f), steps);
        add_lamp(edit, std::move(quad), std::move(material));
        const auto lux = [&](glm::dvec2 p) {
            double sum = 0;
            for (uint32_t y = 0; y < kTexels; ++y)
                for (uint32_t x = 0; x < kTexels; ++x) {
                    const double encoded = grey[y * kTexels + x] / 255.0, light = encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
                    const double left = -1.4 + 0.7 * x, far = -1.2 + 0.6 * (kTexels - 1 - y);  // the image's rows run against v
                    sum += polygon_irradiance({{left, 1, far}, {left + 0.7, 1, far}, {left + 0.7, 1, far + 0.6}, {left, 1, far + 0.6}}, {p.x, 0, p.y}, double(kNits) * light);
                }
            return sum;
        };
        const std::array<uint32_t, 3> samples = steps == 1 ? std::array{8192u, 32768u, 4096u} : std::array{2048u, 8192u, 4096u};
        expect_forms(std::move(edit), lux, fmt::format("texture on {} quads", steps * steps), samples);
    }
}

// Light that comes from one point has no noise in any mode.
TEST_F(LightForms, point_spot_and_directional_lights) {
    const glm::dvec3 at(0.3, 1.2, -0.2), axis(std::sin(0.2), -std::cos(0.2), 0.0);
    const auto by_square = [&](glm::dvec2 p, auto candela) {
        const glm::dvec3 d = at - glm::dvec3(p.x, 0, p.y);
        return candela(-glm::dot(axis, glm::normalize(d))) * d.y / std::pow(glm::length(d), 3);
    };
    const auto expect_light = [&](Light light, const Irradiance& irradiance, const char* what) {
        SceneEdit edit;
        light.place.node_from_object = looking_down_from(glm::vec3(at), 0.2f);
        edit.add(std::move(light));
        expect_forms(std::move(edit), irradiance, what, {1, 1, 1}, 1e-4);
    };
    expect_light({.kind = LightKind::Point, .intensity = 7.0f}, [&](glm::dvec2 p) { return by_square(p, [](double) { return 7.0; }); }, "point");
    // A range is a hint that a path tracer ignores.
    expect_light({.kind = LightKind::Point, .intensity = 7.0f, .range = 1.3f}, [&](glm::dvec2 p) { return by_square(p, [](double) { return 7.0; }); }, "point with a range");
    for (const auto& [inner, outer] : {std::pair(0.0, 1.5), std::pair(0.7, 1.4), std::pair(1.3, 1.45)})
        expect_light({.kind = LightKind::Spot, .intensity = 7.0f, .inner_cone = float(inner), .outer_cone = float(outer)}, [&](glm::dvec2 p) {
            return by_square(p, [&](double cosine) {
                const double fall = glm::clamp((cosine - std::cos(outer)) / (std::cos(inner) - std::cos(outer)), 0.0, 1.0);
                return 7.0 * fall * fall;
            });
        }, "spot");
    expect_light({.kind = LightKind::Directional, .intensity = 7.0f}, [](glm::dvec2) { return 7.0 * std::cos(0.2); }, "directional");
}

// A disk at infinity lights like a ray from its middle, as the mean cosine over it is the middle's. Only the widest is one that BSDF
// sampling finds often enough.
TEST_F(LightForms, sun_disks_of_a_tenth_of_a_degree_to_thirty) {
    for (const double degrees : {0.1, 0.5, 2.0, 10.0, 30.0}) {
        SceneEdit edit;
        edit.add(Light{.kind = LightKind::Directional, .intensity = 7.0f, .angular_radius = float(degrees * kPi / 180), .place = {.node_from_object = looking_down_from({}, 0.4f)}});
        expect_forms(std::move(edit), [](glm::dvec2) { return 7.0 * std::cos(0.4); }, fmt::format("sun of {} degrees", degrees), {256, 256, degrees > 20 ? 4096u : 0u});
    }
}

TEST_F(LightForms, a_constant_sky) {
    SceneEdit edit;
    edit.set_environment({.scale = glm::vec3(kNits)});
    expect_forms(std::move(edit), [](glm::dvec2) { return kPi * double(kNits); }, "constant sky", {256, 1024, 4});
}

// Radiance a + b theta / pi; its irradiance is pi a + pi b / 4.
TEST_F(LightForms, a_sky_with_a_gradient) {
    constexpr double a = 8.0, b = -7.0;
    Environment e{.width = 6, .height = 100, .scale = glm::vec3(2.0f), .rotation = 0.5f};
    for (uint32_t y = 0; y < e.height; ++y) e.radiance.insert(e.radiance.end(), e.width, glm::vec3(float(a + b * (y + 0.5) / e.height)));
    SceneEdit edit;
    edit.set_environment(std::move(e));
    expect_forms(std::move(edit), [](glm::dvec2) { return 2.0 * kPi * (a + b / 4); }, "gradient", {256, 4096, 256});
}

// Two texels of 1e5 on a map of 1: nearly all light, from 1/1000 of the sky. No number of BSDF samples would do.
TEST_F(LightForms, a_sun_of_two_texels_in_an_image) {
    Environment e{.width = 64, .height = 32, .scale = glm::vec3(1.0f), .rotation = 0.7f};
    e.radiance.assign(size_t(64) * 32, glm::vec3(1.0f));
    e.radiance[7 * 64 + 20] = e.radiance[7 * 64 + 21] = glm::vec3(1e5f);
    // A tent of one texel in v; two in u, whose sum is two texels wide.
    double lux = kPi;
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i) {
        const double offset = 2 * (i + 0.5) / kSteps - 1, theta = kPi * (7.5 + offset) / 32;  // rows from the texels' middle
        lux += (1e5 - 1) * (1 - std::abs(offset)) * std::cos(theta) * std::sin(theta) * (2.0 / kSteps * kPi / 32) * (2 * 2 * kPi / 64);
    }
    SceneEdit edit;
    edit.set_environment(std::move(e));
    expect_forms(std::move(edit), [lux](glm::dvec2) { return lux; }, "two-texel sun", {32768, 32768, 0});
}

}  // namespace parhelion::testing::light_forms_test
