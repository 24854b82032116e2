// A posed scene draws the very picture of the same geometry built in place, in every way to trace, after every pose.
#include <glm/gtc/matrix_transform.hpp>

#include "scene/builtin/scenes.h"
#include "scene/pose.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::pose_test {
namespace {

class Poses : public GpuTest {
protected:
    static constexpr float kUpAtOne = 0.5f;  // metres that a second moves the joint; the target adds half of it to x
    static constexpr glm::vec3 kHolder{0.25f, 0.5f, -0.25f};

    // A box on a joint that rises, with a morph target to the right, under a node that is moved and mirrored; or, with `seconds`,
    // the same box where it is then.
    static Scene make(std::optional<float> seconds) {
        SceneEdit edit;
        Primitive ground, box;
        add_quad(ground, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
        builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(0.6f))));
        add_box(box, glm::vec3(-0.5f, 0.0f, -0.5f), glm::vec3(0.5f, 1.0f, 0.5f));
        box.material = edit.add(builtin::lambert("red", {0.8f, 0.1f, 0.1f}));
        if (seconds) {
            for (glm::vec3& p : box.positions) p += glm::vec3(0.5f, 1.0f, 0.0f) * kUpAtOne * *seconds;
            add(edit, std::move(box), {}, {});
        } else {
            const size_t vertices = box.positions.size();
            box.targets.push_back({.positions = std::vector<glm::vec3>(vertices, {0.5f * kUpAtOne, 0.0f, 0.0f})});
            box.influence_count = 1;
            box.joints.assign(vertices, 0);
            box.joint_weights.assign(vertices, 1.0f);
            const Handle<Node> holder = edit.add(Node{.local = {.translation = kHolder, .scale = {-2.0f, 2.0f, 2.0f}}}), joint = edit.add(Node{});
            const Handle<Skin> skin = edit.add(Skin{.joints = {joint}, .inverse_bind = {glm::mat4(1.0f)}});
            add(edit, std::move(box), holder, skin);
            edit.add(Animation{.channels = {{.node = joint, .times = {0, 1}, .values = {0, 0, 0, 0, kUpAtOne, 0}},
                                            {.node = holder, .path = AnimatedPath::Weights, .width = 1, .times = {0, 1}, .values = {0, 1}}}});
        }
        edit.set_environment({.scale = glm::vec3(0.5f)});
        builtin::add_camera(edit, "front", {1.0f, 1.5f, 4.0f}, {0.0f, 0.7f, 0.0f}, 0.8f);
        return make_scene(std::move(edit));
    }
    static void add(SceneEdit& edit, Primitive box, Handle<Node> node, Handle<Skin> skin) {
        Mesh mesh{.name = "box"};
        mesh.primitives.push_back(std::move(box));
        edit.add(Instance{.mesh = edit.add(std::move(mesh)), .place = {.node = node}, .skin = skin});
    }
    static Shot shot(gpu::TraceWay way) { return {.way = way, .view = {.width = 16, .height = 16, .max_bounces = 3}, .sample_count = 2}; }
};

TEST_F(Poses, draw_what_the_same_geometry_in_place_draws) {
    Stage posed(make({})), at_start(make(0.0f)), at_end(make(1.0f));
    for (const float seconds : {0.0f, 1.0f}) {
        posed.step(pose_at(posed.scene, seconds));
        Stage& in_place = seconds == 0.0f ? at_start : at_end;
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            EXPECT_GT(share_equal(posed.picture(shot(way)), in_place.picture(shot(way))), 0.99) << gpu::trace_way_name(way) << " " << seconds;
        }
    }
}

TEST_F(Poses, draw_the_same_bits_without_a_transform_between) {
    // The morphed and skinned instance in the world, not under a node: nothing but the pose differs.
    Scene scene = make({});
    SceneEdit edit;
    Instance bare = (*++scene.instances().begin()).value;
    const Handle<Instance> old = (*++scene.instances().begin()).handle;
    bare.place = {};
    bare.weights = {0.5f};
    edit.remove(old);
    edit.add(std::move(bare));
    scene.apply(std::move(edit));
    scene.apply(pose_at(scene, 0.5));
    Stage posed(std::move(scene)), in_place(make(0.5f));
    EXPECT_EQ(posed.render(shot(gpu::TraceWay::Compute)).limbs, in_place.render(shot(gpu::TraceWay::Compute)).limbs);
}

}  // namespace
}  // namespace parhelion::testing::pose_test
