// Poses by hand: nodes, morph targets and skins at a time.
#include <gtest/gtest.h>

#include <functional>

#include <glm/gtc/matrix_transform.hpp>

#include "scene/deform.h"
#include "scene/pose.h"

namespace parhelion::pose_test {

namespace {

const glm::quat kQuarter = glm::angleAxis(1.57079633f, glm::vec3(0, 0, 1));  // +x to +y

AnimationChannel linear(Handle<Node> node, AnimatedPath path, uint32_t width, std::vector<float> values) {
    return {.node = node, .path = path, .width = width, .times = {0, 1}, .values = std::move(values)};
}

// Three pairs of vertices up a strip, at y = 0, 1, 2: of the lower bone, of both by half, and of the upper bone, which has its
// joint at y = 1 and turns by a quarter about z within a second.
Mesh strip(Handle<Material> material) {
    Primitive p{.material = material, .influence_count = 2};
    for (int row = 0; row < 3; ++row)
        for (int side = 0; side < 2; ++side) {
            p.positions.push_back({side, row, 0});
            p.normals.push_back({1, 0, 0});
            p.tangents.push_back({0, 1, 0, 1});
            p.joints.insert(p.joints.end(), {0, 1});
            const float upper = 0.5f * float(row);
            p.joint_weights.insert(p.joint_weights.end(), {1.0f - upper, upper});
        }
    p.triangles = {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 5}};
    Mesh mesh{.name = "strip"};
    mesh.primitives.push_back(std::move(p));
    return mesh;
}

// The first primitive of what an instance draws.
Primitive shape_of(const Scene& scene, Handle<Instance> instance) {
    Primitive storage;
    return drawn_shape(scene, scene.get(scene.get(instance).drawn_mesh()), 0, storage);
}

struct Strip {
    Scene scene;
    Handle<Instance> instance;
    Handle<Node> holder, lower;
    explicit Strip(const Transform& holder_at = {}, const Transform& lower_at = {}) {
        SceneEdit edit;
        const Handle<Mesh> mesh = edit.add(strip(edit.add(Material{})));
        holder = edit.add(Node{.name = "holder", .local = holder_at});
        lower = edit.add(Node{.name = "lower", .local = lower_at});
        const Handle<Node> upper = edit.add(Node{.name = "upper", .parent = lower, .local = {.translation = {0, 1, 0}}});
        const Handle<Skin> skin =
            edit.add(Skin{.joints = {lower, upper}, .inverse_bind = {glm::mat4(1.0f), glm::translate(glm::mat4(1.0f), {0, -1, 0})}});
        instance = edit.add(Instance{.mesh = mesh, .place = {.node = holder}, .skin = skin});
        edit.add(Animation{.name = "bend",
                           .channels = {linear(upper, AnimatedPath::Rotation, 4, {0, 0, 0, 1, kQuarter.x, kQuarter.y, kQuarter.z, kQuarter.w})}});
        const ChangeSet changes = scene.apply(std::move(edit));
        instance = changes.resolve(instance), holder = changes.resolve(holder), lower = changes.resolve(lower);
    }
    ChangeSet pose(double seconds) { return scene.apply(pose_at(scene, seconds)); }
    Primitive drawn() const { return shape_of(scene, instance); }
    glm::vec3 world(size_t vertex) const {
        return glm::vec3(scene.get(instance).place.world_from_object * glm::vec4(drawn().positions[vertex], 1.0f));
    }
};

// A triangle with two targets: x + 1 on all vertices with normals to +x, and z + 2 on the last.
Mesh morphing(Handle<Material> material) {
    Primitive p{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .normals = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}}, .triangles = {{0, 1, 2}}, .material = material};
    p.targets.push_back({.positions = {{1, 0, 0}, {1, 0, 0}, {1, 0, 0}}, .normals = {{1, 0, -1}, {1, 0, -1}, {1, 0, -1}}});
    p.targets.push_back({.positions = {{0, 0, 0}, {0, 0, 0}, {0, 0, 2}}});
    Mesh mesh{.name = "morphing"};
    mesh.primitives.push_back(std::move(p));
    return mesh;
}

void expect_near(glm::vec3 a, glm::vec3 b, const char* what = "") {
    EXPECT_LT(glm::length(a - b), 1e-5f) << what << " " << a.x << " " << a.y << " " << a.z;
}

void expect_bent(const Strip& s) {
    expect_near(s.world(0), {0, 0, 0});
    expect_near(s.world(1), {1, 0, 0});
    expect_near(s.world(2), {0, 1, 0});
    expect_near(s.world(3), {0.5f, 1.5f, 0});  // half way between (1, 1, 0) and (0, 2, 0)
    expect_near(s.world(4), {-1, 1, 0});
    expect_near(s.world(5), {-1, 2, 0});
}

}  // namespace

TEST(Pose, nodes_stand_where_their_channels_say) {
    Scene scene;
    SceneEdit edit;
    const Handle<Node> node = edit.add(Node{.local = {.translation = {7, 7, 7}, .scale = {2, 2, 2}}});
    const Handle<Light> light = edit.add(Light{.place = {.node = node}});
    edit.add(Animation{.channels = {linear(node, AnimatedPath::Translation, 3, {0, 0, 0, 4, 0, 0})}});
    const ChangeSet changes = scene.apply(std::move(edit));
    for (const auto& [seconds, x] : {std::pair{0.0, 0.0f}, {0.5, 2.0f}, {99.0, 4.0f}}) {
        scene.apply(pose_at(scene, seconds));
        expect_near(glm::vec3(scene.get(changes.resolve(light)).place.world_from_object[3]), {x, 0, 0});
        EXPECT_EQ(scene.get(changes.resolve(node)).local.scale, glm::vec3(2.0f));  // no channel moves it
    }
}

TEST(Pose, lights_cameras_and_visibility_follow_their_channels) {
    Scene scene;
    SceneEdit edit;
    const Handle<Node> stage = edit.add(Node{.name = "stage"}), prop = edit.add(Node{.name = "prop", .parent = stage});
    const Handle<Instance> instance = edit.add(Instance{.mesh = edit.add(strip(edit.add(Material{}))), .place = {.node = prop}});
    const Handle<Light> light = edit.add(Light{.name = "lamp", .kind = LightKind::Spot, .intensity = 2.0f, .place = {.node = prop}});
    const Handle<Camera> camera = edit.add(Camera{.name = "eye", .yfov = 1.0f, .place = {.node = prop}});
    const auto of_light = [&](AnimatedPath path, uint32_t width, std::vector<float> values) {
        return AnimationChannel{.path = path, .width = width, .times = {0, 1}, .values = std::move(values), .light = light};
    };
    AnimationChannel hide{.node = stage, .path = AnimatedPath::Visible, .interpolation = Interpolation::Step, .width = 1, .times = {0, 1}, .values = {1, 0}};
    AnimationChannel zoom{.path = AnimatedPath::Yfov, .width = 1, .times = {0, 1}, .values = {1.0f, 0.5f}, .camera = camera};
    edit.add(Animation{.channels = {hide, zoom, of_light(AnimatedPath::Color, 3, {1, 1, 1, 1, 0, -1}), of_light(AnimatedPath::Intensity, 1, {2, 4}),
                                    of_light(AnimatedPath::InnerCone, 1, {0.2f, 0.4f}), of_light(AnimatedPath::OuterCone, 1, {0.5f, 0.1f})}});
    const ChangeSet changes = scene.apply(std::move(edit));
    const Light& lamp = scene.get(changes.resolve(light));
    const auto shown = [&] { return scene.get(changes.resolve(instance)).place.shown && lamp.place.shown && scene.get(changes.resolve(camera)).place.shown; };
    scene.apply(pose_at(scene, 0.5));
    EXPECT_TRUE(shown());
    EXPECT_EQ(lamp.color, glm::vec3(1.0f, 0.5f, 0.0f));  // negative light is none
    EXPECT_EQ(lamp.intensity, 3.0f);
    EXPECT_FLOAT_EQ(lamp.outer_cone, 0.3f);
    EXPECT_FLOAT_EQ(lamp.inner_cone, 0.3f);
    EXPECT_FLOAT_EQ(scene.get(changes.resolve(camera)).yfov, 0.75f);
    EXPECT_TRUE(pose_at(scene, 0.5).empty()) << "it is as it was";
    EXPECT_FLOAT_EQ(camera_at(scene, changes.resolve(camera), 1.0).yfov, 0.5f);
    EXPECT_FLOAT_EQ(scene.get(changes.resolve(camera)).yfov, 0.75f);
    EXPECT_FALSE(scene.bounds().empty());
    const ChangeSet hidden = scene.apply(pose_at(scene, 1.0));
    EXPECT_FALSE(scene.get(changes.resolve(instance)).place.shown || lamp.place.shown);
    EXPECT_EQ(hidden.instances.changed.size(), 1u);
    EXPECT_EQ(hidden.lights.changed.size(), 1u);
    EXPECT_TRUE(scene.bounds().empty());
    scene.apply(pose_at(scene, 0.0));
    EXPECT_TRUE(shown());
}

TEST(Pose, a_strip_of_two_bones_bends_at_its_joint) {
    Strip s;
    s.pose(0.0);
    for (size_t i = 0; i < 6; ++i) expect_near(s.world(i), glm::vec3(i % 2, i / 2, 0));
    s.pose(1.0);
    expect_bent(s);
    expect_near(s.drawn().normals[5], {0, 1, 0});
    expect_near(glm::vec3(s.drawn().tangents[5]), {-1, 0, 0});
    expect_near(s.drawn().normals[0], {1, 0, 0});
    EXPECT_EQ(s.drawn().influence_count, 0u);
    EXPECT_TRUE(s.drawn().joints.empty());
    s.pose(0.5);
    expect_near(s.world(4), {-std::sqrt(0.5f), 1.0f + std::sqrt(0.5f), 0});
    EXPECT_TRUE(s.scene.get(s.scene.get(s.instance).posed).primitives[0].positions.empty()) << "the device makes the vertices";
    const Handle<Mesh> form = s.scene.get(s.instance).posed;
    EXPECT_TRUE(s.pose(0.5).meshes.empty() && s.scene.get(s.instance).posed == form) << "it stays as it is";
}

TEST(Pose, the_transform_of_the_skinned_node_itself_does_not_count) {
    Strip s({.translation = {5, -3, 2}, .rotation = kQuarter, .scale = {2, 3, -0.5f}});
    s.pose(1.0);
    expect_bent(s);
    // Mirrored by the holder, which the skin does not know: the front stays on the side that it is on at rest.
    const glm::uvec3 t = s.drawn().triangles[0];
    const glm::vec3 front = glm::cross(s.world(t.y) - s.world(t.x), s.world(t.z) - s.world(t.x));
    EXPECT_TRUE(mirrors(s.scene.get(s.instance).place.world_from_object));
    EXPECT_LT(front.z, 0.0f);  // the renderer turns it over for a mirroring transform
}

TEST(Pose, normals_go_by_the_inverse_transpose_and_mirroring_joints_keep_the_front) {
    Strip s({}, {.scale = {2, 1, 1}});
    SceneEdit edit;
    edit.set_transform(s.lower, Transform{.scale = {-2, 1, 1}});
    s.scene.apply(std::move(edit));
    s.pose(0.0);
    expect_near(s.world(1), {-2, 0, 0});
    expect_near(s.drawn().normals[1], {-1, 0, 0});
    EXPECT_EQ(s.drawn().tangents[1].w, -1.0f);
    const glm::uvec3 t = s.drawn().triangles[0];
    EXPECT_GT(glm::cross(s.world(t.y) - s.world(t.x), s.world(t.z) - s.world(t.x)).z, 0.0f);
}

TEST(Pose, a_slanted_normal_stays_upright_on_a_stretched_skin) {
    Strip s({}, {.scale = {2, 1, 1}});
    SceneEdit edit;
    Mesh mesh = s.scene.get(s.scene.get(s.instance).mesh);
    for (glm::vec3& n : mesh.primitives[0].normals) n = glm::normalize(glm::vec3(1, 1, 0));
    const Handle<Instance> old = s.instance;
    s.instance = edit.add(Instance{.mesh = edit.add(std::move(mesh)), .skin = s.scene.get(old).skin});
    const ChangeSet changes = s.scene.apply(std::move(edit));
    s.instance = changes.resolve(s.instance);
    s.pose(0.0);
    expect_near(s.drawn().normals[0], glm::normalize(glm::vec3(0.5f, 1, 0)));
}

TEST(Pose, a_skinned_node_without_size_is_not_drawn_and_breaks_nothing) {
    Strip s({.scale = {0, 0, 0}});
    s.pose(1.0);
    EXPECT_FALSE(s.scene.get(s.instance).posed);
    EXPECT_TRUE(s.scene.bounds().empty());
}

TEST(Pose, posing_again_starts_from_rest_and_leaves_no_mesh_behind) {
    Strip s;
    s.pose(0.7);
    const Handle<Mesh> first = s.scene.get(s.instance).posed;
    const ChangeSet changes = s.pose(1.0);
    expect_bent(s);
    EXPECT_EQ(s.scene.meshes().size(), 2u);
    EXPECT_FALSE(s.scene.meshes().contains(first));
    EXPECT_EQ(changes.meshes.removed, std::vector<Handle<Mesh>>{first});
    EXPECT_EQ(s.scene.get(s.scene.get(s.instance).posed).rest, s.scene.get(s.instance).mesh);
    EXPECT_EQ(changes.instances.changed, std::vector<Handle<Instance>>{s.instance});
    EXPECT_TRUE(s.scene.get(s.scene.get(s.instance).mesh).primitives[0].influence_count == 2);
}

TEST(Pose, a_joint_that_the_skin_lacks_is_an_error) {
    Strip s;
    SceneEdit edit;
    const Handle<Skin> skin = edit.add(Skin{.joints = {s.lower}, .inverse_bind = {glm::mat4(1.0f)}});
    edit.add(Instance{.mesh = s.scene.get(s.instance).mesh, .skin = skin});
    s.scene.apply(std::move(edit));
    EXPECT_THROW(pose_at(s.scene, 0.0), Error);
}

TEST(Pose, nodes_that_leave_all_measure_are_an_error) {
    Scene scene;
    SceneEdit edit;
    const Handle<Node> node = edit.add(Node{});
    edit.add(Animation{.channels = {linear(node, AnimatedPath::Translation, 3, {0, 0, 0, 1e30f, 0, 0})}});
    scene.apply(std::move(edit));
    scene.apply(pose_at(scene, 0.0));
    EXPECT_THROW(pose_at(scene, 1.0), Error);
}

TEST(Pose, morph_targets_add_up_by_weight_and_without_weight_the_mesh_itself_is_drawn) {
    Scene scene;
    SceneEdit edit;
    const Handle<Mesh> mesh = edit.add(morphing(edit.add(Material{})));
    const Handle<Node> node = edit.add(Node{});
    const Handle<Instance> pending = edit.add(Instance{.mesh = mesh, .place = {.node = node}});
    edit.add(Animation{.channels = {linear(node, AnimatedPath::Weights, 2, {0, 0, 1, 0.5f})}});
    const Handle<Instance> instance = scene.apply(std::move(edit)).resolve(pending);
    scene.apply(pose_at(scene, 1.0));
    const Primitive posed = shape_of(scene, instance);
    expect_near(posed.positions[1], {2, 0, 0});
    expect_near(posed.positions[2], {1, 1, 1});
    expect_near(posed.normals[0], {1, 0, 0});
    EXPECT_TRUE(posed.targets.empty());
    EXPECT_EQ(scene.get(instance).weights, (std::vector<float>{1.0f, 0.5f}));
    EXPECT_FLOAT_EQ(scene.bounds().max.x, 2.0f);
    scene.apply(pose_at(scene, 0.5));
    expect_near(shape_of(scene, instance).normals[0], glm::normalize(glm::vec3(0.5f, 0, 0.5f)));
    scene.apply(pose_at(scene, 0.0));
    EXPECT_FALSE(scene.get(instance).posed);
    EXPECT_EQ(scene.meshes().size(), 1u);
}

TEST(Pose, instances_with_equal_weights_share_one_posed_mesh) {
    Scene scene;
    SceneEdit edit;
    Mesh value = morphing(edit.add(Material{}));
    value.weights = {0.25f, 0.0f};
    const Handle<Mesh> mesh = edit.add(std::move(value));
    const Handle<Instance> own = edit.add(Instance{.mesh = mesh}), same = edit.add(Instance{.mesh = mesh, .weights = {0.25f, 0.0f}}),
                           other = edit.add(Instance{.mesh = mesh, .weights = {0.0f, 1.0f}});
    const ChangeSet changes = scene.apply(std::move(edit));
    EXPECT_THROW(pose_at(scene, 0.0, {}, [](uint64_t) { throw Error(ErrorCode::Failed, "too much"); }), Error);
    uint64_t bytes = 0;
    scene.apply(pose_at(scene, 0.0, {}, [&](uint64_t more) { bytes += more; }));
    const auto posed = [&](Handle<Instance> handle) { return scene.get(changes.resolve(handle)).posed; };
    EXPECT_EQ(posed(own), posed(same));
    EXPECT_FALSE(posed(own) == posed(other));
    EXPECT_EQ(scene.meshes().size(), 3u);
    EXPECT_GT(bytes, 2 * 6 * sizeof(glm::vec3));
    EXPECT_TRUE(scene.get(changes.resolve(own)).weights.empty());  // still its mesh's
}

TEST(Pose, morph_targets_act_before_the_skin) {
    Strip s;
    SceneEdit edit;
    Mesh mesh = s.scene.get(s.scene.get(s.instance).mesh);
    mesh.primitives[0].targets.push_back({.positions = std::vector<glm::vec3>(6, glm::vec3(0, 1, 0))});
    mesh.weights = {1.0f};
    const Handle<Instance> old = s.instance;
    s.instance = edit.add(Instance{.mesh = edit.add(std::move(mesh)), .skin = s.scene.get(old).skin});
    s.instance = s.scene.apply(std::move(edit)).resolve(s.instance);
    s.pose(1.0);
    expect_near(s.world(4), {-2, 1, 0});  // one further up the bone, which points to -x
}

TEST(Pose, boxes_hold_what_skin_and_weights_make_and_little_else) {
    Strip s({.translation = {1, 2, 3}, .rotation = kQuarter});
    SceneEdit edit;
    Mesh mesh = s.scene.get(s.scene.get(s.instance).mesh);
    mesh.primitives[0].targets = {{.positions = {{0, 0, 1}, {0, 0, 2}, {0, 0, 0}, {1, 0, 0}, {0, 0, 0}, {0, 3, 0}}}, {}};
    const Handle<Instance> old = s.instance;
    s.instance = edit.add(Instance{.mesh = edit.add(std::move(mesh)), .place = {.node = s.holder}, .skin = s.scene.get(old).skin, .weights = {-0.7f, 9.0f}});
    s.instance = s.scene.apply(std::move(edit)).resolve(s.instance);
    for (const double seconds : {0.0, 0.3, 1.0}) {
        s.pose(seconds);
        const Bounds box = s.scene.get(s.scene.get(s.instance).posed).bounds;
        Bounds exact;
        for (const glm::vec3& p : s.drawn().positions) exact.add(p);
        EXPECT_TRUE(glm::all(glm::lessThanEqual(box.min, exact.min)) && glm::all(glm::greaterThanEqual(box.max, exact.max))) << seconds;
        EXPECT_LT(box.diagonal(), 3.0f * exact.diagonal());
    }
}

TEST(Pose, a_form_says_one_thing_about_its_shape_and_what_exists) {
    Strip s;
    const Handle<Mesh> rest = s.scene.get(s.instance).mesh;
    const auto error = [&](const std::function<void(Mesh&)>& change) -> std::string {
        SceneEdit edit;
        Mesh form{.name = "form"};
        form.primitives.push_back({.material = s.scene.get(rest).primitives[0].material});
        form.rest = rest;
        form.deformation = MeshDeformation{.object_from_rest = std::vector<glm::mat4x3>(2, glm::mat4x3(1.0f))};
        change(form);
        edit.set_pose(s.instance, edit.add(std::move(form)), {});
        try {
            Scene(s.scene).apply(std::move(edit));
        } catch (const Error& e) {
            return e.what();
        }
        return "";
    };
    EXPECT_EQ(error([](Mesh&) {}), "");
    const std::pair<std::function<void(Mesh&)>, const char*> wrong[] = {
        {[](Mesh& m) { m.rest = {}; }, "is no form of a mesh"},
        {[](Mesh& m) { m.primitives[0].positions.resize(6); }, "both a deformation and arrays"},
        {[](Mesh& m) { m.primitives.push_back(m.primitives[0]); }, "other numbers of primitives"},
        {[](Mesh& m) { m.deformation->object_from_rest.pop_back(); }, "names joint 1, but its skin has 1"},
        {[](Mesh& m) { m.deformation->weights = {1.0f}; }, "has 1 morph weights, but 'strip' has 0 targets"},
        {[](Mesh& m) { m.deformation->weights = {NAN}; }, "morph weight that is not finite"},
        {[](Mesh& m) { m.deformation->object_from_rest[1][3].x = INFINITY; }, "joint whose place is not finite"},
        {[](Mesh& m) { m.deformation->object_from_rest[1][0].x = -1.0f; }, "a joint that mirrors"},
        {[](Mesh& m) { m.deformation->object_from_rest[1][3].x = 1e19f; }, "is deformed beyond"},
    };
    for (const auto& [change, part] : wrong) EXPECT_NE(error(change).find(part), std::string::npos) << part << ": " << error(change);
    SceneEdit edit;
    Mesh uneven = s.scene.get(rest);
    uneven.primitives[0].joint_weights[0] = 0.5f;
    edit.add(std::move(uneven));
    EXPECT_THROW(s.scene.apply(std::move(edit)), Error);
}

TEST(Pose, a_scene_that_nothing_moves_stays_untouched) {
    Scene scene;
    SceneEdit edit;
    edit.add(Instance{.mesh = edit.add(strip(edit.add(Material{})))});
    scene.apply(std::move(edit));
    EXPECT_TRUE(pose_at(scene, 3.0).empty());
}

}  // namespace parhelion::pose_test
