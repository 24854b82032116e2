// Loading by name, environments from files, and what info says.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>

#include "base/platform.h"
#include "gltf_make.h"
#include "image/encode.h"
#include "scene/info.h"
#include "scene/load.h"

namespace parhelion::test::scene_load_test {

namespace fs = std::filesystem;

namespace {

class SceneLoad : public ::testing::Test {
protected:
    void SetUp() override {
        folder_ = fs::temp_directory_path() / fmt::format("parhelion-load-{}-{}", platform::process_id(),
                                                          ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }
    fs::path folder_;
};

image::ImageF ramp(uint32_t width, uint32_t height) {
    image::ImageF image = image::make_image(width, height, {"R", "G", "B"});
    for (size_t c = 0; c < 3; ++c)
        for (size_t i = 0; i < image.pixel_count(); ++i) image.plane(c)[i] = float(i) + 100.0f * float(c);
    return image;
}

}  // namespace

TEST_F(SceneLoad, glb_and_gltf_are_told_apart_by_content) {
    GltfMaker maker;
    maker.add_triangle();
    const std::vector<std::byte> glb = maker.glb();
    std::ofstream(folder_ / "binary.gltf", std::ios::binary)
        .write(reinterpret_cast<const char*>(glb.data()), static_cast<std::streamsize>(glb.size()));
    std::ofstream(folder_ / "text.glb") << maker.text();
    for (const char* name : {"binary.gltf", "text.glb"}) {
        const LoadedScene loaded = load_scene((folder_ / name).string());
        EXPECT_EQ(loaded.scene.meshes().size(), 1u);
        EXPECT_TRUE(contains(loaded.scene.source().name, name));
        EXPECT_EQ(loaded.scene.source().file_bytes, fs::file_size(folder_ / name));
    }
}

TEST_F(SceneLoad, a_name_that_is_no_scene_says_what_is) {
    try {
        load_scene("cornell");
        FAIL();
    } catch (const Error& error) {
        EXPECT_CONTAINS(error.line, "cornell: there is no such file (SCENE is a .gltf or .glb file, or builtin:NAME)");
    }
    std::ofstream(folder_ / "picture.png") << "\x89PNG something else";
    EXPECT_THROW(load_scene((folder_ / "picture.png").string()), Error);
}

TEST_F(SceneLoad, environments_keep_their_rows_and_mend_what_no_light_can_be) {
    image::ImageF image = ramp(4, 2);
    image.plane(0)[1] = -3.0f;
    image.plane(1)[2] = std::numeric_limits<float>::quiet_NaN();
    image.plane(2)[3] = std::numeric_limits<float>::infinity();
    image::write_exr(folder_ / "sky.exr", image, image::ExrPrecision::Float);
    const Environment sky = load_environment(folder_ / "sky.exr");
    EXPECT_EQ(sky.name, "sky.exr");
    ASSERT_EQ(sky.radiance.size(), 8u);
    EXPECT_EQ(sky.radiance[0], glm::vec3(0, 100, 200));
    EXPECT_EQ(sky.radiance[1], glm::vec3(0, 101, 201));
    EXPECT_EQ(sky.radiance[2].y, 0.0f);
    EXPECT_EQ(sky.radiance[3].z, 65504.0f);
    EXPECT_EQ(sky.radiance[5], glm::vec3(5, 105, 205));
    EXPECT_EQ(sky.scale, glm::vec3(1.0f));
    Scene scene;
    SceneEdit edit;
    edit.set_environment(sky);
    EXPECT_TRUE(scene.apply(std::move(edit)).environment);
    EXPECT_THROW(load_environment(folder_ / "none.hdr"), Error);
    std::ofstream(folder_ / "broken.hdr") << "#?RADIANCE\n\n-Y 4 +X";
    EXPECT_THROW(load_environment(folder_ / "broken.hdr"), Error);
}

TEST(SceneInfo, counts_what_a_scene_holds) {
    const SceneInfo info = describe(make_builtin("builtin:textured"));
    EXPECT_EQ(info.meshes, 6u);
    EXPECT_EQ(info.instances, 8u);
    EXPECT_EQ(info.textures.size(), 5u);
    EXPECT_EQ(info.instanced_triangles - info.triangles, 2u * 1520u);  // the statue stands three times
    ASSERT_EQ(info.lights.size(), 1u);
    EXPECT_EQ(info.lights[0].name, "lamp");
    EXPECT_EQ(info.emitters, 1u);
    EXPECT_EQ(info.scripted_edits.size(), 2u);
    const std::string text = format_info(info);
    for (const char* part : {"builtin:textured", "8 instances", "64x64 sRGB 'checker'", "point 'lamp' (30, 28.5, 27) candela", "sway: "})
        EXPECT_CONTAINS(text, part);
}

TEST(SceneInfo, escapes_names_that_come_from_files) {
    GltfMaker maker;
    maker.add_triangle();
    maker.doc["asset"]["generator"] = "evil\x1b[2J";
    maker.doc["extensionsUsed"] = {"X\n"};
    LoadedScene loaded;
    loaded.scene = maker.load();
    const std::string text = format_info(describe(loaded));
    EXPECT_CONTAINS(text, "evil\\x1b[2J");
    EXPECT_EQ(text.find('\x1b'), std::string::npos);
    EXPECT_FALSE(contains(text, "X\n,"));
}

}  // namespace parhelion::test::scene_load_test
