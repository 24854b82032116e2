// The previous frame's rows and placements, as shaders see them (shaders/scene/previous.glsl): what a frame kept for the next finds
// its instances and lights again while others come, go and move.
#include <map>

#include "scene/builtin/random.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "shared/scene.h"
#include "support/trace_rays.h"

namespace parhelion::testing::previous_frame_test {
namespace {

constexpr uint32_t kGone = shared::kNone;

glm::mat4 at(glm::vec3 position) { return glm::mat4(glm::vec4(1, 0, 0, 0), glm::vec4(0, 1, 0, 0), glm::vec4(0, 0, 1, 0), glm::vec4(position, 1)); }

// A row of every table, as previous.comp writes it.
struct Row {
    uint32_t instance_before, instance_now, emitter_now, emitter_kind, emitter_instance;
    float emitter_intensity;
    glm::vec3 place, place_before;
    uint32_t emitter_count, emitter_before_count, instance_before_count;
    float lit_before;
};

std::vector<Row> read_rows(Stage& stage) {
    constexpr uint32_t kCount = 64;
    const gpu::Buffer output(stage.frame.device(), "test/rows", kCount * sizeof(Row));
    stage.frame.compute("device/previous").scene(stage.scene_gpu.binding()).write("rows", output).push(glm::uvec2(kCount, stage.scene_gpu.stats().instance_rows)).over(kCount);
    const gpu::Buffer copy = stage.frame.read_back(output);
    stage.frame.run();
    const auto rows = copy.mapped_as<Row>();
    return {rows.begin(), rows.end()};
}

// Boxes that are told apart by their height, of a material that glows and one that does not, and lights by their intensity.
class PreviousFrame : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        SceneEdit edit;
        const Handle<Material> materials[2] = {edit.add(builtin::lambert("dull", glm::vec3(0.5f))), edit.add(glowing(1.0f))};
        for (int i = 0; i < 2; ++i) {
            Mesh mesh{.name = "box"};
            add_box(mesh.primitives.emplace_back(), glm::vec3(-0.1f), glm::vec3(0.1f));
            mesh.primitives[0].material = materials[i];
            meshes[i] = edit.add(std::move(mesh));
        }
        builtin::add_camera(edit, "front", {0.0f, 1.2f, 4.0f}, {0.0f, 0.7f, 0.0f}, 0.8f);
        const ChangeSet changes = scene.apply(std::move(edit));
        for (Handle<Mesh>& mesh : meshes) mesh = changes.resolve(mesh);
        glow = changes.resolve(materials[1]);
    }
    static Material glowing(float nits) { return builtin::lambert("glow", glm::vec3(0.5f), glm::vec3(nits)); }
    Instance box(int kind, float x) { return {.mesh = meshes[kind], .place = {.node_from_object = at({x, float(next_name++), 0.0f})}}; }
    Light light() { return {.kind = LightKind::Point, .color = glm::vec3(1.0f), .intensity = float(next_name++)}; }

    Scene scene;
    Handle<Mesh> meshes[2];
    Handle<Material> glow;
    int next_name = 1;
};

// What a frame has drawn: rows by name.
struct Names {
    std::map<float, uint32_t> instances, emitters;  // a light's intensity; minus the height of an instance; 0: the environment
    std::map<float, glm::vec3> places;
};

Names names_of(const Scene& scene, const std::vector<Row>& rows) {
    Names out;
    for (const auto& [handle, instance] : scene.instances()) {
        const float name = instance.place.world_from_object[3].y;
        for (uint32_t row = 0; row < rows.size(); ++row)
            if (rows[row].place.y == name) out.instances[name] = row, out.places[name] = rows[row].place;
    }
    for (uint32_t row = 0; row < rows[0].emitter_count; ++row) {
        const Row& r = rows[row];
        const float name = r.emitter_kind == shared::kEmitterMesh ? -rows[r.emitter_instance].place.y : r.emitter_kind == shared::kEmitterEnvironment ? 0.0f : r.emitter_intensity;
        out.emitters[name] = row;
    }
    return out;
}

uint32_t row_of(const std::map<float, uint32_t>& rows, float name) {
    const auto found = rows.find(name);
    return found == rows.end() ? kGone : found->second;
}

void expect_translated(const Names& before, const Names& now, const std::vector<Row>& rows) {
    for (const auto& [name, row] : now.instances) {
        EXPECT_EQ(rows[row].instance_before, row_of(before.instances, name)) << "instance " << name;
        EXPECT_EQ(rows[row].place_before, before.places.contains(name) ? before.places.at(name) : now.places.at(name)) << "instance " << name;
    }
    for (const auto& [name, row] : before.instances) {
        EXPECT_EQ(rows[row].instance_now, row_of(now.instances, name)) << "instance " << name;
        EXPECT_EQ(rows[row].place_before, before.places.at(name)) << "instance " << name;
    }
    EXPECT_EQ(rows[0].emitter_before_count, before.emitters.size());
    for (const auto& [name, row] : before.emitters) EXPECT_EQ(rows[row].emitter_now, row_of(now.emitters, name)) << "emitter " << name;
    EXPECT_EQ(rows[before.emitters.size()].emitter_now, kGone) << "the previous frame had no such row";
}

}  // namespace

TEST_F(PreviousFrame, rows_are_found_again_while_others_come_and_go) {
    Stage stage(std::move(scene), {.hardware = false});
    builtin::Random random(11u);
    std::vector<Handle<Instance>> boxes;
    std::vector<Handle<Light>> lights;
    bool lit = true;
    Names before;
    size_t kept = 0, moved_rows = 0, gone = 0;
    for (int frame = 0; frame < 60; ++frame) {
        SCOPED_TRACE(frame);
        SceneEdit edit;
        std::vector<Handle<Instance>> new_boxes;
        std::vector<Handle<Light>> new_lights;
        const uint32_t what = frame % 5 == 4 ? 0u : random.below(64u);  // every fifth frame nothing happens
        const auto remove_one = [&](auto& handles) {
            if (handles.empty()) return;
            const auto chosen = handles.begin() + random.below(static_cast<uint32_t>(handles.size()));
            edit.remove(*chosen);
            handles.erase(chosen);
        };
        if (what & 1) remove_one(boxes), remove_one(boxes);
        if (what & 2) remove_one(lights);
        if (what & 4)
            for (int i = 0; i < 3; ++i) new_boxes.push_back(edit.add(box(int(random.below(2u)), 0.0f)));
        if (what & 8) new_lights.push_back(edit.add(light())), new_lights.push_back(edit.add(light()));
        if (what & 16)
            for (const Handle<Instance> handle : boxes) {
                glm::mat4 place = stage.scene.get(handle).place.world_from_object;
                place[3].x = random.range(-1.0f, 1.0f);
                edit.set_transform(handle, place);
            }
        if (what & 32) lit = !lit, edit.set_material(glow, glowing(lit ? 1.0f : 0.0f)), edit.set_environment({.scale = glm::vec3(random.below(2u) == 0u ? 0.0f : 1.0f)});
        const ChangeSet changes = stage.step(std::move(edit));
        for (const Handle<Instance> handle : new_boxes) boxes.push_back(changes.resolve(handle));
        for (const Handle<Light> handle : new_lights) lights.push_back(changes.resolve(handle));
        stage.scene_gpu.finish(stage.frame);
        const std::vector<Row> rows = read_rows(stage);
        ASSERT_LT(std::max<size_t>(rows[0].emitter_count, stage.scene_gpu.stats().instance_rows), rows.size());
        const Names now = names_of(stage.scene, rows);
        ASSERT_EQ(now.instances.size(), boxes.size());
        expect_translated(before, now, rows);
        for (const auto& [name, row] : before.emitters) (row_of(now.emitters, name) == row ? kept : row_of(now.emitters, name) == kGone ? gone : moved_rows) += 1;
        before = now;
    }
    EXPECT_TRUE(kept > 20 && moved_rows > 20 && gone > 20) << kept << ' ' << moved_rows << ' ' << gone;
}

// A viewer draws the old scene while the new one comes in: it must not be taken for the frame in which something moved, again and again.
TEST_F(PreviousFrame, a_scene_that_waits_for_the_next_stands_still) {
    SceneEdit edit;
    const Handle<Instance> pending = edit.add(box(0, 0.0f));
    edit.add(light());
    const Handle<Light> pending_second = edit.add(light());
    const ChangeSet changes = scene.apply(std::move(edit));
    const Handle<Light> second = changes.resolve(pending_second);
    const Handle<Instance> moving = changes.resolve(pending);
    const float height = scene.get(moving).place.world_from_object[3].y;
    const TestRay here{{0.0f, height, 1.0f}, {0.0f, 0.0f, -1.0f}}, there{{1.0f, height, 1.0f}, {0.0f, 0.0f, -1.0f}};
    Stage stage(std::move(scene), {.slice_bytes = 1024, .slice_triangles = 1, .geometry_buffer_bytes = 4096});
    stage.scene_gpu.finish(stage.frame);
    EXPECT_EQ(read_rows(stage)[0].instance_before, kGone) << "before the first frame there was none";
    stage.step({});
    stage.scene_gpu.finish(stage.frame);
    SceneEdit move;
    move.set_transform(moving, at({1.0f, height, 0.0f}));
    move.remove(*stage.scene.lights().handle_at(0));
    stage.step(std::move(move));
    stage.scene_gpu.finish(stage.frame);
    std::vector<Row> rows = read_rows(stage);
    EXPECT_EQ(rows[0].place_before.x, 0.0f);
    EXPECT_EQ(rows[1].emitter_now, 0u);

    SceneEdit more;
    Mesh ball{.name = "ball"};
    ball.primitives.push_back(make_sphere(0.4f, 12, true));
    ball.primitives[0].material = glow;
    more.add(Instance{.mesh = more.add(std::move(ball)), .place = {.node_from_object = at({0.0f, 50.0f, 0.0f})}});
    more.remove(second);
    stage.step(std::move(more));
    int waited = 0;
    for (; !stage.scene_gpu.update(stage.frame).complete && waited < 1000; ++waited) {
        if (waited % 16 == 0) {
            rows = read_rows(stage);
            EXPECT_EQ(rows[0].place.x, 1.0f);
            EXPECT_EQ(rows[0].place_before.x, 1.0f) << waited;
            EXPECT_EQ(rows[0].instance_before, 0u);
            EXPECT_EQ(rows[0].emitter_now, 0u);
            EXPECT_EQ(rows[1].emitter_now, kGone) << "this frame's predecessor had one light";
        } else {
            stage.frame.run();
        }
        stage.step({});
    }
    EXPECT_GT(waited, 16);
    rows = read_rows(stage);
    EXPECT_EQ(rows[0].place_before.x, 1.0f);
    EXPECT_EQ(rows[0].emitter_now, kGone) << "the light went while the ball came in";
    EXPECT_EQ(rows[1].instance_before, kGone);
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        const std::vector<TestFound> found = trace_rays(stage, way, {here, there});
        EXPECT_TRUE(found[0].visible_before && !found[1].visible_before) << gpu::trace_way_name(way);
    }
}

TEST_F(PreviousFrame, lights_tell_how_bright_they_were) {
    SceneEdit edit;
    edit.add(box(1, 0.0f));
    const Handle<Light> pending_first = edit.add(light()), pending_second = edit.add(light());
    const ChangeSet changes = scene.apply(std::move(edit));
    const Handle<Light> first = changes.resolve(pending_first), second = changes.resolve(pending_second);
    Stage stage(std::move(scene));
    const auto frame = [&](SceneEdit next) {
        stage.step(std::move(next));
        stage.scene_gpu.finish(stage.frame);
        const std::vector<Row> rows = read_rows(stage);
        std::vector<float> ratios;
        for (uint32_t row = 0; row < rows[0].emitter_count; ++row) ratios.push_back(rows[row].lit_before);
        return ratios;
    };
    frame({});
    EXPECT_EQ(frame({}), std::vector<float>(3, 1.0f)) << "nothing changes";
    EXPECT_EQ(stage.scene_gpu.light_switches(), 0u);
    SceneEdit brighter;
    Light copy = stage.scene.get(second);
    copy.intensity *= 4.0f;
    brighter.set_light(second, copy);
    brighter.set_material(glow, glowing(2.0f));
    EXPECT_EQ(frame(std::move(brighter)), (std::vector<float>{0.5f, 1.0f, 0.25f}));
    EXPECT_EQ(stage.scene_gpu.light_switches(), 1u);
    EXPECT_EQ(frame({}), std::vector<float>(3, 1.0f)) << "they shine on";
    SceneEdit moved;
    moved.set_transform(second, glm::translate(copy.place.node_from_object, {0.5f, 0.0f, 0.0f}));
    EXPECT_EQ(frame(std::move(moved)), (std::vector<float>{1.0f, 1.0f, 0.0f})) << "what is elsewhere now did not shine from there";
    EXPECT_EQ(stage.scene_gpu.light_switches(), 1u) << "it moves, and is not switched";
    SceneEdit other;
    other.remove(first);
    other.add(light());
    EXPECT_EQ(frame(std::move(other)), (std::vector<float>{1.0f, 0.0f, 1.0f})) << "a light in the place of another is new";
}

TEST_F(PreviousFrame, another_scene_has_no_past) {
    SceneEdit edit;
    edit.add(box(0, 0.0f));
    edit.add(light());
    scene.apply(std::move(edit));
    Scene other = scene;
    Stage stage(std::move(scene), {.hardware = false});
    for (int frame = 0; frame < 2; ++frame) stage.scene_gpu.finish(stage.frame), stage.step({});
    EXPECT_EQ(read_rows(stage)[0].emitter_now, 0u);
    stage.scene_gpu.sync(other);
    stage.scene_gpu.finish(stage.frame);
    const std::vector<Row> rows = read_rows(stage);
    EXPECT_EQ(rows[0].emitter_now, kGone);
    EXPECT_EQ(rows[0].instance_before, kGone);
}

}  // namespace parhelion::testing::previous_frame_test
