// Built-in scenes: deterministic, closed where they claim to be, with the numbers that tests of renderers rely on.
#include "scene/builtin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "scene/camera.h"
#include "scene/info.h"
#include "scene/load.h"
#include "scene/shapes.h"
#include "builtin_support.h"

namespace parhelion::builtin_test {

using namespace testing;

TEST(Builtin, every_scene_is_made_alike_each_time_and_has_a_camera_and_light) {
    for (const BuiltinEntry& entry : builtin_scenes()) {
        const LoadedScene &once = builtin_once(entry.name), twice = make_builtin(entry.name);
        EXPECT_EQ(hash_scene(once.scene), hash_scene(twice.scene)) << entry.name;
        const SceneInfo info = describe(once);
        EXPECT_EQ(info.name, entry.name);
        EXPECT_GE(info.cameras.size(), 1u) << entry.name;
        EXPECT_TRUE(info.emitters + info.lights.size() > 0 || info.environment) << entry.name;
        EXPECT_FALSE(info.bounds.empty()) << entry.name;
        EXPECT_FALSE(entry.help.empty());
    }
}

TEST(Builtin, an_unknown_name_lists_all) {
    try {
        make_builtin("builtin:teapot");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code, ErrorCode::Usage);
        for (const BuiltinEntry& entry : builtin_scenes()) EXPECT_NE(error.line.find(entry.name), std::string::npos);
    }
    EXPECT_EQ(load_scene("builtin:cornell").scene.source().name, "builtin:cornell");
}

TEST(Builtin, cornell_is_lambert_with_one_lamp_and_open_only_to_the_front) {
    const LoadedScene cornell = make_builtin("builtin:cornell");
    const SceneInfo info = describe(cornell);
    EXPECT_EQ(info.emitters, 1u);
    EXPECT_EQ(info.emissive_triangles, 2u);
    EXPECT_EQ(info.instances, 6u);
    for (const auto& [handle, material] : cornell.scene.materials()) {
        EXPECT_EQ(material.specular, 0.0f);
        EXPECT_EQ(material.metallic, 0.0f);
    }
    // Walls and lamp together enclose the room but for the front (z = 1), whose share of the volume integral is 4 / 3.
    double volume = 0.0;
    for (const char* part : {"walls", "left wall", "right wall", "lamp"})
        volume += signed_volume(mesh_named(cornell.scene, part).primitives[0]);
    EXPECT_NEAR(volume, -8.0 + 4.0 / 3.0, 1e-5);
    EXPECT_TRUE(closed(mesh_named(cornell.scene, "cube").primitives[0]));
    EXPECT_NEAR(signed_volume(mesh_named(cornell.scene, "cube").primitives[0]), 1.0, 1e-6);
    // Nothing stands out of the room, and the boxes stand on the floor.
    EXPECT_EQ(info.bounds.min, glm::vec3(-1, 0, -1));
    EXPECT_EQ(info.bounds.max, glm::vec3(1, 2, 1));
}

TEST(Builtin, diffuse_box_is_a_closed_room_of_the_given_material) {
    const LoadedScene box = make_builtin("builtin:diffuse-box", {.albedo = glm::vec3(0.25f), .emission = glm::vec3(0.75f)});
    const Mesh& room = mesh_named(box.scene, "room");
    EXPECT_TRUE(closed(room.primitives[0]));
    EXPECT_NEAR(signed_volume(room.primitives[0]), -8.0, 1e-6);
    const Material& material = box.scene.get(room.primitives[0].material);
    EXPECT_EQ(glm::vec3(material.base_color), glm::vec3(0.25f));
    EXPECT_EQ(material.emission, glm::vec3(0.75f));
    const Camera& camera = (*box.scene.cameras().begin()).value;
    const glm::vec3 at(camera.place.world_from_object[3]);
    EXPECT_LT(glm::max(std::abs(at.x), glm::max(std::abs(at.y), std::abs(at.z))), 0.9f);
}

TEST(Builtin, furnace_is_a_convex_flat_solid_in_constant_light) {
    const LoadedScene furnace = make_builtin("builtin:furnace", {.albedo = glm::vec3(0.5f), .emission = glm::vec3(2.0f)});
    const Primitive& sphere = mesh_named(furnace.scene, "sphere").primitives[0];
    EXPECT_TRUE(closed(sphere));
    EXPECT_TRUE(sphere.normals.empty());
    for (const glm::uvec3& t : sphere.triangles) {
        const glm::dvec3 a(sphere.positions[t.x]), b(sphere.positions[t.y]), c(sphere.positions[t.z]);
        const glm::dvec3 n = glm::cross(b - a, c - a);
        ASSERT_GT(glm::dot(n, a), 0.0);
        for (const glm::vec3& p : sphere.positions) ASSERT_LE(glm::dot(n, glm::dvec3(p) - a), 1e-7 * glm::length(n));
    }
    EXPECT_EQ(furnace.scene.environment().scale, glm::vec3(2.0f));
    EXPECT_TRUE(furnace.scene.environment().radiance.empty());
    EXPECT_EQ((*furnace.scene.materials().begin()).value.specular, 0.0f);
    const LoadedScene metal = make_builtin("builtin:furnace", {.roughness = 0.3f, .metallic = 1.0f});
    EXPECT_EQ((*metal.scene.materials().begin()).value.specular, 1.0f);
}

TEST(Builtin, textured_holds_what_real_assets_bring) {
    const LoadedScene textured = make_builtin("builtin:textured");
    const Scene& scene = textured.scene;
    bool mirrored = false, stretched = false, mask = false, blend = false, normal_map = false, emissive_map = false, transformed = false;
    std::map<uint32_t, int> uses;
    for (const auto& [handle, instance] : scene.instances()) {
        const glm::mat4& m = instance.place.world_from_object;
        mirrored = mirrored || mirrors(m);
        stretched = stretched || glm::length(glm::vec3(m[0])) != glm::length(glm::vec3(m[1]));
        ++uses[instance.mesh.index];
    }
    for (const auto& [handle, m] : scene.materials()) {
        mask = mask || m.alpha_mode == AlphaMode::Mask;
        blend = blend || m.alpha_mode == AlphaMode::Blend;
        normal_map = normal_map || m.normal_texture.texture;
        emissive_map = emissive_map || (m.emissive_texture.texture && m.emission.x > 0.0f);
        transformed = transformed || m.base_color_texture.rotation != 0.0f;
    }
    EXPECT_TRUE(mirrored && stretched && mask && blend && normal_map && emissive_map && transformed);
    EXPECT_EQ(scene.lights().size(), 1u);
    EXPECT_TRUE(std::any_of(uses.begin(), uses.end(), [](const auto& use) { return use.second >= 3; }));
    for (const auto& [handle, mesh] : scene.meshes())
        for (const Primitive& p : mesh.primitives)
            EXPECT_TRUE(!scene.get(p.material).normal_texture.texture || p.tangents.size() == p.positions.size());
}

// All that edits change, whatever slots it has come to be in.
std::vector<std::string> state_of(const Scene& scene) {
    std::vector<std::string> out;
    const auto numbers = [](const glm::mat4& m) {
        std::string text;
        for (int i = 0; i < 16; ++i) text += fmt::format(" {}", m[i / 4][i % 4]);
        return text;
    };
    for (const auto& [handle, instance] : scene.instances()) out.push_back("instance of " + scene.get(instance.drawn_mesh()).name + numbers(instance.place.world_from_object));
    for (const auto& [handle, light] : scene.lights()) out.push_back(fmt::format("light {} {}", light.name, light.intensity) + numbers(light.place.world_from_object));
    for (const auto& [handle, camera] : scene.cameras()) out.push_back("camera " + camera.name + numbers(camera.place.world_from_object));
    for (const auto& [handle, m] : scene.materials()) out.push_back(fmt::format("material {} {} {} {}", m.name, m.emission.x, m.emission.y, m.emission.z));
    const Environment& e = scene.environment();
    out.push_back(fmt::format("environment {} {}", e.scale.x, e.rotation));
    std::sort(out.begin(), out.end());
    return out;
}

TEST(Builtin, scripted_edits_depend_on_the_time_alone) {
    for (const BuiltinEntry& entry : builtin_scenes()) {
        LoadedScene a = builtin_once(entry.name), b = a;
        EXPECT_FALSE(a.scripted_edits.empty()) << entry.name;
        for (const ScriptedEdit& edit : a.scripted_edits) {
            const ChangeSet early = a.scene.apply(edit.apply(a.scene, 0.4)), late = a.scene.apply(edit.apply(a.scene, 1.4));
            EXPECT_FALSE(early.empty() && late.empty()) << edit.name;
            a.scene.apply(edit.apply(a.scene, 7.25));
            a.scene.apply(edit.apply(a.scene, 1.5));
        }
        for (const ScriptedEdit& edit : b.scripted_edits) b.scene.apply(edit.apply(b.scene, 1.5));
        EXPECT_EQ(state_of(a.scene), state_of(b.scene)) << entry.name;
    }
}

// The state of a scene's edit at a time.
std::vector<std::string> edited_state(const std::string& scene, std::string_view name, double seconds) {
    LoadedScene loaded = builtin_once(scene);
    const auto edit = std::ranges::find(loaded.scripted_edits, name, &ScriptedEdit::name);
    EXPECT_NE(edit, loaded.scripted_edits.end()) << scene << ' ' << name;
    if (edit != loaded.scripted_edits.end()) loaded.scene.apply(edit->apply(loaded.scene, seconds));
    return state_of(loaded.scene);
}

TEST(Builtin, what_is_switched_is_as_it_was_then_otherwise_and_then_as_it_was_again) {
    const std::pair<const char*, const char*> switches[] = {{"builtin:cornell", "lamp"}, {"builtin:cornell", "cut"}, {"builtin:spheres", "sun"}, {"builtin:many-lights", "switch"},
                                                            {"builtin:leak-box", "lamp"}, {"builtin:reflections", "ring"}, {"builtin:diorama", "lamp"}, {"builtin:diorama", "sun"}};
    for (const auto& [scene, name] : switches) {
        SCOPED_TRACE(fmt::format("{} {}", scene, name));
        EXPECT_EQ(edited_state(scene, name, 0.99), edited_state(scene, name, 0.0));
        EXPECT_NE(edited_state(scene, name, 1.0), edited_state(scene, name, 0.99));
        EXPECT_EQ(edited_state(scene, name, 1.99), edited_state(scene, name, 1.0));
        EXPECT_EQ(edited_state(scene, name, 2.0), edited_state(scene, name, 0.0));
    }
}

TEST(Builtin, what_comes_and_goes_is_added_and_removed) {
    for (const auto& [name, edit_name] : {std::pair("builtin:cornell", "sparks"), std::pair("builtin:many-lights", "guests")}) {
        SCOPED_TRACE(name);
        LoadedScene loaded = builtin_once(name);
        const ScriptedEdit& edit = *std::ranges::find(loaded.scripted_edits, edit_name, &ScriptedEdit::name);
        size_t added = 0, removed = 0;
        for (int frame = 0; frame < 60; ++frame) {
            const ChangeSet changes = loaded.scene.apply(edit.apply(loaded.scene, frame / 15.0));
            added += changes.lights.added.size() + changes.instances.added.size();
            removed += changes.lights.removed.size() + changes.instances.removed.size();
        }
        EXPECT_GT(added, 20u);
        EXPECT_GT(removed, 20u);
    }
}

TEST(Builtin, the_torch_moves_two_metres_a_second_inside_the_box) {
    LoadedScene cornell = make_builtin("builtin:cornell");
    const ScriptedEdit& torch = *std::ranges::find(cornell.scripted_edits, "torch", &ScriptedEdit::name);
    std::optional<glm::vec3> before;
    for (int frame = 0; frame < 100; ++frame) {
        cornell.scene.apply(torch.apply(cornell.scene, frame / 1000.0));
        std::vector<glm::vec3> torches;
        for (const auto& [handle, node] : cornell.scene.nodes())
            if (node.name == "torch") torches.push_back(glm::vec3(node.world_from_node[3]));
        ASSERT_EQ(torches.size(), 1u);
        const glm::vec3 at = torches.front();
        EXPECT_LT(std::abs(at.x), 0.94f);
        if (before) {
            EXPECT_NEAR(glm::length(at - *before) * 1000.0f, 2.0f, 2e-3f);
        }
        before = at;
    }
}

TEST(Shapes, spheres_are_closed_outward_and_their_normals_point_out) {
    for (const bool smooth : {false, true}) {
        const Primitive sphere = make_sphere(1.5f, 16, smooth);
        EXPECT_TRUE(closed(sphere));
        EXPECT_NEAR(signed_volume(sphere), 4.0 / 3.0 * 3.14159265 * 1.5 * 1.5 * 1.5, 0.4);
        for (size_t i = 0; i < sphere.normals.size(); ++i) EXPECT_GT(glm::dot(sphere.normals[i], sphere.positions[i]), 1.49f);
    }
}

TEST(Shapes, boxes_are_closed_and_face_out_or_in) {
    Primitive out, in;
    add_box(out, {-1, 0, 2}, {1, 3, 2.5f});
    add_box(in, {-1, 0, 2}, {1, 3, 2.5f}, Facing::In);
    EXPECT_TRUE(closed(out) && closed(in));
    EXPECT_NEAR(signed_volume(out), 3.0, 1e-6);
    EXPECT_NEAR(signed_volume(in), -3.0, 1e-6);
}

TEST(Shapes, a_textured_quad_shows_its_image_upright) {
    Primitive quad;
    add_textured_quad(quad, {0, 0, 0}, {2, 0, 0}, {0, 1, 0}, glm::vec2(1.0f), 4);
    EXPECT_EQ(quad.triangles.size(), 32u);
    for (size_t i = 0; i < quad.positions.size(); ++i)
        EXPECT_LT(glm::length(quad.uv0[i] - glm::vec2(quad.positions[i].x / 2, 1 - quad.positions[i].y)), 1e-6f);
}

}  // namespace parhelion::builtin_test
