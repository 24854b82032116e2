// Edits reach the device: an edited scene draws what the same scene built from scratch draws, bit for bit, and the previous frame's
// scene stays visible to shadow rays for one frame.
#include <functional>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/trace_rays.h"

namespace parhelion::testing::scene_edit_test {
namespace {

constexpr glm::vec3 kOld(-0.6f, 0.5f, 0.0f), kNew(0.7f, 0.4f, -0.3f);

glm::mat4 at(glm::vec3 position) { return glm::mat4(glm::vec4(1, 0, 0, 0), glm::vec4(0, 1, 0, 0), glm::vec4(0, 0, 1, 0), glm::vec4(position, 1)); }

class SceneEdits : public GpuTest {
protected:
    struct Parts {
        Scene scene;
        Handle<Material> red;
        Handle<Mesh> box;
        Handle<Instance> moving, lamp;
        Handle<Light> light;
    };
    struct Variant {
        glm::vec3 box_at = kOld, lamp_at{0.0f}, red{0.8f, 0.1f, 0.1f}, glow{0.0f};
        AlphaMode alpha = AlphaMode::Opaque;
        bool second_box = false, point_light = false, box = true;
        float sky = 0.2f;
    };
    static Light point() { return {.kind = LightKind::Point, .intensity = 2.0f, .place = {.node_from_object = at({1.0f, 1.5f, 1.0f})}}; }
    static Material red(const Variant& v) {
        Material material = builtin::lambert("red", v.red, v.glow);
        material.base_color.a = 0.5f;
        material.alpha_mode = v.alpha;
        return material;
    }
    static Parts make(const Variant& v) {
        SceneEdit edit;
        Parts parts;
        Primitive ground, lamp, box;
        add_quad(ground, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
        builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(0.6f))));
        add_quad(lamp, {-0.5f, 2.0f, -0.5f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f});
        Mesh lamp_mesh{.name = "lamp"};
        lamp.material = edit.add(builtin::lambert("lamp", glm::vec3(0.0f), glm::vec3(5.0f)));
        lamp_mesh.primitives.push_back(std::move(lamp));
        parts.lamp = edit.add(Instance{.mesh = edit.add(std::move(lamp_mesh)), .place = {.node_from_object = at(v.lamp_at)}});
        parts.red = edit.add(red(v));
        add_box(box, glm::vec3(-0.3f), glm::vec3(0.3f));
        box.material = parts.red;
        Mesh mesh{.name = "box"};
        mesh.primitives.push_back(std::move(box));
        parts.box = edit.add(std::move(mesh));
        if (v.box) parts.moving = edit.add(Instance{.mesh = parts.box, .place = {.node_from_object = at(v.box_at)}});
        if (v.second_box) edit.add(Instance{.mesh = parts.box, .place = {.node_from_object = at(kNew)}});
        if (v.point_light) parts.light = edit.add(point());
        edit.set_environment({.scale = glm::vec3(v.sky)});
        builtin::add_camera(edit, "front", {0.0f, 1.2f, 4.0f}, {0.0f, 0.7f, 0.0f}, 0.8f);
        const ChangeSet changes = parts.scene.apply(std::move(edit));
        parts.red = changes.resolve(parts.red), parts.box = changes.resolve(parts.box), parts.lamp = changes.resolve(parts.lamp);
        if (v.box) parts.moving = changes.resolve(parts.moving);
        if (v.point_light) parts.light = changes.resolve(parts.light);
        return parts;
    }
    static Shot shot(gpu::TraceWay way) { return {.way = way, .view = {.width = 16, .height = 16, .max_bounces = 3}, .sample_count = 2}; }

    // Draws `before`, applies the edit, and compares with `after` built from scratch.
    void expect_edit(const Variant& before, const Variant& after, const std::function<void(SceneEdit&, const Parts&)>& change) {
        Parts parts = make(before);
        Scene scene = std::move(parts.scene);
        Stage edited(std::move(scene)), scratch(make(after).scene);
        for (const gpu::TraceWay way : kWays)
            if (device()->caps().supports(way)) edited.render(shot(way));
        SceneEdit edit;
        change(edit, parts);
        edited.step(std::move(edit));
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            EXPECT_EQ(edited.render(shot(way)).limbs, scratch.render(shot(way)).limbs) << gpu::trace_way_name(way);
        }
        Stage unedited(make(before).scene);
        EXPECT_NE(unedited.render(shot(gpu::TraceWay::Compute)).limbs, scratch.render(shot(gpu::TraceWay::Compute)).limbs) << "the edit shows nowhere";
    }

    // Which of (old place, new place) are seen (now, before), as "now:o.,before:.n".
    std::string boxes_seen(Stage& stage, gpu::TraceWay way) {
        const auto down = [](glm::vec3 p) { return TestRay{p + glm::vec3(0.0f, 0.8f, 0.0f), {0.0f, 0.0f, -1.0f}}; };
        const auto through = [](glm::vec3 p) { return TestRay{p + glm::vec3(0.0f, 0.0f, 1.5f), {0.0f, 0.0f, -1.0f}}; };
        const std::vector<TestFound> found = trace_rays(stage, way, {through(kOld), through(kNew), down(kOld)});
        EXPECT_TRUE(found[2].visible_now && found[2].visible_before);
        const auto sign = [](bool visible, char c) { return visible ? '.' : c; };
        return {'n', 'o', 'w', ':', sign(found[0].visible_now, 'o'), sign(found[1].visible_now, 'n'), ' ', 'b', 'e', 'f', 'o', 'r', 'e', ':', sign(found[0].visible_before, 'o'), sign(found[1].visible_before, 'n')};
    }
};

}  // namespace

TEST_F(SceneEdits, a_moved_instance_stands_in_its_new_place) {
    expect_edit({}, {.box_at = kNew}, [](SceneEdit& edit, const Parts& parts) { edit.set_transform(parts.moving, at(kNew)); });
}
TEST_F(SceneEdits, a_moved_lamp_lights_from_its_new_place) {
    expect_edit({}, {.lamp_at = {0.4f, -0.2f, 0.1f}}, [](SceneEdit& edit, const Parts& parts) { edit.set_transform(parts.lamp, at({0.4f, -0.2f, 0.1f})); });
}
TEST_F(SceneEdits, a_material_changes_colour_and_begins_to_emit) {
    const Variant glowing{.red = {0.1f, 0.8f, 0.3f}, .glow = {0.0f, 2.0f, 0.0f}};
    expect_edit({}, glowing, [&](SceneEdit& edit, const Parts& parts) { edit.set_material(parts.red, red(glowing)); });
    expect_edit(glowing, {}, [&](SceneEdit& edit, const Parts& parts) { edit.set_material(parts.red, red({})); });
}
TEST_F(SceneEdits, a_material_turns_translucent) {
    const Variant blend{.alpha = AlphaMode::Blend};
    expect_edit({}, blend, [&](SceneEdit& edit, const Parts& parts) { edit.set_material(parts.red, red(blend)); });
}
TEST_F(SceneEdits, a_light_is_added_and_removed) {
    expect_edit({}, {.point_light = true}, [](SceneEdit& edit, const Parts&) { edit.add(point()); });
    expect_edit({.point_light = true}, {}, [](SceneEdit& edit, const Parts& parts) { edit.remove(parts.light); });
}
TEST_F(SceneEdits, an_environment_changes) {
    expect_edit({}, {.sky = 1.5f}, [](SceneEdit& edit, const Parts&) { edit.set_environment({.scale = glm::vec3(1.5f)}); });
    expect_edit({}, {.sky = 0.0f}, [](SceneEdit& edit, const Parts&) { edit.set_environment({}); });
}
TEST_F(SceneEdits, an_instance_is_added_and_removed) {
    expect_edit({}, {.second_box = true}, [](SceneEdit& edit, const Parts& parts) { edit.add(Instance{.mesh = parts.box, .place = {.node_from_object = at(kNew)}}); });
    expect_edit({}, {.box = false}, [](SceneEdit& edit, const Parts& parts) { edit.remove(parts.moving); });
}

TEST_F(SceneEdits, the_previous_frame_is_seen_for_one_frame) {
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        SCOPED_TRACE(gpu::trace_way_name(way));
        Parts parts = make({});
        Stage stage(std::move(parts.scene));
        EXPECT_EQ(boxes_seen(stage, way), "now:o. before:o.");
        SceneEdit move;
        move.set_transform(parts.moving, at(kNew));
        stage.step(std::move(move));
        EXPECT_EQ(boxes_seen(stage, way), "now:.n before:o.");
        stage.step({});
        EXPECT_EQ(boxes_seen(stage, way), "now:.n before:.n");
        stage.step({});
        EXPECT_EQ(boxes_seen(stage, way), "now:.n before:.n");
    }
}

TEST_F(SceneEdits, what_is_added_or_removed_was_there_before_or_not) {
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        SCOPED_TRACE(gpu::trace_way_name(way));
        Parts parts = make({.alpha = AlphaMode::Mask});  // asks for the instance's material at every hit, the previous frame's too
        Stage stage(std::move(parts.scene));
        EXPECT_EQ(boxes_seen(stage, way), "now:o. before:o.");
        SceneEdit remove;
        remove.remove(parts.moving);
        stage.step(std::move(remove));
        EXPECT_EQ(boxes_seen(stage, way), "now:.. before:o.");
        SceneEdit add;
        add.add(Instance{.mesh = parts.box, .place = {.node_from_object = at(kNew)}});
        stage.step(std::move(add));
        EXPECT_EQ(boxes_seen(stage, way), "now:.n before:..");
        stage.step({});
        EXPECT_EQ(boxes_seen(stage, way), "now:.n before:.n");
    }
}

// The previous top level keeps the bottom levels that it points at, also where an edit has them built anew.
TEST_F(SceneEdits, a_change_of_structure_keeps_the_previous_frame) {
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        SCOPED_TRACE(gpu::trace_way_name(way));
        Parts parts = make({});
        Stage stage(std::move(parts.scene));
        EXPECT_EQ(boxes_seen(stage, way), "now:o. before:o.");
        SceneEdit edit;
        edit.set_transform(parts.moving, at(kNew));
        edit.set_material(parts.red, red({.alpha = AlphaMode::Mask}));
        stage.step(std::move(edit));
        EXPECT_EQ(boxes_seen(stage, way), "now:.n before:o.");
        stage.step({});
        EXPECT_EQ(boxes_seen(stage, way), "now:.n before:.n");
    }
}

// Our top level keeps its tree while it serves (bvh/moving_top.h): in step, then all to where others were.
TEST_F(SceneEdits, a_crowd_on_the_move_is_where_it_is_and_was_where_it_was) {
    constexpr uint32_t kSide = 8, kCount = kSide * kSide;
    SceneEdit edit;
    Primitive box;
    add_box(box, glm::vec3(-0.1f), glm::vec3(0.1f));
    box.material = edit.add(builtin::lambert("grey", glm::vec3(0.5f)));
    Mesh mesh{.name = "box"};
    mesh.primitives.push_back(std::move(box));
    const Handle<Mesh> box_mesh = edit.add(std::move(mesh));
    // Where i stands: in a square of one every metre, which moves on; later mixed.
    const auto stands = [](uint32_t i, uint32_t frame) {
        const uint32_t slot = frame < 5 ? i : i * 37 % kCount;
        return glm::vec3(float(slot % kSide) + 0.3f * float(frame), float(slot / kSide) + 0.2f * float(frame), 0.0f);
    };
    std::vector<Handle<Instance>> crowd;
    for (uint32_t i = 0; i < kCount; ++i) crowd.push_back(edit.add(Instance{.mesh = box_mesh, .place = {.node_from_object = at(stands(i, 0))}}));
    builtin::add_camera(edit, "front", {0.0f, 1.2f, 4.0f}, {0.0f, 0.7f, 0.0f}, 0.8f);
    Scene scene;
    const ChangeSet changes = scene.apply(std::move(edit));
    for (Handle<Instance>& handle : crowd) handle = changes.resolve(handle);
    Stage stage(std::move(scene));
    trace_rays(stage, gpu::TraceWay::Compute, {{glm::vec3(0.0f), glm::vec3(1.0f)}});
    for (uint32_t frame = 1; frame <= 8; ++frame) {
        SceneEdit move;
        for (uint32_t i = 0; i < kCount; ++i) move.set_transform(crowd[i], at(stands(i, frame)));
        stage.step(std::move(move));
        std::vector<TestRay> rays;
        for (uint32_t i = 0; i < kCount; ++i)
            for (const uint32_t when : {frame, frame - 1}) rays.push_back({stands(i, when) + glm::vec3(0.05f, 0.03f, 1.0f), {0.0f, 0.0f, -1.0f}});
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            const std::vector<TestFound> found = trace_rays(stage, way, rays);
            for (uint32_t i = 0; i < kCount; ++i) {
                const TestFound &here = found[2 * i], &there = found[2 * i + 1];
                ASSERT_TRUE(here.hit() && !here.visible_now && here.visible_before && !there.hit() && there.visible_now && !there.visible_before) << gpu::trace_way_name(way) << ", frame " << frame << ", " << i;
            }
            EXPECT_EQ(stage.scene_gpu.stats().own_top_refits, frame < 5 ? frame : frame - 5) << "no tree is made where the old one serves, one where all have mixed";
        }
    }
}

}  // namespace parhelion::testing::scene_edit_test
