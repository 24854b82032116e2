// SceneEdit and Scene: handles, all-or-nothing edits, what changed, and one frame of memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <limits>

#include "scene/scene.h"

namespace parhelion::scene_edit_test {

namespace {

Mesh triangle(Handle<Material> material) {
    Mesh mesh{.name = "triangle"};
    mesh.primitives.push_back({.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}}, .material = material});
    return mesh;
}

glm::mat4 moved(float x) {
    glm::mat4 m(1.0f);
    m[3].x = x;
    return m;
}

// Two nodes, one below the other; an instance on the lower one, and one in the world.
struct Fixture {
    Scene scene;
    Handle<Material> material;
    Handle<Mesh> mesh;
    Handle<Node> upper, lower;
    Handle<Instance> hung, loose;

    Fixture() {
        SceneEdit edit;
        const auto m = edit.add(Material{.name = "grey"});
        const auto t = edit.add(triangle(m));
        const auto a = edit.add(Node{.name = "upper"});
        const auto b = edit.add(Node{.name = "lower", .parent = a, .local = {.translation = {0, 1, 0}}});
        const auto h = edit.add(Instance{.mesh = t, .place = {.node = b}});
        const auto l = edit.add(Instance{.mesh = t, .place = {.node_from_object = moved(5)}});
        const ChangeSet changes = scene.apply(std::move(edit));
        material = changes.resolve(m), mesh = changes.resolve(t), upper = changes.resolve(a), lower = changes.resolve(b);
        hung = changes.resolve(h), loose = changes.resolve(l);
    }
};

std::string error_of(Scene& scene, SceneEdit edit) {
    try {
        scene.apply(std::move(edit));
    } catch (const Error& error) {
        return error.line;
    }
    return {};
}

}  // namespace

TEST(SceneEdit, adds_are_listed_and_pending_handles_resolve) {
    Scene scene;
    SceneEdit edit;
    const Handle<Material> pending = edit.add(Material{.name = "one"});
    EXPECT_TRUE(pending.pending());
    const ChangeSet changes = scene.apply(std::move(edit));
    const Handle<Material> handle = changes.resolve(pending);
    EXPECT_FALSE(handle.pending());
    EXPECT_EQ(scene.get(handle).name, "one");
    EXPECT_EQ(changes.materials.added, std::vector{handle});
    EXPECT_TRUE(changes.materials.changed.empty());
    EXPECT_EQ(changes.resolve(handle), handle);
    EXPECT_THROW(scene.get(pending), Error);
    const ChangeSet other = scene.apply(SceneEdit());
    EXPECT_TRUE(other.empty());
    EXPECT_THROW(other.resolve(pending), Error);
}

TEST(SceneEdit, a_handle_never_finds_what_took_its_place) {
    Scene scene;
    SceneEdit first;
    const auto pending = first.add(Material{.name = "old"});
    const Handle<Material> old = scene.apply(std::move(first)).resolve(pending);
    SceneEdit second;
    second.remove(old);
    scene.apply(std::move(second));
    SceneEdit third;
    const auto pending_new = third.add(Material{.name = "new"});
    const Handle<Material> taken = scene.apply(std::move(third)).resolve(pending_new);
    EXPECT_EQ(taken.index, old.index);
    EXPECT_FALSE(scene.materials().contains(old));
    EXPECT_EQ(scene.materials().find(old), nullptr);
    EXPECT_THROW(scene.get(old), Error);
    SceneEdit stale;
    stale.set_material(old, Material{});
    EXPECT_NE(error_of(scene, std::move(stale)), "");
}

TEST(SceneEdit, pending_handles_of_another_edit_are_refused) {
    Scene scene;
    SceneEdit one, two;
    const auto material = one.add(Material{});
    two.add(Material{});
    two.add(triangle(material));
    EXPECT_NE(error_of(scene, std::move(two)), "");
    EXPECT_TRUE(scene.materials().empty());
}

TEST(SceneEdit, one_wrong_step_leaves_the_scene_as_it_was) {
    Fixture f;
    SceneEdit edit;
    edit.add(Material{.name = "extra"});
    edit.set_transform(f.upper, {.translation = {9, 9, 9}});
    edit.set_environment({.scale = glm::vec3(1.0f)});
    edit.remove(f.loose);
    edit.remove(Handle<Light>{3, 1});
    EXPECT_NE(error_of(f.scene, std::move(edit)), "");
    EXPECT_EQ(f.scene.materials().size(), 1u);
    EXPECT_EQ(f.scene.instances().size(), 2u);
    EXPECT_TRUE(f.scene.environment().black());
    EXPECT_EQ(f.scene.get(f.hung).place.world_from_object[3], glm::vec4(0, 1, 0, 1));
}

TEST(SceneEdit, moving_a_node_moves_all_below_it) {
    Fixture f;
    SceneEdit edit;
    edit.set_transform(f.upper, {.translation = {2, 0, 0}, .scale = glm::vec3(3.0f)});
    const ChangeSet changes = f.scene.apply(std::move(edit));
    EXPECT_EQ(f.scene.get(f.hung).place.world_from_object[3], glm::vec4(2, 3, 0, 1));
    EXPECT_EQ(f.scene.get(f.hung).place.world_from_object[0].x, 3.0f);
    EXPECT_EQ(changes.instances.changed, std::vector{f.hung});
    EXPECT_EQ(changes.nodes.changed.size(), 2u);
    EXPECT_TRUE(changes.meshes.empty() && changes.materials.empty() && !changes.environment);
}

TEST(SceneEdit, a_hidden_node_hides_all_below_it_whatever_they_say) {
    Fixture f;
    const auto show = [&](Handle<Node> node, bool visible) {
        SceneEdit edit;
        edit.set_visible(node, visible);
        return f.scene.apply(std::move(edit));
    };
    EXPECT_EQ(show(f.upper, false).instances.changed, std::vector{f.hung});
    EXPECT_FALSE(f.scene.get(f.hung).place.shown);
    EXPECT_TRUE(f.scene.get(f.loose).place.shown);
    EXPECT_TRUE(show(f.lower, true).instances.empty());
    EXPECT_TRUE(show(f.lower, false).instances.empty());
    EXPECT_TRUE(show(f.upper, true).instances.empty());  // its own node still hides it
    EXPECT_EQ(show(f.lower, true).instances.changed, std::vector{f.hung});
    EXPECT_TRUE(f.scene.get(f.hung).place.shown);
    EXPECT_TRUE(f.scene.begin_frame().empty()) << "nothing has moved";
    show(f.upper, false);
    SceneEdit edit;
    const Handle<Instance> late = edit.add(Instance{.mesh = f.mesh, .place = {.node = f.lower}});
    EXPECT_FALSE(f.scene.get(f.scene.apply(std::move(edit)).resolve(late)).place.shown);
    SceneEdit wrong;
    wrong.set_visible({}, false);
    EXPECT_NE(error_of(f.scene, std::move(wrong)), "");
}

TEST(SceneEdit, parents_and_children_may_move_in_one_edit_in_any_order) {
    for (const bool child_first : {true, false}) {
        Fixture f;
        SceneEdit edit;
        if (child_first) edit.set_transform(f.lower, {.translation = {0, 0, 7}});
        edit.set_transform(f.upper, {.translation = {1, 0, 0}});
        if (!child_first) edit.set_transform(f.lower, {.translation = {0, 0, 7}});
        const ChangeSet changes = f.scene.apply(std::move(edit));
        EXPECT_EQ(f.scene.get(f.hung).place.world_from_object[3], glm::vec4(1, 0, 7, 1));
        EXPECT_EQ(changes.instances.changed, std::vector{f.hung});
    }
}

TEST(SceneEdit, instances_can_be_placed_relative_to_their_node_or_in_the_world) {
    Fixture f;
    SceneEdit edit;
    edit.set_transform(f.hung, moved(4));
    edit.set_transform(f.loose, moved(-4));
    f.scene.apply(std::move(edit));
    EXPECT_EQ(f.scene.get(f.hung).place.world_from_object[3], glm::vec4(4, 1, 0, 1));
    EXPECT_EQ(f.scene.get(f.loose).place.world_from_object[3], glm::vec4(-4, 0, 0, 1));
}

TEST(SceneEdit, previous_transforms_are_kept_for_one_frame) {
    Fixture f;
    const auto place = [&]() { return f.scene.get(f.loose).place; };
    EXPECT_EQ(place().world_from_object_before, moved(5));  // just added: no motion
    EXPECT_TRUE(f.scene.begin_frame().empty());
    for (const float x : {6.0f, 7.0f}) {
        SceneEdit edit;
        edit.set_transform(f.loose, moved(x));
        f.scene.apply(std::move(edit));
    }
    EXPECT_EQ(place().world_from_object, moved(7));
    EXPECT_EQ(place().world_from_object_before, moved(5));
    const ChangeSet settled = f.scene.begin_frame();
    EXPECT_EQ(settled.instances.changed, std::vector{f.loose});
    EXPECT_EQ(place().world_from_object_before, moved(7));
    EXPECT_TRUE(f.scene.begin_frame().empty());
}

TEST(SceneEdit, moving_to_the_same_place_changes_nothing) {
    Fixture f;
    SceneEdit edit;
    edit.set_transform(f.loose, moved(5));
    EXPECT_TRUE(f.scene.apply(std::move(edit)).instances.empty());
    EXPECT_TRUE(f.scene.begin_frame().empty());
}

TEST(SceneEdit, what_is_in_use_cannot_be_removed) {
    Fixture f;
    const auto removing = [&](auto handle) {
        SceneEdit edit;
        edit.remove(handle);
        return error_of(f.scene, std::move(edit));
    };
    EXPECT_NE(removing(f.mesh).find("cannot remove a mesh that is still in use (instance)"), std::string::npos);
    EXPECT_NE(removing(f.material), "");
    EXPECT_NE(removing(f.upper), "");
    EXPECT_NE(removing(f.lower), "");
    SceneEdit all;
    all.remove(f.upper);
    all.remove(f.mesh);
    all.remove(f.hung);
    all.remove(f.lower);
    all.remove(f.loose);
    const ChangeSet changes = f.scene.apply(std::move(all));
    EXPECT_EQ(changes.instances.removed.size(), 2u);
    EXPECT_EQ(f.scene.nodes().size(), 0u);
    EXPECT_EQ(removing(f.material), "");
}

TEST(SceneEdit, a_deformed_form_has_the_numbers_of_its_mesh_at_rest) {
    Fixture f;
    const auto add = [&](const std::function<void(Mesh&, SceneEdit&)>& change) {
        SceneEdit edit;
        Mesh form = triangle(f.material);
        form.rest = f.mesh;
        change(form, edit);
        edit.set_pose(f.loose, edit.add(std::move(form)), {});
        return error_of(f.scene, std::move(edit));
    };
    EXPECT_NE(add([](Mesh& form, SceneEdit&) { form.primitives[0].positions.emplace_back(); }), "");
    EXPECT_NE(add([](Mesh& form, SceneEdit&) { form.primitives[0].triangles.push_back({0, 1, 2}); }), "");
    EXPECT_NE(add([](Mesh& form, SceneEdit&) { form.primitives.push_back(form.primitives[0]); }), "");
    EXPECT_NE(add([](Mesh& form, SceneEdit&) { form.rest = {7, 1}; }), "");
    // A form of a form, in the scene or in the same edit.
    EXPECT_NE(add([&](Mesh& form, SceneEdit& edit) {
                  Mesh between = triangle(f.material);
                  between.rest = f.mesh;
                  form.rest = edit.add(std::move(between));
              }),
              "");
    EXPECT_EQ(f.scene.meshes().size(), 1u);
    EXPECT_EQ(add([](Mesh& form, SceneEdit&) { form.primitives[0].positions[0].x = 3.0f; }), "");
    EXPECT_EQ(f.scene.get(f.scene.get(f.loose).posed).rest, f.mesh);
    EXPECT_EQ(add([&](Mesh& form, SceneEdit& edit) { form.rest = edit.add(triangle(f.material)); }), "");
    // What forms refer to stays.
    SceneEdit edit;
    for (const Handle<Instance> instance : {f.hung, f.loose}) edit.remove(instance);
    edit.remove(f.mesh);
    EXPECT_NE(error_of(f.scene, std::move(edit)), "");
}

TEST(SceneEdit, a_texture_may_go_in_the_edit_that_replaces_its_material) {
    Scene scene;
    SceneEdit edit;
    const auto image = edit.add(Image{.width = 1, .height = 1, .texels = {1, 2, 3, 4}});
    const auto texture = edit.add(Texture{.image = image});
    const auto material = edit.add(Material{.base_color_texture = {.texture = texture}});
    const ChangeSet changes = scene.apply(std::move(edit));
    EXPECT_EQ(scene.get(changes.resolve(material)).base_color_texture.texture, changes.resolve(texture));
    SceneEdit alone;
    alone.remove(changes.resolve(texture));
    EXPECT_NE(error_of(scene, std::move(alone)), "");
    SceneEdit both;
    both.remove(changes.resolve(texture));
    both.set_material(changes.resolve(material), Material{.name = "plain"});
    const ChangeSet after = scene.apply(std::move(both));
    EXPECT_EQ(after.materials.changed.size(), 1u);
    EXPECT_EQ(after.textures.removed.size(), 1u);
    EXPECT_TRUE(scene.textures().empty());
}

TEST(SceneEdit, added_and_removed_in_one_edit_leaves_no_trace) {
    Scene scene;
    SceneEdit edit;
    const auto material = edit.add(Material{});
    edit.set_material(material, Material{.name = "changed"});
    edit.remove(material);
    EXPECT_TRUE(scene.apply(std::move(edit)).empty());
    EXPECT_TRUE(scene.materials().empty());
}

TEST(SceneEdit, setting_a_light_or_camera_keeps_its_place) {
    Scene scene;
    SceneEdit edit;
    const auto node = edit.add(Node{.local = {.translation = {1, 2, 3}}});
    const auto light = edit.add(Light{.place = {.node = node}});
    const auto camera = edit.add(Camera{.place = {.node = node}});
    const ChangeSet changes = scene.apply(std::move(edit));
    SceneEdit second;
    second.set_light(changes.resolve(light), Light{.intensity = 4.0f});
    second.set_camera(changes.resolve(camera), Camera{.yfov = 1.0f});
    const ChangeSet after = scene.apply(std::move(second));
    EXPECT_EQ(after.lights.changed.size(), 1u);
    EXPECT_EQ(after.cameras.changed.size(), 1u);
    EXPECT_EQ(scene.get(changes.resolve(light)).intensity, 4.0f);
    EXPECT_EQ(scene.get(changes.resolve(light)).place.world_from_object[3], glm::vec4(1, 2, 3, 1));
    EXPECT_EQ(scene.get(changes.resolve(camera)).place.world_from_object[3], glm::vec4(1, 2, 3, 1));
}

TEST(SceneEdit, values_that_renderers_cannot_use_are_refused) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const auto refused = [](auto value) {
        Scene scene;
        SceneEdit edit;
        edit.add(std::move(value));
        return !error_of(scene, std::move(edit)).empty();
    };
    const auto mesh_refused = [](auto change) {
        Scene scene;
        SceneEdit edit;
        Mesh mesh = triangle(edit.add(Material{}));
        change(mesh.primitives[0]);
        edit.add(std::move(mesh));
        return !error_of(scene, std::move(edit)).empty();
    };
    EXPECT_TRUE(refused(Image{.width = 2, .height = 2, .texels = {1, 2, 3, 4}}));
    EXPECT_TRUE(refused(Image{}));
    EXPECT_TRUE(refused(Material{.roughness = nan}));
    EXPECT_TRUE(refused(Material{.emission = {-1, 0, 0}}));
    EXPECT_TRUE(refused(Material{.normal_texture = {.uv_set = 2}}));
    EXPECT_TRUE(refused(Node{.local = {.translation = {nan, 0, 0}}}));
    EXPECT_TRUE(refused(Light{.intensity = -1}));
    EXPECT_TRUE(refused(Light{.kind = LightKind::Spot, .inner_cone = 1, .outer_cone = 0.5f}));
    EXPECT_TRUE(refused(Camera{.yfov = 4}));
    EXPECT_TRUE(refused(Camera{.kind = CameraKind::Orthographic, .xmag = 0}));
    EXPECT_TRUE(refused(triangle({})));  // no material
    EXPECT_TRUE(refused(Instance{}));    // no mesh
    EXPECT_TRUE(refused(Texture{}));     // no image
    EXPECT_FALSE(mesh_refused([](Primitive&) {}));
    EXPECT_TRUE(mesh_refused([](Primitive& p) { p.triangles[0].z = 3; }));
    EXPECT_TRUE(mesh_refused([](Primitive& p) { p.normals.resize(2); }));
    EXPECT_TRUE(mesh_refused([&](Primitive& p) { p.positions[1].x = nan; }));
}

TEST(SceneEdit, change_sets_of_several_edits_join) {
    Fixture f;
    SceneEdit one;
    const auto pending = one.add(Material{.name = "new"});
    one.set_transform(f.loose, moved(1));
    ChangeSet joined = f.scene.apply(std::move(one));
    const Handle<Material> added = joined.resolve(pending);
    SceneEdit two;
    two.set_transform(f.loose, moved(2));
    two.set_material(added, Material{.name = "newer"});
    two.set_material(f.material, Material{.name = "grey"});
    joined.append(f.scene.apply(std::move(two)));
    EXPECT_EQ(joined.materials.added, std::vector{added});
    EXPECT_EQ(joined.materials.changed, std::vector{f.material});
    EXPECT_EQ(joined.instances.changed, std::vector{f.loose});
    SceneEdit three;
    three.remove(added);
    three.remove(f.loose);
    joined.append(f.scene.apply(std::move(three)));
    EXPECT_TRUE(joined.materials.added.empty() && joined.materials.removed.empty());
    EXPECT_EQ(joined.instances.removed, std::vector{f.loose});
    EXPECT_TRUE(joined.instances.changed.empty());
}

TEST(SceneEdit, copies_of_a_scene_are_independent) {
    Fixture f;
    const Scene copy = f.scene;
    SceneEdit edit;
    edit.set_transform(f.loose, moved(100));
    f.scene.apply(std::move(edit));
    EXPECT_EQ(copy.get(f.loose).place.world_from_object, moved(5));
    EXPECT_EQ(copy.get(f.loose).mesh, f.mesh);
}

TEST(Scene, bounds_hold_all_that_can_be_seen) {
    Fixture f;
    EXPECT_EQ(f.scene.bounds().min, glm::vec3(0, 0, 0));
    EXPECT_EQ(f.scene.bounds().max, glm::vec3(6, 2, 0));
    SceneEdit edit;
    edit.set_transform(f.loose, glm::mat4(0.0f));
    f.scene.apply(std::move(edit));
    EXPECT_EQ(f.scene.bounds().max, glm::vec3(1, 2, 0));
    EXPECT_TRUE(Scene().bounds().empty());
    EXPECT_EQ(f.scene.get(f.mesh).triangle_count, 1u);
}

// Random edits against a plain model of what should be there.
TEST(SceneEdit, many_random_edits_agree_with_a_simple_model) {
    uint64_t state = 1;
    const auto below = [&](uint32_t n) {
        state = state * 6364136223846793005ull + 1442695040888963407ull;
        return static_cast<uint32_t>(state >> 33) % n;
    };
    Scene scene;
    struct Entry {
        Handle<Node> handle;
        size_t parent;  // index of an entry, itself for roots
        float x;
        bool alive;
    };
    std::vector<Entry> model;
    const auto world_x = [&](size_t i) {
        float x = model[i].x;
        for (; model[i].parent != i; x += model[i].x) i = model[i].parent;
        return x;
    };
    const auto has_children = [&](size_t i) {
        return std::any_of(model.begin(), model.end(), [&](const Entry& e) { return e.alive && &e != &model[i] && e.parent == i; });
    };
    for (int round = 0; round < 300; ++round) {
        SceneEdit edit;
        std::vector<std::pair<size_t, Handle<Node>>> pending;
        for (int step = 0; step < 5; ++step) {
            const size_t i = model.empty() ? 0 : below(static_cast<uint32_t>(model.size()));
            const float x = float(below(100));
            const uint32_t action = below(4);
            if (model.empty() || action < 2) {
                const bool root = model.empty() || !model[i].alive;
                const Handle<Node> handle =
                    edit.add(Node{.parent = root ? Handle<Node>{} : model[i].handle, .local = {.translation = {x, 0, 0}}});
                pending.emplace_back(model.size(), handle);
                model.push_back({handle, root ? model.size() : i, x, true});
            } else if (model[i].alive && action == 2) {
                edit.set_transform(model[i].handle, {.translation = {x, 0, 0}});
                model[i].x = x;
            } else if (model[i].alive && !has_children(i)) {
                edit.remove(model[i].handle);
                model[i].alive = false;
            }
        }
        const ChangeSet changes = scene.apply(std::move(edit));
        for (const auto& [index, handle] : pending) model[index].handle = changes.resolve(handle);
    }
    size_t alive = 0;
    for (size_t i = 0; i < model.size(); ++i) {
        EXPECT_EQ(scene.nodes().contains(model[i].handle), model[i].alive);
        if (!model[i].alive) continue;
        ++alive;
        EXPECT_EQ(scene.get(model[i].handle).world_from_node[3].x, double(world_x(i)));
    }
    EXPECT_EQ(scene.nodes().size(), alive);
    EXPECT_GT(alive, 100u);
}

}  // namespace parhelion::scene_edit_test
