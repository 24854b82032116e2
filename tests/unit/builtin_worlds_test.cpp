// The larger built-in scenes: what they hold, that they are sound, and that no light can get into the leak box.
#include <algorithm>
#include <cmath>

#ifdef __linux__
#include <sched.h>
#endif

#include <gtest/gtest.h>

#include "builtin_support.h"
#include "scene/builtin/random.h"
#include "scene/info.h"
#include "scene/load.h"
#include "scene/shapes.h"
#include "support/bvh_scene.h"

namespace parhelion::builtin_worlds_test {

using namespace testing;

namespace {

bool uses_a_texture(const Material& material) {
    return std::any_of(material_textures().begin(), material_textures().end(),
                       [&](const MaterialTexture& t) { return bool((material.*t.ref).texture); });
}

// What a primitive lacks; empty if it is sound.
std::string flaw(const Scene& scene, const Primitive& p) {
    const Material& material = scene.get(p.material);
    for (const glm::vec3& n : p.normals)
        if (!(std::abs(glm::length(n) - 1.0f) < 1e-3f)) return "a normal is not unit";
    for (const glm::vec4& t : p.tangents)
        if (const float length = glm::length(glm::vec3(t)); !(length == 0.0f || std::abs(length - 1.0f) < 1e-3f))
            return "a tangent is not unit";
    if (uses_a_texture(material) && p.uv0.size() != p.positions.size()) return "no UVs";
    if (material.normal_texture.texture && p.tangents.size() != p.positions.size()) return "no tangents";
    for (const glm::vec2& uv : p.uv0)
        if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return "a UV is not finite";
    return {};
}

// Triangles whose front looks away from their vertices' normals.
size_t turned_away(const Primitive& p) {
    size_t count = 0;
    for (const glm::uvec3& t : p.triangles) {
        if (p.normals.empty()) break;
        const glm::vec3 n = glm::cross(p.positions[t.y] - p.positions[t.x], p.positions[t.z] - p.positions[t.x]);
        count += glm::dot(n, p.normals[t.x] + p.normals[t.y] + p.normals[t.z]) < 0.0f;
    }
    return count;
}

// A scene's triangles under our own BVH, without what is not drawn.
bvh::testing::TestScene traceable(const Scene& scene) {
    std::vector<bvh::testing::TestMesh> meshes;
    std::vector<bvh::testing::TestInstance> instances;
    for (const auto& [handle, instance] : scene.instances()) {
        bvh::testing::TestMesh mesh;
        for (const Primitive& p : scene.get(instance.mesh).primitives) mesh.push_back({p.positions, p.triangles});
        instances.push_back({.mesh = uint32_t(meshes.size()), .world_from_object = instance.place.world_from_object});
        meshes.push_back(std::move(mesh));
    }
    return bvh::testing::TestScene(std::move(meshes), std::move(instances));
}

glm::vec3 camera_place(const Scene& scene, std::string_view name) {
    for (const auto& [handle, camera] : scene.cameras())
        if (camera.name == name) return glm::vec3(camera.place.world_from_object[3]);
    throw Error(ErrorCode::Failed, "no such camera");
}

// How many of the rays from inside a cavity of the leak box leave it: random ones, and ones at its corners, edges and the frame of the
// door. Hits count from the front only, as shadow rays see them.
int escapes(const bvh::testing::TestScene& scene, glm::vec3 from, glm::vec3 low, glm::vec3 high) {
    bvh::testing::Random random(5);
    std::vector<glm::vec3> targets;
    for (int i = 0; i < 2000; ++i) targets.push_back(from + random.direction());
    for (int i = 0; i < 27; ++i) targets.push_back(glm::mix(low, high, 0.5f * glm::vec3(i % 3, i / 3 % 3, i / 9)));
    for (int i = 0; i <= 50; ++i)
        for (int edge = 0; edge < 12; ++edge) {
            glm::vec3 s;
            const int axis = edge / 4;
            s[axis] = float(i) / 50.0f;
            s[(axis + 1) % 3] = float(edge % 2), s[(axis + 2) % 3] = float(edge / 2 % 2);
            targets.push_back(glm::mix(low, high, s));
            if (axis != 2) {  // the edges of the hole, in the plane of the inside of the front
                const glm::vec3 hole_low(low.x + 0.25f, low.y + 0.15f, high.z), hole_high(low.x + 0.75f, low.y + 0.85f, high.z + 0.05f);
                targets.push_back(glm::mix(hole_low, hole_high, s));
            }
        }
    const float farthest = glm::length(high - low) + 0.1f;
    const bvh::AcceptHit front = [](uint32_t, uint32_t, uint32_t, glm::vec2, bool front_facing) { return front_facing; };
    int count = 0;
    for (const glm::vec3& target : targets) {
        shared::TraversalHit hit;
        const glm::vec3 direction = glm::normalize(target - from);
        const bool found = bvh::trace_closest_host(scene.bottoms, scene.top, bvh::testing::make_ray(from, direction), hit, front);
        const glm::vec3 at = from + hit.t * direction;
        const bool inside = found && hit.t < farthest && glm::all(glm::greaterThan(at, low - 1e-3f)) &&
                            glm::all(glm::lessThan(at, high + glm::vec3(1e-3f, 1e-3f, 0.051f)));
        count += !inside;
    }
    return count;
}

}  // namespace

TEST(BuiltinWorlds, geometry_is_sound) {
    for (const BuiltinEntry& entry : builtin_scenes()) {
        const Scene& scene = builtin_once(entry.name).scene;
        for (const auto& [handle, mesh] : scene.meshes())
            for (const Primitive& p : mesh.primitives) {
                EXPECT_EQ(flaw(scene, p), "") << entry.name << ", " << mesh.name << ", " << scene.get(p.material).name;
                EXPECT_EQ(turned_away(p), 0u) << entry.name << ", " << mesh.name << ", " << scene.get(p.material).name;
            }
    }
}

TEST(BuiltinWorlds, the_rooms_have_the_triangles_of_their_size_flat_and_instanced_alike) {
    struct Size {
        uint64_t asked, triangles;
        size_t instances;
    };
    for (const Size& size : {Size{0, 10'368, 25}, Size{249'600, 249'600, 97}, Size{300'000, 249'600, 97}}) {
        const LoadedScene flat = make_builtin("builtin:room", {.triangles = size.asked}), instanced = make_builtin("builtin:room-instanced", {.triangles = size.asked});
        const SceneInfo a = describe(flat), b = describe(instanced);
        EXPECT_EQ(a.instances, 1u);
        EXPECT_EQ(b.instances, size.instances);
        EXPECT_EQ(flat.scene.get((*flat.scene.instances().begin()).value.mesh).triangle_count, size.triangles);
        uint64_t triangles = 0;
        double volume = 0;
        for (const auto& [handle, instance] : instanced.scene.instances()) {
            const Mesh& mesh = instanced.scene.get(instance.mesh);
            triangles += mesh.triangle_count;
            volume += signed_volume(mesh.primitives[0]) * double(glm::determinant(glm::mat3(instance.place.world_from_object)));
        }
        EXPECT_EQ(triangles, size.triangles);
        const Primitive& all = flat.scene.get((*flat.scene.instances().begin()).value.mesh).primitives[0];
        EXPECT_TRUE(closed(all));
        // The same spheres stand in both, and no sphere reaches through a wall: what is left of the room is neither empty nor all of it.
        EXPECT_NEAR(signed_volume(all), volume, 1e-3);
        EXPECT_EQ(a.bounds.min, glm::vec3(-5, 0, -5));
        EXPECT_EQ(a.bounds.max, glm::vec3(5, 6, 5));
        EXPECT_GT(volume, -600.0);
        EXPECT_LT(volume, -500.0);
    }
}

TEST(BuiltinWorlds, the_number_of_threads_does_not_show) {
    for (const char* name : {"builtin:forest", "builtin:diorama"}) {
        uint64_t one = 0;
#ifdef __linux__
        cpu_set_t before, single;
        ASSERT_EQ(sched_getaffinity(0, sizeof(before), &before), 0);
        CPU_ZERO(&single);
        for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu)
            if (CPU_ISSET(cpu, &before)) {
                CPU_SET(cpu, &single);
                break;
            }
        ASSERT_EQ(sched_setaffinity(0, sizeof(single), &single), 0);
        one = hash_scene(make_builtin(name).scene);
        sched_setaffinity(0, sizeof(before), &before);
#else
        one = hash_scene(make_builtin(name).scene);
#endif
        EXPECT_EQ(one, hash_scene(builtin_once(name).scene)) << name;
    }
}

TEST(BuiltinWorlds, random_numbers_are_the_same_everywhere) {
    builtin::Random random(7, 3);
    EXPECT_EQ(builtin::hash_u32(0u), 129708002u);
    EXPECT_EQ(builtin::hash_u32(1u), 2831084092u);
    float low = 1.0f, high = 0.0f, sum = 0.0f;
    for (int i = 0; i < 1000; ++i) {
        const float u = random.unit();
        low = std::min(low, u), high = std::max(high, u), sum += u;
        EXPECT_LT(random.below(5), 5u);
    }
    EXPECT_TRUE(low >= 0.0f && low < 0.01f && high < 1.0f && high > 0.99f);
    EXPECT_NEAR(sum / 1000.0f, 0.5f, 0.05f);
}

TEST(BuiltinWorlds, many_lights_has_8000_boxes_and_441_lights_that_may_vanish) {
    LoadedScene loaded = builtin_once("builtin:many-lights");
    const SceneInfo info = describe(loaded);
    EXPECT_EQ(info.instances, 8000u + 441u + 1u);
    EXPECT_EQ(info.emitters, 441u);
    EXPECT_NEAR(loaded.scene.bounds().min.x, -200.0f, 2.0f);
    for (const auto& [handle, material] : loaded.scene.materials())
        EXPECT_LE(glm::max(material.emission.x, glm::max(material.emission.y, material.emission.z)), 60000.0f);
    const auto seen = [&] {
        int count = 0;
        for (const auto& [handle, instance] : loaded.scene.instances())
            count += loaded.scene.get(loaded.scene.get(instance.mesh).primitives[0].material).emission != glm::vec3(0.0f) &&
                     drawable(instance.place.world_from_object);
        return count;
    };
    EXPECT_EQ(seen(), 441);
    loaded.scene.apply(loaded.scripted_edits.at(1).apply(loaded.scene, 0.3));
    EXPECT_GT(seen(), 441 - 221);
    EXPECT_LT(seen(), 400);
}

TEST(BuiltinWorlds, nothing_gets_out_of_a_leak_box_until_its_door_opens) {
    LoadedScene loaded = builtin_once("builtin:leak-box");
    for (const char* part : {"room", "1 cm", "5 cm", "20 cm", "door"})
        EXPECT_TRUE(closed(mesh_named(loaded.scene, part).primitives[0])) << part;
    const auto count = [&](const char* name, float wall, float x) {
        const glm::vec3 low(x - 0.5f, wall - 0.001f, -1.7f), eye = camera_place(loaded.scene, name);
        EXPECT_TRUE(glm::all(glm::greaterThan(eye, low)) && glm::all(glm::lessThan(eye, low + 1.0f)));
        return escapes(traceable(loaded.scene), eye, low, low + 1.0f);
    };
    EXPECT_EQ(count("inside 1 cm", 0.01f, -1.8f), 0);
    EXPECT_EQ(count("inside 5 cm", 0.05f, 0.0f), 0);
    EXPECT_EQ(count("inside 20 cm", 0.20f, 1.8f), 0);
    loaded.scene.apply(loaded.scripted_edits.at(1).apply(loaded.scene, 2.0));
    EXPECT_GT(count("inside 5 cm", 0.05f, 0.0f), 50);
    EXPECT_EQ(count("inside 1 cm", 0.01f, -1.8f), 0);
    // The walls are as thick as they say.
    const double solid = signed_volume(mesh_named(loaded.scene, "20 cm").primitives[0]);
    EXPECT_NEAR(solid, 1.4 * 1.4 * 1.4 - 1.0, 1e-4);
}

TEST(BuiltinWorlds, only_the_forest_takes_a_number_of_triangles) {
    LoadOptions options;
    options.builtin.triangles = 2000;
    EXPECT_NO_THROW(load_scene("builtin:forest", options));
    for (const char* name : {"builtin:cornell", "scene.glb"}) {
        try {
            load_scene(name, options);
            FAIL() << name;
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Usage);
            EXPECT_EQ(error.where, "--triangles");
        }
    }
}

TEST(BuiltinWorlds, forest_has_about_as_many_triangles_as_asked_for_and_no_tree_twice) {
    for (const uint64_t triangles : {2000ull, 30'000ull, 500'000ull}) {
        const LoadedScene forest = make_builtin("builtin:forest", {.triangles = triangles});
        const SceneInfo info = describe(forest);
        EXPECT_NEAR(double(info.triangles), double(triangles), 0.01 * double(triangles));
        EXPECT_EQ(info.triangles, info.instanced_triangles);  // nothing is placed twice
        EXPECT_EQ(info.meshes, info.instances);
    }
    for (const uint64_t triangles : {1ull, 7ull, 100ull})
        EXPECT_GE(describe(make_builtin("builtin:forest", {.triangles = triangles})).triangles, 1u);
    const Scene& scene = builtin_once("builtin:forest").scene;
    EXPECT_NE(mesh_named(scene, "tree 0").primitives[1].positions, mesh_named(scene, "tree 1").primitives[1].positions);
    EXPECT_EQ(scene.get(mesh_named(scene, "tree 0").primitives[1].material).alpha_mode, AlphaMode::Mask);
}

TEST(BuiltinWorlds, diorama_and_reflections_have_their_materials_and_edits) {
    const LoadedScene &diorama = builtin_once("builtin:diorama"), &reflections = builtin_once("builtin:reflections");
    const SceneInfo info = describe(diorama);
    EXPECT_TRUE(info.triangles >= 50'000 && info.triangles <= 150'000) << info.triangles;
    bool glass = false, metal = false, mask = false, lamp = false;
    for (const auto& [handle, m] : diorama.scene.materials()) {
        glass = glass || m.transmission > 0.5f;
        metal = metal || (m.metallic == 1.0f && !m.base_color_texture.texture);
        mask = mask || m.alpha_mode == AlphaMode::Mask;
        lamp = lamp || m.emission.x > 1000.0f;
    }
    EXPECT_TRUE(glass && metal && mask && lamp);
    std::vector<std::string> names;
    for (const ScriptedEdit& edit : diorama.scripted_edits) names.push_back(edit.name);
    std::sort(names.begin(), names.end());
    EXPECT_EQ(names, (std::vector<std::string>{"ball", "door", "lamp", "lights", "robot", "sun", "walk"}));
    std::vector<float> mirrors;
    for (const auto& [handle, m] : reflections.scene.materials())
        if (m.metallic == 1.0f) mirrors.push_back(m.roughness);
    EXPECT_GE(std::count(mirrors.begin(), mirrors.end(), 0.0f), 3);
    for (const float roughness : {0.0314f, 0.12f, 0.24f, 1.0f})
        EXPECT_GE(std::count(mirrors.begin(), mirrors.end(), roughness), 1) << roughness;
}

TEST(BuiltinWorlds, animate_puts_a_scene_into_the_state_of_its_time) {
    LoadedScene expected = builtin_once("builtin:leak-box");
    expected.scene.apply(expected.scripted_edits.at(1).apply(expected.scene, 1.25));
    LoadOptions options;
    options.animate = "door";
    options.time = 1.25;
    EXPECT_EQ(hash_scene(load_scene("builtin:leak-box", options).scene), hash_scene(expected.scene));
    EXPECT_NE(hash_scene(builtin_once("builtin:leak-box").scene), hash_scene(expected.scene));
    const auto line = [&](const char* scene) {
        try {
            load_scene(scene, options);
        } catch (const Error& error) {
            EXPECT_EQ(error.code, ErrorCode::Usage);
            return error.line;
        }
        return std::string();
    };
    EXPECT_NE(line("builtin:cornell").find("it has spin"), std::string::npos) << line("builtin:cornell");
    EXPECT_NE(line("builtin:furnace").find("it has swing"), std::string::npos);
    EXPECT_NE(line("model.glb").find("scripted edits belong to built-in scenes"), std::string::npos);
}

TEST(Shapes, round_shapes_are_closed_and_face_out) {
    const glm::vec2 profile[] = {{0.0f, 0.0f}, {0.5f, 0.0f}, {0.7f, 0.4f}, {0.3f, 0.9f}, {0.0f, 1.0f}};
    const glm::vec3 knots[] = {{0, 0, 0}, {0, 1, 0}, {1, 2, 0}, {1, 2, 1}};
    const float radii[] = {0.0f, 0.1f, 0.1f, 0.0f};
    const struct {
        const char* name;
        Primitive shape;
        double volume;  // 0: only that it is positive
    } shapes[] = {{"rounded box", make_rounded_box({1.0f, 2.0f, 3.0f}, 0.01f), 6.0},
                  {"cushion", make_cushion({1.0f, 0.4f, 1.0f}, 0.1f, 0.05f), 0.0},
                  {"lathe", make_lathe(profile, 24), 0.0},
                  {"cylinder", make_cylinder(0.5f, 2.0f, 0.001f, 64), 3.14159265 / 2.0},
                  {"cone", make_cone(0.5f, 3.0f, 64), 3.14159265 / 4.0},
                  {"torus", make_torus(1.0f, 0.2f, 64, 32), 2.0 * 3.14159265 * 3.14159265 * 0.04},
                  {"tube", make_tube(knots, radii, 12), 0.0}};
    for (const auto& [name, shape, volume] : shapes) {
        EXPECT_TRUE(closed(shape)) << name;
        EXPECT_EQ(turned_away(shape), 0u) << name;
        EXPECT_EQ(shape.normals.size(), shape.positions.size()) << name;
        EXPECT_EQ(shape.uv0.size(), shape.positions.size()) << name;
        if (volume > 0.0) {
            EXPECT_NEAR(signed_volume(shape), volume, 0.02 * volume) << name;
        }
        EXPECT_GT(signed_volume(shape), 0.0) << name;
    }
}

TEST(Shapes, appending_moves_positions_and_normals) {
    Primitive two = make_rounded_box(glm::vec3(1.0f), 0.1f);
    const size_t vertices = two.positions.size();
    const Transform local{.translation = {5.0f, 0.0f, 0.0f}, .scale = {1.0f, 3.0f, 1.0f}};
    append(two, make_rounded_box(glm::vec3(1.0f), 0.1f), matrix_of(local));
    EXPECT_EQ(two.positions.size(), 2 * vertices);
    EXPECT_TRUE(closed(two));
    EXPECT_EQ(turned_away(two), 0u);
    EXPECT_NEAR(signed_volume(two), 4.0 * signed_volume(make_rounded_box(glm::vec3(1.0f), 0.1f)), 1e-3);
}

}  // namespace parhelion::builtin_worlds_test
