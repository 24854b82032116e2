// What stands on a hidden node is not there, for any renderer, and comes back.
#include <functional>

#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/realtime_player.h"
#include "support/trace_rays.h"

namespace parhelion::testing::visibility_test {
namespace {

constexpr uint32_t kSize = 16;

class Visibility : public GpuTest {
protected:
    // Ground, a lamp that stays, and on one node: a glowing ball with a light of its own.
    static Scene make(bool with_ball) {
        SceneEdit edit;
        Primitive ground;
        add_quad(ground, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
        builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(0.5f))));
        edit.add(Light{.name = "lamp", .intensity = 3.0f, .place = {.node_from_object = glm::translate(glm::mat4(1.0f), {0.5f, 2.0f, 0.0f})}});
        if (!with_ball) return make_scene(std::move(edit));
        const Handle<Node> upper = edit.add(Node{.name = "upper"}), lower = edit.add(Node{.name = "ball", .parent = upper, .local = {.translation = {0.0f, 0.5f, 0.0f}}});
        Mesh ball{.name = "ball"};
        ball.primitives.push_back(make_sphere(0.4f, 8, true));
        ball.primitives[0].material = edit.add(builtin::lambert("glow", glm::vec3(0.5f), glm::vec3(4.0f)));
        edit.add(Instance{.mesh = edit.add(std::move(ball)), .place = {.node = lower}});
        edit.add(Light{.name = "inside", .intensity = 5.0f, .place = {.node = lower, .node_from_object = glm::translate(glm::mat4(1.0f), {0.0f, 1.0f, 0.0f})}});
        return make_scene(std::move(edit));
    }
    static SceneEdit show(const Scene& scene, bool visible) {
        SceneEdit edit;
        for (const auto& [handle, node] : scene.nodes())
            if (node.name == "upper") edit.set_visible(handle, visible);
        return edit;
    }
    static Shot shot() { return {.view = {.width = kSize, .height = kSize, .filter = PixelFilter::Point}, .camera = camera_from_above(4.0f, 1.5f), .sample_count = 16}; }
};

TEST_F(Visibility, what_is_hidden_is_not_there_for_any_renderer) {
    Stage stage(make(true)), without(make(false));
    Shot small_kernels = shot();
    small_kernels.wavefront = WavefrontOptions{};
    const std::pair<const char*, std::function<image::FilmSums(Stage&)>> renderers[] = {
        {"reference", [](Stage& s) { return s.render(shot()); }},
        {"wavefront", [&](Stage& s) { return s.render(small_kernels); }},
        {"realtime", [](Stage& s) { return s.play(shot(), {}); }},
    };
    std::vector<image::FilmSums> empty, shown;
    for (const auto& [name, draw] : renderers) {
        empty.push_back(draw(without));
        shown.push_back(draw(stage));
        EXPECT_GT(mean_rgb(image::resolve_film(shown.back())), 1.5 * mean_rgb(image::resolve_film(empty.back()))) << name;
    }
    stage.step(show(stage.scene, false));
    stage.step({});
    for (size_t i = 0; i < std::size(renderers); ++i) EXPECT_EQ(differing_words(renderers[i].second(stage), empty[i]), 0u) << renderers[i].first;
    EXPECT_EQ(stage.scene_gpu.stats().emitters, 1u);
    stage.step(show(stage.scene, true));
    stage.step({});
    for (size_t i = 0; i < std::size(renderers); ++i) EXPECT_EQ(differing_words(renderers[i].second(stage), shown[i]), 0u) << renderers[i].first;
}

TEST_F(Visibility, the_previous_frame_still_has_what_has_just_been_hidden) {
    Stage stage(make(true));
    const std::vector<TestRay> rays{{{0.0f, 0.7f, 4.0f}, {0.0f, 0.0f, -1.0f}}};
    const auto expect_at = [&](bool now, bool before) {
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            const TestFound found = trace_rays(stage, way, rays)[0];
            EXPECT_EQ(found.hit(), now) << gpu::trace_way_name(way);
            EXPECT_EQ(found.visible_before == 0, before) << gpu::trace_way_name(way);
        }
    };
    expect_at(true, true);
    stage.step(show(stage.scene, false));
    expect_at(false, true);
    stage.step({});
    expect_at(false, false);
    stage.step(show(stage.scene, true));
    expect_at(true, false);
}

TEST_F(Visibility, light_of_what_is_hidden_goes_out_in_realtime) {
    Stage stage(make(true));
    Player player(stage, shot(), {.reuse = RealtimeReuse::Full});
    const double lit = player.mean(16);
    player.skip(64, show(stage.scene, false));
    Stage without(make(false));
    Player other(without, shot(), {.reuse = RealtimeReuse::Full});
    other.skip(64);
    const double left = player.mean(32), expected = other.mean(32);
    EXPECT_GT(lit, 1.5 * expected);
    EXPECT_NEAR(left, expected, 0.05 * expected);
}

}  // namespace
}  // namespace parhelion::testing::visibility_test
