// What rays see: single- and double-sided surfaces, mirrored instances, cut-out and translucent ones, in all three ways.
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/trace_rays.h"

namespace parhelion::testing::culling_test {
namespace {

class Culling : public GpuTest {
protected:
    static constexpr glm::vec3 kFront{0.0f, 0.0f, -1.0f}, kBehind{0.0f, 0.0f, 1.0f};  // directions of rays that see a quad's side

    static Mesh quad(SceneEdit& edit, Material material, float z = 0.0f) {
        Mesh mesh;
        add_quad(mesh.primitives.emplace_back(), {-1.0f, -1.0f, z}, {2.0f, 0.0f, 0.0f}, {0.0f, 2.0f, 0.0f});  // faces +Z
        mesh.primitives[0].material = edit.add(std::move(material));
        return mesh;
    }
    static Material plain(bool double_sided = false) {
        Material material = builtin::lambert("plain", glm::vec3(0.5f));
        material.double_sided = double_sided;
        return material;
    }
    // (closest hit, shadow ray stopped) from the front and from behind, as "HS hs".
    static std::string seen(Stage& stage, gpu::TraceWay way, glm::vec2 at = {0.2f, 0.3f}) {
        std::string out;
        for (const TestFound& f : trace_rays(stage, way, {{glm::vec3(at, 5.0f), kFront}, {glm::vec3(at, -5.0f), kBehind}})) {
            EXPECT_EQ(f.visible_now, f.visible_before);
            out += f.hit() ? 'h' : '.';
            out += f.visible_now ? '.' : 's';
        }
        return out;
    }
    void expect_seen(Stage& stage, const std::string& expected, glm::vec2 place = {0.2f, 0.3f}) {
        for (const gpu::TraceWay way : kWays)
            if (device()->caps().supports(way)) {
                EXPECT_EQ(seen(stage, way, place), expected) << gpu::trace_way_name(way);
            }
    }
    static Scene one_quad(const Material& material, const glm::mat4& placed = glm::mat4(1.0f)) {
        SceneEdit edit;
        edit.add(Instance{.mesh = edit.add(quad(edit, material)), .place = {.node_from_object = placed}});
        return make_scene(std::move(edit));
    }
    static glm::mat4 scaled(glm::vec3 s) { return glm::mat4(glm::vec4(s.x, 0, 0, 0), glm::vec4(0, s.y, 0, 0), glm::vec4(0, 0, s.z, 0), glm::vec4(0, 0, 0, 1)); }
};

}  // namespace

TEST_F(Culling, a_single_sided_surface_is_invisible_from_behind_to_rays_of_every_kind) {
    Stage stage(one_quad(plain()));
    expect_seen(stage, "hs..");
    expect_seen(stage, "....", {1.5f, 0.0f});
}
TEST_F(Culling, a_double_sided_surface_is_visible_from_both_sides) {
    Stage stage(one_quad(plain(true)));
    expect_seen(stage, "hshs");
}
TEST_F(Culling, without_culling_every_surface_is_visible_from_both_sides) {
    Stage stage(one_quad(plain()), {.culling = false});
    expect_seen(stage, "hshs");
}
TEST_F(Culling, a_mirrored_instance_keeps_its_outside) {
    Stage sideways(one_quad(plain(), scaled({-1.0f, 1.0f, 1.0f}))), through(one_quad(plain(), scaled({1.0f, 1.0f, -1.0f}))), turned(one_quad(plain(), scaled({-1.0f, 1.0f, -1.0f})));
    expect_seen(sideways, "hs..");
    expect_seen(through, "..hs");
    expect_seen(turned, "..hs");
}
TEST_F(Culling, a_mesh_of_both_kinds_is_culled_by_geometry) {
    SceneEdit edit;
    Mesh mesh = quad(edit, plain());
    Primitive second;
    add_quad(second, {1.0f, -1.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 2.0f, 0.0f});
    second.material = edit.add(plain(true));
    mesh.primitives.push_back(std::move(second));
    const Handle<Mesh> handle = edit.add(std::move(mesh));
    edit.add(Instance{.mesh = handle});
    edit.add(Instance{.mesh = handle, .place = {.node_from_object = scaled({-1.0f, 1.0f, 1.0f})}});
    Stage stage(make_scene(std::move(edit)));
    expect_seen(stage, "hs..", {0.2f, 0.3f});
    expect_seen(stage, "hshs", {2.2f, 0.3f});
    expect_seen(stage, "hshs", {-2.2f, 0.3f});
}

TEST_F(Culling, a_camera_inside_out_sees_the_same_in_pictures) {
    SceneEdit edit;
    edit.add(Instance{.mesh = edit.add(quad(edit, plain()))});
    edit.set_environment({.scale = glm::vec3(1.0f)});
    builtin::add_camera(edit, "behind", {0.0f, 0.0f, -3.0f}, glm::vec3(0.0f), 0.5f);
    const Scene scene = make_scene(std::move(edit));
    Stage culled(scene), shown(scene, {.culling = false});
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        const Shot shot{.way = way, .view = {.width = 8, .height = 8}, .sample_count = 16};
        EXPECT_NEAR(mean_rgb(culled.picture(shot)), 1.0, 1e-6) << gpu::trace_way_name(way);
        EXPECT_NEAR(mean_rgb(shown.picture(shot)), 0.5, 0.02) << gpu::trace_way_name(way);
    }
}

TEST_F(Culling, a_mask_has_holes) {
    SceneEdit edit;
    Image half{.name = "half", .width = 2, .height = 1, .texels = {255, 255, 255, 0, 255, 255, 255, 255}};
    Material material = plain(true);
    material.alpha_mode = AlphaMode::Mask;
    material.base_color_texture.texture = edit.add(Texture{.image = edit.add(std::move(half)), .sampler = {.wrap_u = Wrap::ClampToEdge, .mag = Filter::Nearest, .min = Filter::Nearest}});
    Mesh mesh;
    add_textured_quad(mesh.primitives.emplace_back(), {-1.0f, -1.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 2.0f, 0.0f});
    mesh.primitives[0].material = edit.add(std::move(material));
    edit.add(Instance{.mesh = edit.add(std::move(mesh))});
    Stage stage(make_scene(std::move(edit)));
    expect_seen(stage, "....", {-0.5f, 0.3f});
    expect_seen(stage, "hshs", {0.5f, 0.3f});
}

// Rays that leave a surface do not meet it again: a double-sided plane through the origin, on which every coordinate across it is
// exactly 0, and one far away and askew.
TEST_F(Culling, a_double_sided_surface_does_not_shade_itself) {
    glm::mat4 askew = glm::mat4_cast(glm::angleAxis(0.7f, glm::normalize(glm::vec3(1, 2, 3))));
    askew[3] = glm::vec4(310.0f, -70.0f, 55.0f, 1.0f);
    for (const glm::mat4& placed : {glm::mat4(1.0f), askew}) {
        SceneEdit edit;
        edit.add(Instance{.mesh = edit.add(quad(edit, plain(true))), .place = {.node_from_object = placed}});
        edit.set_environment({.scale = glm::vec3(1.0f)});
        Stage stage(make_scene(std::move(edit)));
        const glm::vec3 to(placed * glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
        for (const float side : {3.0f, -3.0f}) {
            const glm::vec3 from(placed * glm::vec4(0.2f, 0.1f, side, 1.0f));
            for (const gpu::TraceWay way : kWays) {
                if (!device()->caps().supports(way)) continue;
                // BSDF sampling in constant light has no noise. Without the correction, which would turn a normal to the viewer's side.
                const ViewDesc view{.width = 16, .height = 16, .light_sampling = 2, .normal_correction = false};
                const image::ImageF picture = stage.picture({.way = way, .view = view, .camera = look_at(from, to, 0.4f), .sample_count = 64});
                for (const float v : picture.data) ASSERT_NEAR(v, 0.5f, 1e-5f) << gpu::trace_way_name(way) << " from " << side;
            }
        }
    }
}

// Of n rays, alpha n stop: binomial, false alarm 1e-4 each.
TEST_F(Culling, a_translucent_surface_stops_its_share_of_rays) {
    constexpr float kAlpha = 0.3f;
    constexpr uint32_t kRays = 4096;
    Material material = plain(true);
    material.alpha_mode = AlphaMode::Blend;
    material.base_color.a = kAlpha;
    Stage stage(one_quad(material));
    std::vector<TestRay> rays(kRays, {{0.2f, 0.3f, 5.0f}, kFront});
    const double spread = 3.9 * std::sqrt(double(kRays) * double(kAlpha) * (1 - double(kAlpha)));
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        uint32_t hits = 0, stopped = 0;
        for (const TestFound& f : trace_rays(stage, way, rays)) hits += f.hit(), stopped += !f.visible_now;
        EXPECT_NEAR(hits, double(kAlpha) * kRays, spread) << gpu::trace_way_name(way);
        EXPECT_NEAR(stopped, double(kAlpha) * kRays, spread) << gpu::trace_way_name(way);
    }
}

// Black veil before white light: the picture is what passes.
TEST_F(Culling, a_black_veil_of_alpha_a_passes_one_minus_a) {
    Material material = builtin::lambert("veil", glm::vec3(0.0f));
    material.alpha_mode = AlphaMode::Blend;
    material.base_color.a = 0.3f;
    SceneEdit edit;
    edit.add(Instance{.mesh = edit.add(quad(edit, material))});
    edit.set_environment({.scale = glm::vec3(1.0f)});
    builtin::add_camera(edit, "front", {0.0f, 0.0f, 3.0f}, glm::vec3(0.0f), 0.3f);
    Stage stage(make_scene(std::move(edit)));
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        const image::ImageF picture = stage.picture({.way = way, .view = {.width = 16, .height = 16}, .sample_count = 64});
        const auto plane = picture.plane(0);
        expect_mean({plane.begin(), plane.end()}, 0.7, 0.03, std::string(gpu::trace_way_name(way)));
    }
}

// The same for shadow rays: a lit ground under a veil that the camera does not look through.
TEST_F(Culling, shadows_of_a_veil_and_of_single_sided_surfaces) {
    for (const bool single_sided : {false, true}) {
        SceneEdit edit;
        Primitive ground, veil;
        add_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
        builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(1.0f))));
        add_quad(veil, {-3.0f, 2.0f, 3.0f}, {6.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -6.0f});  // faces up: shadow rays from below see its back
        Material material = builtin::lambert("veil", glm::vec3(0.0f));
        material.double_sided = !single_sided;
        material.alpha_mode = single_sided ? AlphaMode::Opaque : AlphaMode::Blend;
        material.base_color.a = 0.3f;
        builtin::add_object(edit, "veil", std::move(veil), edit.add(material));
        glm::mat4 down = glm::mat4_cast(glm::angleAxis(-1.57079633f, glm::vec3(1, 0, 0)));
        edit.add(Light{.kind = LightKind::Directional, .intensity = 3.14159265f, .place = {.node_from_object = down}});
        Stage stage(make_scene(std::move(edit)));
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            const image::ImageF picture = stage.picture({.way = way, .view = {.width = 16, .height = 16, .max_bounces = 1}, .camera = camera_from_above(1.0f, 0.5f), .sample_count = 64});
            const auto plane = picture.plane(0);
            if (single_sided)
                for (const float v : plane) ASSERT_NEAR(v, 1.0f, 1e-5f) << gpu::trace_way_name(way);
            else
                expect_mean({plane.begin(), plane.end()}, 0.7, 0.03, std::string(gpu::trace_way_name(way)));
        }
    }
}

}  // namespace parhelion::testing::culling_test
