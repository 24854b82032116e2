// Proxies: what rays meet in the place of the triangles that are drawn. All ways to trace meet the same, and the picture is nearly that of the
// whole meshes.
#include <random>

#include "image/flip.h"
#include "image/metrics.h"
#include "scene/builtin/scenes.h"
#include "scene/camera.h"
#include "scene/shapes.h"
#include "support/trace_rays.h"

namespace parhelion::testing::proxy_test {
namespace {

constexpr uint32_t kRings = 32;
const SceneGpuOptions kWhole{.raster = true}, kProxies{.raster = true, .proxy_ratio = 0.15f, .proxy_error = 0.02f};

class Proxies : public GpuTest {};

Transform at(glm::vec3 translation) { return {.translation = translation}; }

Material with_emission(float nits) { return builtin::lambert("plain", glm::vec3(0.6f), glm::vec3(nits)); }

struct Balls {
    SceneEdit edit;
    Handle<Material> plain, shining;
};

// A ball that could deform.
Primitive morphing_ball() {
    Primitive out = make_sphere(0.8f, kRings, true);
    out.targets.push_back({.positions = std::vector<glm::vec3>(out.positions.size(), glm::vec3(0, 0.1f, 0))});
    return out;
}

// Rows in this order: a plain ball, one that shines, one with a mask, one that can deform, and a ground.
Balls make_balls() {
    Balls out;
    Material masked = builtin::lambert("masked", glm::vec3(0.5f));
    masked.alpha_mode = AlphaMode::Mask;
    out.plain = out.edit.add(with_emission(0));
    out.shining = out.edit.add(with_emission(40));
    builtin::add_object(out.edit, "plain", make_sphere(0.8f, kRings, true), out.plain, at({-2, 0.9f, 0}));
    builtin::add_object(out.edit, "shining", make_sphere(0.6f, kRings, true), out.shining, at({0, 0.9f, 0}));
    builtin::add_object(out.edit, "masked", make_sphere(0.8f, kRings, true), out.edit.add(std::move(masked)), at({2, 0.9f, 0}));
    builtin::add_object(out.edit, "morphing", morphing_ball(), out.plain, at({0, 0.9f, -3}));
    Primitive ground;
    add_quad(ground, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8});
    builtin::add_object(out.edit, "ground", std::move(ground), out.edit.add(builtin::lambert("ground", glm::vec3(0.7f))));
    out.edit.set_environment({.scale = glm::vec3(1.0f)});
    return out;
}

CameraView look_at_balls() { return look_at({0, 1.5f, 7}, {0, 0.8f, 0}, 0.9f); }

std::vector<TestRay> rays_from_around(size_t count, float distance) {
    std::mt19937 random(3);
    std::normal_distribution<float> normal;
    const auto vector = [&] { return glm::vec3(normal(random), normal(random), normal(random)); };
    std::vector<TestRay> rays(count);
    for (TestRay& ray : rays) {
        ray.origin_ws = distance * glm::normalize(vector());
        ray.direction_ws = glm::normalize(vector() * glm::vec3(1.2f, 0.4f, 0.4f) + glm::vec3(0, 0.9f, 0) - ray.origin_ws);
    }
    return rays;
}

TEST_F(Proxies, are_met_in_every_way_to_trace_and_never_where_triangles_count) {
    Stage stage(make_scene(make_balls().edit), kProxies);
    const std::vector<TestRay> rays = rays_from_around(4096, 20.0f);
    const std::vector<TestFound> ours = trace_rays(stage, gpu::TraceWay::Compute, rays);
    const SceneGpuStats& stats = stage.scene_gpu.stats();
    const auto whole = static_cast<uint32_t>((stats.triangles - 2) / 4);
    EXPECT_LE(stats.traced_triangles, stats.triangles - whole * 4 / 5);
    EXPECT_GE(stats.traced_triangles, 3 * whole + 2 + whole / 8);
    std::array<size_t, 5> met{};
    for (const TestFound& found : ours) {
        if (!found.hit()) continue;
        ++met.at(found.instance);
        EXPECT_EQ(found.instance == 0, found.primitive >= whole);
        EXPECT_LT(found.primitive, found.instance == 0 ? 2 * whole : whole);
    }
    for (const size_t count : met) EXPECT_GT(count, 50u);
    for (const gpu::TraceWay way : {gpu::TraceWay::Pipeline, gpu::TraceWay::Query}) {
        if (!device()->caps().supports(way)) continue;
        const std::vector<TestFound> theirs = trace_rays(stage, way, rays);
        size_t differ = 0;
        for (size_t i = 0; i < rays.size(); ++i) differ += theirs[i] != ours[i];
        EXPECT_LE(differ, rays.size() / 500) << gpu::trace_way_name(way);
    }
}

TEST_F(Proxies, do_not_depend_on_how_the_scene_comes_in) {
    const Shot shot{.view = {.width = 24, .height = 24, .max_bounces = 2}, .camera = look_at_balls(), .sample_count = 1};
    SceneGpuOptions crumbs = kProxies;
    crumbs.slice_bytes = 1u << 16, crumbs.slice_triangles = 1, crumbs.geometry_buffer_bytes = 1u << 16;
    Stage whole(make_scene(make_balls().edit), kProxies), sliced(make_scene(make_balls().edit), crumbs);
    EXPECT_EQ(differing_words(whole.render(shot), sliced.render(shot)), 0u);
}

TEST_F(Proxies, give_one_picture_in_every_way_to_trace) {
    Stage stage(make_scene(make_balls().edit), kProxies);
    const Shot shot{.view = {.width = 32, .height = 32, .max_bounces = 1}, .camera = look_at_balls(), .sample_count = 2};
    const image::ImageF ours = stage.picture(shot);
    expect_sane(ours);
    EXPECT_GT(mean_rgb(ours), 0.0);
    for (const gpu::TraceWay way : {gpu::TraceWay::Pipeline, gpu::TraceWay::Query}) {
        if (!device()->caps().supports(way)) continue;
        Shot theirs = shot;
        theirs.way = way;
        EXPECT_GE(share_equal(stage.picture(theirs), ours), 0.99) << gpu::trace_way_name(way);
    }
}

// Its proxy lies before all of a room's round wall, so that every ray that leaves the wall as it is drawn would begin behind what it may meet.
TEST_F(Proxies, do_not_hide_what_is_drawn_behind_them) {
    const auto picture = [](bool inward, const SceneGpuOptions& options) {
        Material wall = builtin::lambert("wall", glm::vec3(0.5f));
        wall.double_sided = true;
        Primitive room = make_sphere(2.0f, kRings, true);
        if (inward)
            for (glm::uvec3& t : room.triangles) std::swap(t.y, t.z);
        SceneEdit edit;
        builtin::add_object(edit, "room", std::move(room), edit.add(std::move(wall)));
        edit.add(Light{.intensity = 10.0f, .place = {.node_from_object = glm::mat4(1.0f)}});
        Stage stage(make_scene(std::move(edit)), options);
        const Shot shot{.view = {.width = 32, .height = 32, .max_bounces = 1, .filter = PixelFilter::Point}, .camera = look_at({0.3f, 0.2f, 1}, {0, 0, -1}, 1.2f), .sample_count = 1};
        return image::resolve_film(stage.play(shot, {.gbuffer = GBufferMode::Raster, .tiles = false, .cache = false}));
    };
    for (const bool inward : {false, true}) {
        const image::ImageF whole = picture(inward, kWhole), proxies = picture(inward, kProxies);
        const double ratio = mean_rgb(proxies) / mean_rgb(whole), equal = share_equal(proxies, whole);
        RecordProperty(fmt::format("mean_ratio_{}", inward), fmt::format("{:.4f}, {:.4f} of the pixels are equal", ratio, equal));
        EXPECT_NEAR(ratio, 1.0, 0.02) << inward;
        EXPECT_GE(equal, 0.99) << inward;
    }
}

// A36.
TEST_F(Proxies, look_like_the_whole_meshes) {
    const auto film = [&](const SceneGpuOptions& options) {
        Stage stage(make_builtin("builtin:spheres").scene, options);
        const image::ImageF picture = image::resolve_film(stage.play({.view = {.width = 72, .height = 48, .max_bounces = 4, .filter = PixelFilter::Point}, .sample_count = 16}, {.gbuffer = GBufferMode::Raster}));
        return std::pair(picture, double(stage.scene_gpu.stats().traced_triangles) / double(stage.scene_gpu.stats().triangles));
    };
    const auto [whole, all] = film(kWhole);
    const auto [proxies, share] = film({.raster = true, .proxy_ratio = 0.25f, .proxy_error = 0.01f});
    EXPECT_EQ(all, 1.0);
    EXPECT_LT(share, 0.5);
    const double ratio = image::mean_ratio(image::rgb_planes(proxies), image::rgb_planes(whole)).luminance;
    const double flip = image::flip_hdr(image::rgb_planes(whole), image::rgb_planes(proxies), 72, 48).mean;
    RecordProperty("picture", fmt::format("mean ratio {:.4f}, FLIP {:.4f}, {:.3f} of the triangles", ratio, flip, share));
    EXPECT_NEAR(ratio, 1.0, 0.02);
    EXPECT_LE(flip, 0.03);
}

// Which triangles are met follows the materials of the moment, whatever was before: one ball begins to shine, the other ends.
TEST_F(Proxies, give_way_when_a_material_begins_to_shine) {
    Balls balls = make_balls();
    Scene scene;
    const ChangeSet changes = scene.apply(std::move(balls.edit));
    const Handle<Material> plain = changes.resolve(balls.plain), shining = changes.resolve(balls.shining);
    Stage stage(std::move(scene), kProxies);
    const Shot shot{.view = {.width = 24, .height = 24, .max_bounces = 2}, .camera = look_at_balls(), .sample_count = 1};
    const image::FilmSums before = stage.render(shot);
    const uint64_t traced = stage.scene_gpu.stats().traced_triangles;
    const std::vector<TestRay> rays = rays_from_around(2048, 20.0f);
    std::vector<TestFound> met = trace_rays(stage, gpu::TraceWay::Compute, rays);
    const auto expect_past_is_there = [&] {
        const std::vector<TestFound> next = trace_rays(stage, gpu::TraceWay::Compute, rays);
        size_t differ = 0;
        for (size_t i = 0; i < rays.size(); ++i) differ += next[i].visible_before != met[i].visible_now;
        EXPECT_EQ(differ, 0u) << "what was met a frame ago is not what it was";
        met = next;
    };
    const auto shine = [&](float nits, float nits_of_shining) {
        SceneEdit edit;
        edit.set_material(plain, with_emission(nits));
        edit.set_material(shining, with_emission(nits_of_shining));
        return edit;
    };
    stage.step(shine(30, 0));
    expect_past_is_there();
    const image::FilmSums exchanged = stage.render(shot);
    Balls afresh = make_balls();
    Scene other = make_scene(std::move(afresh.edit));
    other.apply(shine(30, 0));
    EXPECT_EQ(differing_words(exchanged, Stage(std::move(other), kProxies).render(shot)), 0u);
    stage.step(shine(0, 40));
    expect_past_is_there();
    EXPECT_EQ(differing_words(stage.render(shot), before), 0u);
    EXPECT_EQ(stage.scene_gpu.stats().traced_triangles, traced);
}

}  // namespace
}  // namespace parhelion::testing::proxy_test
