// Built-in scenes: deterministic, closed where they claim to be, with the numbers that tests of renderers rely on.
#include "scene/builtin.h"

#include <gtest/gtest.h>

#include <map>

#include "scene/camera.h"
#include "scene/info.h"
#include "scene/load.h"
#include "scene/shapes.h"
#include "builtin_support.h"

namespace parhelion {

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

TEST(Builtin, scripted_edits_depend_on_the_time_alone) {
    for (const BuiltinEntry& entry : builtin_scenes()) {
        LoadedScene a = builtin_once(entry.name), b = a;
        EXPECT_FALSE(a.scripted_edits.empty()) << entry.name;
        for (const ScriptedEdit& edit : a.scripted_edits) {
            const ChangeSet moved = a.scene.apply(edit.apply(0.4));
            EXPECT_FALSE(moved.empty()) << edit.name;
            a.scene.apply(edit.apply(7.25));
            a.scene.apply(edit.apply(1.5));
        }
        for (const ScriptedEdit& edit : b.scripted_edits) b.scene.apply(edit.apply(1.5));
        EXPECT_EQ(hash_scene(a.scene), hash_scene(b.scene)) << entry.name;
    }
    const LoadedScene cornell = make_builtin("builtin:cornell");
    ASSERT_EQ(cornell.scripted_edits.size(), 2u);
    EXPECT_EQ(cornell.scripted_edits[0].name, "spin");
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

}  // namespace parhelion
