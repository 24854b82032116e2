// Light that goes through surfaces: slabs of glass against their closed forms, volumes inside volumes, panes and shadow rays.
#include <cmath>
#include <numbers>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::glass_test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr uint32_t kSize = 32;

Material glass(float ior, int priority = 0) {
    Material material = builtin::glossy("glass", glm::vec3(1.0f), 0.0f, 0.0f);
    material.transmission = 1.0f;
    material.thickness = 1.0f;
    material.ior = ior;
    material.nested_priority = priority;
    return material;
}

Material pane(glm::vec3 tint) {
    Material material = glass(1.5f);
    material.thickness = 0.0f;
    material.base_color = glm::vec4(tint, 1.0f);
    return material;
}

void add_slab(SceneEdit& edit, Material material, float bottom, float top) {
    Primitive slab;
    add_box(slab, {-3.0f, bottom, -3.0f}, {3.0f, top, 3.0f});
    builtin::add_object(edit, "slab", std::move(slab), edit.add(std::move(material)));
}

void add_floor(SceneEdit& edit, Material material) {
    Primitive floor;
    add_quad(floor, {-9.0f, -5.0f, 9.0f}, {18.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -18.0f});
    builtin::add_object(edit, "floor", std::move(floor), edit.add(std::move(material)));
}

// What a stack of boundaries and layers reflects and passes at normal incidence, all interreflections of intensities included.
struct Layers {
    double up = 0, down = 0, pass = 1;  // reflected to above, to below; passed either way
    Layers over(const Layers& below) const {
        const double series = 1 / (1 - down * below.up);
        return {up + pass * pass * below.up * series, below.down + below.pass * below.pass * down * series, pass * below.pass * series};
    }
};
Layers boundary(double n_above, double n_below) {
    const double r = std::pow((n_above - n_below) / (n_above + n_below), 2);
    return {r, r, 1 - r};
}
Layers absorbing(double transmittance) { return {0, 0, transmittance}; }

class Glass : public GpuTest {
protected:
    // The mean over a tiny patch of the picture straight from above, seen in every way to trace.
    void expect_from_above(SceneEdit edit, glm::dvec3 expected, double margin, uint32_t samples = 128) {
        Stage stage(make_scene(std::move(edit)));
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            const image::ImageF picture =
                stage.picture({.way = way, .view = {.width = kSize, .height = kSize, .max_bounces = 64}, .camera = camera_from_above(5.0f, 0.01f), .sample_count = samples});
            expect_sane(picture);
            for (size_t c = 0; c < 3; ++c) {
                const auto plane = picture.plane(c);
                expect_mean({plane.begin(), plane.end()}, expected[int(c)], margin, fmt::format("{} channel {}", gpu::trace_way_name(way), c));
            }
        }
    }
    static Material glow(glm::vec3 nits) { return builtin::lambert("glow", glm::vec3(0.0f), nits); }
};

}  // namespace

TEST_F(Glass, a_slab_passes_what_fresnel_and_beer_lambert_leave) {
    Material amber = glass(1.5f);
    amber.attenuation_color = {0.9f, 0.5f, 0.2f};
    amber.attenuation_distance = 0.5f;
    SceneEdit edit;
    add_slab(edit, amber, 0.0f, 0.25f);
    add_floor(edit, glow({1.0f, 2.0f, 3.0f}));
    glm::dvec3 expected;
    for (int c = 0; c < 3; ++c) {
        const double inside = std::pow(double(amber.attenuation_color[c]), 0.25 / 0.5);
        expected[c] = (c + 1) * boundary(1, 1.5).over(absorbing(inside)).over(boundary(1.5, 1)).pass;
    }
    expect_from_above(std::move(edit), expected, 0.005);
}

// Overlapping slabs: where both are, the higher priority rules, so light meets each boundary once.
TEST_F(Glass, of_volumes_that_overlap_the_higher_priority_is_there) {
    for (const bool glass_rules : {true, false}) {
        SceneEdit edit;
        Material water = glass(1.33f, glass_rules ? 0 : 2);
        water.attenuation_color = glm::vec3(0.5f);
        water.attenuation_distance = 1.0f;
        add_slab(edit, glass(1.8f, 1), 1.0f, 2.0f);
        add_slab(edit, water, 0.0f, 1.2f);
        add_floor(edit, glow(glm::vec3(1.0f)));
        const double depth = glass_rules ? 1.0 : 1.2;
        const Layers stack = boundary(1, 1.8).over(boundary(1.8, 1.33)).over(absorbing(std::pow(0.5, depth))).over(boundary(1.33, 1));
        expect_from_above(std::move(edit), glm::dvec3(stack.pass), 0.005, 192);
    }
}

TEST_F(Glass, a_volume_inside_one_of_higher_priority_is_not_there) {
    SceneEdit edit;
    add_slab(edit, glass(1.5f, 1), 0.0f, 1.0f);
    Material ink = glass(2.2f);
    ink.attenuation_color = glm::vec3(0.01f);
    ink.attenuation_distance = 0.1f;
    add_slab(edit, ink, 0.3f, 0.6f);
    add_floor(edit, glow(glm::vec3(1.0f)));
    expect_from_above(std::move(edit), glm::dvec3(boundary(1, 1.5).over(boundary(1.5, 1)).pass), 0.005);
}

// Five volumes inside one of higher priority are two more than find room beside it: none of them is there, whichever were noticed.
TEST_F(Glass, volumes_that_find_no_room_are_passed_on_both_sides) {
    SceneEdit edit;
    add_slab(edit, glass(1.5f, 1), 0.0f, 1.0f);
    for (int i = 1; i <= 5; ++i) add_slab(edit, glass(2.2f), 0.08f * float(i), 1.0f - 0.08f * float(i));
    add_floor(edit, glow(glm::vec3(1.0f)));
    expect_from_above(std::move(edit), glm::dvec3(boundary(1, 1.5).over(boundary(1.5, 1)).pass), 0.005);
}

// Of equal priority the volume that was entered last is there: a bubble of another glass.
TEST_F(Glass, a_volume_inside_one_of_equal_priority_is_there) {
    SceneEdit edit;
    add_slab(edit, glass(1.5f), 0.0f, 1.0f);
    add_slab(edit, glass(2.2f), 0.3f, 0.6f);
    add_floor(edit, glow(glm::vec3(1.0f)));
    const Layers stack = boundary(1, 1.5).over(boundary(1.5, 2.2)).over(boundary(2.2, 1.5)).over(boundary(1.5, 1));
    expect_from_above(std::move(edit), glm::dvec3(stack.pass), 0.005);
}

// The same glass twice: what is left is the entry that was made last.
TEST_F(Glass, a_volume_may_lie_in_another_that_lies_in_the_same) {
    SceneEdit edit;
    const Handle<Material> crown = edit.add(glass(1.5f)), flint = edit.add(glass(2.2f));
    const auto slab = [&](Handle<Material> material, float bottom, float top) {
        Primitive box;
        add_box(box, {-3.0f, bottom, -3.0f}, {3.0f, top, 3.0f});
        builtin::add_object(edit, "slab", std::move(box), material);
    };
    slab(crown, 0.0f, 1.0f);
    slab(flint, 0.2f, 0.8f);
    slab(crown, 0.4f, 0.6f);
    add_floor(edit, glow(glm::vec3(1.0f)));
    const Layers half = boundary(1, 1.5).over(boundary(1.5, 2.2)).over(boundary(2.2, 1.5)), other = boundary(1.5, 2.2).over(boundary(2.2, 1.5)).over(boundary(1.5, 1));
    expect_from_above(std::move(edit), glm::dvec3(half.over(other).pass), 0.02, 32);
}

// Shadow rays end at boundaries that paths do not notice, so only the path's own light counts, and all of it: a floor under a lamp,
// a slab of lower priority between them, everything in a volume of index 1. The camera looks through the lamp's back.
TEST_F(Glass, behind_a_boundary_that_is_none_light_has_its_whole_weight) {
    SceneEdit edit;
    Primitive lamp, inner;
    add_quad(lamp, {-3.0f, -3.5f, -3.0f}, {6.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 6.0f});
    add_slab(edit, glass(1.0f, 1), -6.0f, 2.0f);
    add_box(inner, {-2.5f, -4.6f, -2.5f}, {2.5f, -4.0f, 2.5f});
    builtin::add_object(edit, "inner", std::move(inner), edit.add(glass(1.5f)));
    add_floor(edit, builtin::lambert("floor", glm::vec3(0.5f)));
    builtin::add_object(edit, "lamp", std::move(lamp), edit.add(glow(glm::vec3(2.0f))));
    // The form factor of a square above its middle, side 4 times the distance (Howell's catalogue, B-3).
    const double share = 4 / kPi * (2 / std::sqrt(5.0)) * std::atan(2 / std::sqrt(5.0));
    expect_from_above(std::move(edit), glm::dvec3(0.5 * 2.0 * share), 0.02, 64);
}

// A lamp under water is seen by shadow rays under water, weakened by the way: the floor of a pool, seen through its surface.
TEST_F(Glass, light_inside_a_volume_is_absorbed_on_its_way) {
    SceneEdit edit;
    Material water = glass(1.33f);
    water.attenuation_color = glm::vec3(0.3f, 0.6f, 0.9f);
    water.attenuation_distance = 1.0f;
    add_slab(edit, water, -6.0f, 2.0f);
    add_floor(edit, builtin::lambert("floor", glm::vec3(0.8f)));
    edit.add(Light{.kind = LightKind::Point, .intensity = 10.0f, .place = {.node_from_object = glm::translate(glm::mat4(1.0f), {0.0f, -4.0f, 0.0f})}});
    Stage stage(make_scene(std::move(edit)));
    // Only direct light: the floor's light goes straight up through seven metres of water and the surface, shrunk by refraction into
    // a wider cone (1 / n^2).
    const image::ImageF picture =
        stage.picture({.view = {.width = kSize, .height = kSize, .max_bounces = 2}, .camera = camera_from_above(5.0f, 0.01f), .sample_count = 128});
    for (size_t c = 0; c < 3; ++c) {
        const double color = double(water.attenuation_color[int(c)]), floor = 0.8 / kPi * 10.0 * color;
        const auto plane = picture.plane(c);
        expect_mean({plane.begin(), plane.end()}, floor * std::pow(color, 7.0) * boundary(1, 1.33).pass / (1.33 * 1.33), 0.005, fmt::format("channel {}", c));
    }
}

// Fresnel at 1.5, unpolarised.
double fresnel(double cosine) {
    const double t = std::sqrt(1 - (1 - cosine * cosine) / 2.25), s = (cosine - 1.5 * t) / (cosine + 1.5 * t), p = (1.5 * cosine - t) / (1.5 * cosine + t);
    return 0.5 * (s * s + p * p);
}

// The shadow ray passes the pane, weighted by its tint and by what it does not reflect: no noise but that of the camera's own way.
TEST_F(Glass, shadow_rays_pass_a_pane_weighted) {
    const glm::vec3 tint(0.9f, 0.5f, 0.2f);
    SceneEdit edit;
    Primitive ground, sheet;
    add_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    add_quad(sheet, {-4.0f, 2.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(1.0f))));
    builtin::add_object(edit, "sheet", std::move(sheet), edit.add(pane(tint)));
    edit.add(Light{.kind = LightKind::Directional, .intensity = float(kPi), .place = {.node_from_object = glm::mat4_cast(glm::angleAxis(-1.0f, glm::vec3(1, 0, 0)))}});
    Stage stage(make_scene(std::move(edit)));
    const double cosine = std::sin(1.0);
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        const image::ImageF picture = stage.picture({.way = way, .view = {.width = 8, .height = 8, .max_bounces = 1}, .camera = camera_from_above(1.0f, 0.3f), .sample_count = 1});
        for (size_t c = 0; c < 3; ++c)
            for (const float v : picture.plane(c)) ASSERT_NEAR(v, cosine * (1 - fresnel(cosine)) * double(tint[int(c)]), 2e-5) << gpu::trace_way_name(way);
    }
}

// Whether a ray meets a translucent pane and whether it then passes are two decisions with a number each.
TEST_F(Glass, a_translucent_pane_passes_what_is_not_there_and_its_share_of_what_is) {
    SceneEdit edit;
    Primitive sheet;
    add_quad(sheet, {-4.0f, 2.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    Material half = pane(glm::vec3(0.5f));
    half.alpha_mode = AlphaMode::Blend;
    half.base_color.a = 0.4f;
    builtin::add_object(edit, "sheet", std::move(sheet), edit.add(std::move(half)));
    add_floor(edit, glow(glm::vec3(1.0f)));
    expect_from_above(std::move(edit), glm::dvec3(0.6 + 0.4 * 0.5 * (1 - fresnel(1.0))), 0.02, 32);
}

TEST_F(Glass, a_body_of_glass_casts_a_shadow) {
    SceneEdit edit;
    Primitive ground;
    add_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(1.0f))));
    add_slab(edit, glass(1.5f), 2.0f, 2.5f);
    edit.add(Light{.kind = LightKind::Directional, .intensity = 1.0f, .place = {.node_from_object = glm::mat4_cast(glm::angleAxis(-1.5f, glm::vec3(1, 0, 0)))}});
    Stage stage(make_scene(std::move(edit)));
    for (const float v : stage.picture({.view = {.width = 8, .height = 8, .max_bounces = 1}, .camera = camera_from_above(1.0f, 0.3f), .sample_count = 4}).data) ASSERT_EQ(v, 0.0f);
}

// Camera and shadow ray cross the same veil, each with a chance of its own.
TEST_F(Glass, a_veil_of_alpha_a_crossed_twice_passes_one_minus_a_squared) {
    constexpr float kAlpha = 0.4f;
    SceneEdit edit;
    add_veiled_ground(edit, 4.0f, 2.0f, kAlpha);
    edit.add(Light{.kind = LightKind::Directional, .intensity = float(kPi), .place = {.node_from_object = glm::mat4_cast(glm::angleAxis(float(-kPi / 2), glm::vec3(1, 0, 0)))}});
    expect_from_above(std::move(edit), glm::dvec3(std::pow(1.0 - double(kAlpha), 2)), 0.02);
}

// White glass of any kind in white light cannot be seen: what it reflects and what it passes add up to what there is.
TEST_F(Glass, white_glass_vanishes_in_white_light) {
    for (const float roughness : {0.0f, 0.15f, 0.5f, 1.0f})
        for (const bool thin : {false, true}) {
            Material material = thin ? pane(glm::vec3(1.0f)) : glass(1.5f);
            material.roughness = roughness;
            SceneEdit edit;
            builtin::add_object(edit, "sphere", make_sphere(1.0f, 24, false), edit.add(std::move(material)));
            edit.set_environment({.scale = glm::vec3(1.0f)});
            builtin::add_camera(edit, "front", {0.0f, 0.0f, 4.0f}, glm::vec3(0.0f), 0.4f);
            Stage stage(make_scene(std::move(edit)));
            const image::ImageF picture = stage.picture({.view = {.width = kSize, .height = kSize, .max_bounces = 0xFFFFFFFFu}, .sample_count = roughness < 0.3f ? 64u : 256u});
            expect_sane(picture);
            const auto plane = picture.plane(1);
            expect_mean({plane.begin(), plane.end()}, 1.0, roughness < 0.3f ? 0.005 : 0.01, fmt::format("roughness {}, {}", roughness, thin ? "thin" : "body"));
        }
}

// A lamp behind a pane: light sampling finds it through the pane, BSDF sampling passes the pane, and their weights add up to one.
TEST_F(Glass, light_through_panes_is_the_same_however_it_is_sampled) {
    SceneEdit edit;
    Primitive ground, near_sheet, far_sheet, lamp;
    add_quad(ground, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
    add_quad(near_sheet, {-2.0f, 0.6f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.3f, -4.0f});
    add_quad(far_sheet, {-2.0f, 1.1f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.2f, -4.0f});
    add_quad(lamp, {-1.0f, 2.0f, -1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.0f});
    builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(0.7f))));
    builtin::add_object(edit, "near", std::move(near_sheet), edit.add(pane({0.9f, 0.7f, 0.5f})));
    builtin::add_object(edit, "far", std::move(far_sheet), edit.add(pane({0.6f, 0.8f, 1.0f})));
    builtin::add_object(edit, "lamp", std::move(lamp), edit.add(builtin::lambert("lamp", glm::vec3(0.0f), glm::vec3(5.0f))));
    edit.set_environment({.scale = glm::vec3(0.4f)});
    builtin::add_camera(edit, "side", {0.0f, 0.3f, 3.0f}, {0.0f, 0.1f, 0.0f}, 0.7f);
    Stage stage(make_scene(std::move(edit)));
    const auto runs = [&](uint32_t light_sampling, uint32_t first_seed, uint32_t count) {
        Runs out(16, 16);
        for (uint32_t run = 0; run < count; ++run)
            out.add_run(stage.picture({.view = {.width = 16, .height = 16, .seed = first_seed + run, .max_bounces = 4, .light_sampling = light_sampling}, .sample_count = 32}).plane(1));
        return out;
    };
    const Runs reference = runs(0, 100, 48);
    for (const uint32_t light_sampling : {1u, 2u}) {
        const Equivalence result = equivalence_test(runs(light_sampling, 1000 * light_sampling, 32), reference, 0.02);
        EXPECT_TRUE(result.passed) << light_sampling << ": " << result.text;
    }
}

}  // namespace parhelion::testing::glass_test
