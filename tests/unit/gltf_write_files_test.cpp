// Where exported scenes go: names beside F.gltf, what is replaced and what never is, all files or none.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "base/file.h"
#include "base/platform.h"
#include "gltf_make.h"
#include "scene/gltf/write.h"
#include "scene/load.h"
#include "support/everything_scene.h"
#include "support/scene_compare.h"

namespace parhelion::test::gltf_write_files_test {

namespace fs = std::filesystem;

namespace {

using testing::everything_scene;
using testing::scene_difference;

class GltfWriteFiles : public ::testing::Test {
protected:
    void SetUp() override {
        folder = fs::temp_directory_path() / fmt::format("parhelion-export-{}-{}", platform::process_id(),
                                                         ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::create_directories(folder / "again");
    }
    void TearDown() override {
        fs::permissions(folder, fs::perms::owner_all);
        fs::remove_all(folder);
    }
    std::vector<std::string> names() const {
        std::vector<std::string> out;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder))
            if (entry.is_regular_file()) out.push_back(entry.path().filename().string());
        std::ranges::sort(out);
        return out;
    }
    static std::string error_of_writing(const fs::path& path, const GltfWriteOptions& options = {}) {
        try {
            write_gltf(everything_scene(), path, options);
        } catch (const Error& error) {
            return error.line;
        }
        return {};
    }
    static Scene load(const fs::path& path) { return load_scene(path.string(), {.median_order = false, .keep_encoded = true, .at_rest = true}).scene; }
    fs::path folder;
};

}  // namespace

TEST_F(GltfWriteFiles, a_gltf_has_its_buffer_and_images_beside_it_and_reads_back_the_same) {
    const Scene scene = everything_scene();
    const GltfWritten written = write_gltf(scene, folder / "a scene.gltf");
    EXPECT_EQ(names(), (std::vector<std::string>{"a scene-kept_as_it_was.png", "a scene-plain.png", "a scene.bin", "a scene.gltf"}));
    ASSERT_EQ(written.files.size(), 4u);
    EXPECT_EQ(written.files.back(), folder / "a scene.gltf");
    uint64_t bytes = 0;
    for (const fs::path& file : written.files) bytes += fs::file_size(file);
    EXPECT_EQ(written.bytes, bytes);
    const Scene again = load(folder / "a scene.gltf");
    EXPECT_EQ(scene_difference(scene, again), "");
    write_gltf(again, folder / "again" / "a scene.gltf");
    for (const std::string& name : names()) EXPECT_EQ(read_text_file(folder / name, 1 << 30), read_text_file(folder / "again" / name, 1 << 30)) << name;
}

TEST_F(GltfWriteFiles, images_of_one_name_or_none_have_files_of_their_own) {
    SceneEdit edit;
    Handle<Texture> last;
    for (const char* name : {"wood", "textures/Wood.jpg", "wood", ""}) {
        const Handle<Image> image = edit.add(Image{.name = name, .width = 1, .height = 1, .texels = {1, 2, 3, 4}});
        last = edit.add(Texture{.image = image});
        edit.add(Material{.base_color_texture = {.texture = last}});
    }
    Scene scene;
    scene.apply(std::move(edit));
    write_gltf(scene, folder / "s.gltf");
    EXPECT_EQ(names(), (std::vector<std::string>{"s-Wood-2.png", "s-image3.png", "s-wood-3.png", "s-wood.png", "s.gltf"}));
}

TEST_F(GltfWriteFiles, files_of_others_are_not_replaced_but_those_of_an_earlier_export_are) {
    write_text_file(folder / "s.bin", "somebody's");
    EXPECT_CONTAINS(error_of_writing(folder / "s.gltf"), "s.bin: is there already and is no part of 's.gltf' (choose another name or folder)");
    EXPECT_EQ(names(), (std::vector<std::string>{"s.bin"}));
    EXPECT_EQ(read_text_file(folder / "s.bin", 100), "somebody's");
    fs::remove(folder / "s.bin");
    EXPECT_EQ(error_of_writing(folder / "s.gltf"), "");
    EXPECT_EQ(error_of_writing(folder / "s.gltf"), "");
}

TEST_F(GltfWriteFiles, a_failure_leaves_nothing_behind) {
    EXPECT_CONTAINS(error_of_writing(folder / "none" / "s.glb"), "does not exist");
    EXPECT_CONTAINS(error_of_writing(folder / "s.obj"), "s.obj: is neither .glb nor .gltf");
    EXPECT_CONTAINS(error_of_writing(folder / "s.glb", {.max_glb_bytes = 100}), "s.glb: needs ");
    fs::create_directory(folder / "s-plain.png");
    EXPECT_CONTAINS(error_of_writing(folder / "s.gltf"), "s-plain.png: is a folder");
    EXPECT_EQ(names(), std::vector<std::string>{});
}

// A folder in which nothing can be made, for root too.
TEST_F(GltfWriteFiles, a_read_only_folder_is_one_clear_line) { EXPECT_CONTAINS(error_of_writing("/proc/s.glb"), "/proc/s.glb: cannot be written"); }

}  // namespace parhelion::test::gltf_write_files_test
