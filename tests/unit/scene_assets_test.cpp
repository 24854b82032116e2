// Real models, where PARHELION_ASSETS names their folder. The built-in twins are in builtin_test.cpp and the gltf tests.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "scene/info.h"
#include "scene/load.h"
#include "scene/tangents.h"

namespace parhelion::scene_assets_test {

namespace {

std::filesystem::path asset(const char* path) {
    const char* folder = std::getenv("PARHELION_ASSETS");
    return folder == nullptr ? std::filesystem::path() : std::filesystem::path(folder) / path;
}

#define PARHELION_NEED_ASSET(variable, name)            \
    const std::filesystem::path variable = asset(name); \
    if (variable.empty() || !std::filesystem::exists(variable)) GTEST_SKIP() << "PARHELION_ASSETS does not hold " << name

void expect_near(glm::vec3 a, glm::vec3 b) { EXPECT_LT(glm::length(a - b), 1e-3f) << a.x << " " << a.y << " " << a.z; }

}  // namespace

TEST(SceneAssets, cornell_nvpro_loads_with_its_camera_lamp_and_glass) {
    PARHELION_NEED_ASSET(path, "cornell_nvpro/cornellBox.gltf");
    const SceneInfo info = describe(load_scene(path.string()));
    EXPECT_EQ(info.triangles, 16720u);
    EXPECT_EQ(info.instanced_triangles, 16732u);
    EXPECT_EQ(info.cameras, std::vector<std::string>{"default"});
    EXPECT_EQ(info.emitters, 1u);
    EXPECT_EQ(info.warnings, std::vector<std::string>{"triangles without area, which are never seen: 380"});
    expect_near(info.bounds.min, glm::vec3(-5.05f));
    expect_near(info.bounds.max, {5.05f, 5.05f, 5.0f});
}

TEST(SceneAssets, flight_helmet_loads_with_all_textures_in_their_color_spaces) {
    PARHELION_NEED_ASSET(path, "flight_helmet/FlightHelmet.gltf");
    const LoadedScene loaded = load_scene(path.string());
    const SceneInfo info = describe(loaded);
    EXPECT_EQ(info.triangles, 94722u);
    EXPECT_EQ(info.textures.size(), 15u);
    EXPECT_TRUE(info.warnings.empty());
    expect_near(info.bounds.max, {0.162941f, 0.716f, 0.200029f});
    for (const TextureInfoRow& row : info.textures)
        EXPECT_EQ(row.color_space == ColorSpace::Srgb, row.name.find("BaseColor") != std::string::npos) << row.name;
    for (const auto& [handle, mesh] : loaded.scene.meshes())
        for (const Primitive& p : mesh.primitives) EXPECT_EQ(p.tangents.size(), p.positions.size());
}

TEST(SceneAssets, damaged_helmet_loads_and_gets_the_tangents_it_lacks) {
    PARHELION_NEED_ASSET(path, "damaged_helmet/DamagedHelmet.glb");
    const LoadedScene loaded = load_scene(path.string());
    const SceneInfo info = describe(loaded);
    EXPECT_EQ(info.triangles, 15452u);
    EXPECT_EQ(info.images, 5u);  // occlusion too, which is kept and not drawn
    EXPECT_EQ(info.emissive_triangles, 15452u);
    size_t zero_tangents = 0, off_plane = 0, vertices = 0;
    for (const auto& [handle, mesh] : loaded.scene.meshes())
        for (const Primitive& p : mesh.primitives) {
            ASSERT_EQ(p.tangents.size(), p.positions.size());
            for (size_t i = 0; i < p.tangents.size(); ++i, ++vertices) {
                const glm::vec3 t(p.tangents[i]);
                if (t == glm::vec3(0.0f))
                    ++zero_tangents;
                else if (std::abs(glm::dot(t, p.normals[i])) > 1e-3f || std::abs(glm::length(t) - 1.0f) > 1e-5f)
                    ++off_plane;
            }
        }
    EXPECT_EQ(off_plane, 0u);
    EXPECT_LT(zero_tangents, vertices / 100);
    EXPECT_LT(vertices, 15500u);  // few splits
}

TEST(SceneAssets, fox_runs_by_name_and_is_as_large_in_every_pose) {
    PARHELION_NEED_ASSET(path, "fox/Fox.glb");
    const SceneInfo info = describe(load_scene(path.string()));
    ASSERT_EQ(info.animations.size(), 3u);
    EXPECT_EQ(info.animations[2].name, "Run");
    EXPECT_EQ(info.skins.at(0).joints, 24u);
    EXPECT_EQ(info.meshes, 1u);
    const Bounds start = load_scene(path.string(), {.animation = "Run"}).scene.bounds();
    const Bounds later = load_scene(path.string(), {.animation = "2", .time = 0.3}).scene.bounds();
    EXPECT_GT(glm::length(later.max - start.max), 1.0f);  // the file is in centimetres
    EXPECT_NEAR(later.diagonal() / start.diagonal(), 1.0f, 0.2f);
}

TEST(SceneAssets, environments_load_from_hdr_files) {
    PARHELION_NEED_ASSET(path, "hdr_nvpro_dev/std_env.hdr");
    const Environment environment = load_environment(path);
    EXPECT_EQ(environment.width, 1500u);
    EXPECT_EQ(environment.height, 750u);
    EXPECT_EQ(environment.radiance.size(), 1500u * 750u);
    EXPECT_EQ(environment.scale, glm::vec3(1.0f));
}

// Tangents that exporters wrote against ours, on the models of the folder that have them.
TEST(SceneAssets, generated_tangents_agree_with_those_of_exporters) {
    PARHELION_NEED_ASSET(path, "flight_helmet/FlightHelmet.gltf");
    const LoadedScene loaded = load_scene(path.string());
    size_t compared = 0, close = 0, same_side = 0;
    for (const auto& [handle, mesh] : loaded.scene.meshes())
        for (const Primitive& original : mesh.primitives) {
            Primitive made = original;
            generate_tangents(made, 0);
            for (size_t i = 0; i < original.tangents.size(); ++i, ++compared) {
                close += glm::dot(glm::vec3(original.tangents[i]), glm::vec3(made.tangents[i])) > 0.98f ? 1 : 0;
                same_side += original.tangents[i].w == made.tangents[i].w ? 1 : 0;
            }
        }
    EXPECT_GT(compared, 50000u);
    EXPECT_GT(double(close) / double(compared), 0.97);
    EXPECT_GT(double(same_side) / double(compared), 0.99);
}

}  // namespace parhelion::scene_assets_test
