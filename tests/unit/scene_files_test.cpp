// SceneFiles: what URIs may name, and how much memory a scene may ask for.
#include "scene/scene_files.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "base/error.h"
#include "base/file.h"
#include "base/platform.h"
#include "gltf_make.h"
#include "scene/load.h"

namespace parhelion::test::scene_files_test {

namespace fs = std::filesystem;

namespace {

// outside/secret.bin, and scene/ with a file, a folder, links in and out, and a pipe.
class SceneFilesTest : public ::testing::Test {
protected:
    void SetUp() override {
        base_ = fs::temp_directory_path() / fmt::format("parhelion-files-{}-{}", platform::process_id(),
                                                        ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(base_);
        fs::create_directories(root() / "sub");
        fs::create_directories(base_ / "outside");
        fs::create_directories(base_ / "scene2");
        put(root() / "data.bin", "inside");
        put(root() / "sub" / "a b%.bin", "spaced");
        put(base_ / "outside" / "secret.bin", "secret");
        put(base_ / "scene2" / "other.bin", "other");
        fs::create_symlink(base_ / "outside" / "secret.bin", root() / "link-out.bin");
        fs::create_directory_symlink(base_ / "outside", root() / "folder-out");
        fs::create_symlink("data.bin", root() / "link-in.bin");
        fs::create_symlink("loop.bin", root() / "loop.bin");
        ASSERT_EQ(mkfifo((root() / "pipe.bin").c_str(), 0600), 0);
    }
    void TearDown() override { fs::remove_all(base_); }

    static void put(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }
    fs::path root() const { return base_ / "scene"; }
    std::string read(const std::string& uri, const SceneFileLimits& limits = {}) {
        SceneFiles files(root(), limits);
        try {
            const SceneFiles::Bytes bytes = files.read_uri(uri, "here");
            return {reinterpret_cast<const char*>(bytes->data()), bytes->size()};
        } catch (const Error& error) {
            EXPECT_EQ(error.where, "here");
            return error.line;
        }
    }

    fs::path base_;
};

}  // namespace

TEST_F(SceneFilesTest, relative_uris_are_percent_decoded_and_read) {
    EXPECT_EQ(read("data.bin"), "inside");
    EXPECT_EQ(read("./sub/../data.bin"), "inside");
    EXPECT_EQ(read("d%61ta.bin"), "inside");
    EXPECT_EQ(read("sub/a%20b%25.bin"), "spaced");
    EXPECT_EQ(read("sub/a b%.bin"), "spaced");
    EXPECT_EQ(read("sub\\a b%.bin"), "spaced");
    EXPECT_EQ(read("link-in.bin"), "inside");
}

TEST_F(SceneFilesTest, nothing_outside_of_the_folder_is_read) {
    const std::string secret = (base_ / "outside" / "secret.bin").string();
    for (const std::string& uri :
         {std::string("../outside/secret.bin"), std::string("%2e%2e/outside/secret.bin"), std::string("..\\outside\\secret.bin"),
          std::string("sub/../../outside/secret.bin"), std::string("nowhere/../../outside/secret.bin"), secret,
          std::string("%2Fetc/passwd"), std::string("link-out.bin"), std::string("folder-out/secret.bin"),
          std::string("../scene2/other.bin"), std::string(".."), std::string("../scene")})
        EXPECT_CONTAINS(read(uri), "leads out of the scene's folder (--allow-external permits it)");
}

// Behind a folder that does not exist, ".." would be taken by the text and a link not be seen.
TEST_F(SceneFilesTest, a_folder_that_does_not_exist_hides_no_link) {
    EXPECT_CONTAINS(read("nowhere/../link-out.bin"), "there is no such file");
    EXPECT_CONTAINS(read("nowhere/../folder-out/secret.bin"), "there is no such file");
    EXPECT_CONTAINS(read("data.bin/../link-out.bin"), "cannot be resolved");
    EXPECT_CONTAINS(read("%252e%252e/outside/secret.bin"), "there is no such file");  // decoded once
}

TEST_F(SceneFilesTest, allow_external_lifts_the_folder_but_not_protocols) {
    const SceneFileLimits open{.allow_external = true};
    EXPECT_EQ(read("../outside/secret.bin", open), "secret");
    EXPECT_EQ(read((base_ / "outside" / "secret.bin").string(), open), "secret");
    EXPECT_EQ(read("link-out.bin", open), "secret");
    EXPECT_CONTAINS(read("file:///etc/passwd", open), "names a protocol");
    for (const char* uri : {"//host/share/a.bin", "\\\\host\\share\\a.bin", "%2F%2Fhost/a.bin"})
        EXPECT_CONTAINS(read(uri, open), "names another machine");
}

TEST_F(SceneFilesTest, protocols_are_refused) {
    for (const char* uri : {"http://example.org/a.bin", "FILE:data.bin", "c:/data.bin", "ftp+x-1.0://y"})
        EXPECT_CONTAINS(read(uri), "names a protocol");
    EXPECT_CONTAINS(read("sub/a:b.bin"), "there is no such file");  // a colon behind a slash is a name
}

TEST_F(SceneFilesTest, only_regular_files_are_read) {
    EXPECT_CONTAINS(read("pipe.bin"), "'pipe.bin' is a pipe or device");
    EXPECT_CONTAINS(read("sub"), "'sub' is a folder");
    EXPECT_CONTAINS(read("missing.bin"), "'missing.bin' there is no such file");
    EXPECT_CONTAINS(read("loop.bin"), "cannot be resolved");
    EXPECT_CONTAINS(read(""), "has an empty URI");
    EXPECT_CONTAINS(read("a%00b"), "holds a zero byte");
    EXPECT_CONTAINS(read(std::string(5000, 'x')), "is 5000 bytes long; the limit is 4096");
    EXPECT_CONTAINS(read(std::string(4000, 'x')), "cannot be resolved");
    std::string deep;
    for (int i = 0; i < 1000; ++i) deep += "./";
    EXPECT_EQ(read(deep + "data.bin"), "inside");
}

// At once: a pipe has no writer, a terminal no end, a file of /proc no size.
TEST_F(SceneFilesTest, pipes_sockets_devices_and_files_without_size_never_hang) {
    const int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string socket_path = (fs::temp_directory_path() / fmt::format("parhelion-{}.sock", platform::process_id())).string();
    std::strncpy(address.sun_path, socket_path.c_str(), sizeof(address.sun_path) - 1);
    ASSERT_EQ(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    const auto error_of_file = [](const fs::path& path) -> std::string {
        try {
            read_file(path, 1 << 20);
        } catch (const Error& error) {
            return error.problem;
        }
        return "";
    };
    for (const fs::path& path : {root() / "pipe.bin", fs::path(socket_path), fs::path("/dev/zero"), fs::path("/dev/null"), fs::path("/dev/tty")})
        if (fs::exists(path)) {
            EXPECT_CONTAINS(error_of_file(path), "is a pipe or device");
        }
    EXPECT_TRUE(read_file("/proc/self/status", 1 << 20).empty());
    for (const fs::path& path : {fs::path("/proc/self/status"), fs::path("/dev/zero"), fs::path(socket_path)}) {
        EXPECT_THROW(load_scene(path.string()), Error) << path;
        EXPECT_THROW(load_environment(path), Error) << path;
        fs::create_symlink(path, root() / "odd.bin");
        GltfMaker maker;
        maker.add_triangle();
        maker.doc["buffers"] = json::array({{{"byteLength", 100}, {"uri", "odd.bin"}}});
        put(root() / "odd.gltf", maker.doc.dump());
        EXPECT_THROW(load_scene((root() / "odd.gltf").string(), {.limits = {.allow_external = true}}), Error) << path;
        fs::remove(root() / "odd.bin");
    }
    close(listener);
    fs::remove(socket_path);
}

TEST_F(SceneFilesTest, what_was_opened_counts_and_not_what_its_name_stood_for) {
    EXPECT_EQ(platform::open_for_reading(root() / "missing.bin").file, nullptr);
    const std::pair<const char*, platform::FileKind> kinds[] = {
        {"data.bin", platform::FileKind::Regular}, {"sub", platform::FileKind::Folder}, {"pipe.bin", platform::FileKind::Other}};
    for (const auto& [name, kind] : kinds) {
        const platform::OpenedFile opened = platform::open_for_reading(root() / name);
        EXPECT_EQ(opened.kind, kind) << name;
        if (opened.file != nullptr) std::fclose(opened.file);
    }
}

// A file may have holes: it costs its maker nothing and would cost the reader its memory.
TEST_F(SceneFilesTest, files_larger_than_the_machine_are_refused_before_memory_is_taken) {
    fs::resize_file(root() / "data.bin", platform::physical_bytes() + 1);
    EXPECT_CONTAINS(read("data.bin"), "bytes large; the limit here is");
}

TEST_F(SceneFilesTest, large_files_and_large_sums_are_refused_before_they_are_read) {
    EXPECT_CONTAINS(read("data.bin", {.max_file_bytes = 5}), "is 6 bytes large; the limit here is 5");
    SceneFiles files(root(), {.budget_base_bytes = 1000, .budget_factor = 0});
    files.read_uri("data.bin", "here");
    files.read_uri("link-in.bin", "here");  // the same file: counted once
    EXPECT_EQ(files.bytes_read(), 6u);
    EXPECT_EQ(files.budget_left(), 994u);
    EXPECT_THROW(files.charge(995, "here"), Error);
    files.charge(994, "here");
    EXPECT_THROW(files.charge(1, "here"), Error);
    EXPECT_THROW(files.charge(0xFFFFFFFFFFFFFFFFull, "here"), Error);
}

TEST_F(SceneFilesTest, a_scene_is_read_from_its_folder_and_may_not_name_a_pipe) {
    GltfMaker maker;
    maker.add_triangle();
    json doc = json::parse(maker.text());
    const std::vector<std::byte> data = decode_data_uri(doc["buffers"][0]["uri"].get<std::string>(), "here");
    std::ofstream(root() / "mesh.bin", std::ios::binary)
        .write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
    doc["buffers"][0]["uri"] = "mesh.bin";
    put(root() / "scene.gltf", doc.dump());
    EXPECT_EQ(load_scene((root() / "scene.gltf").string()).scene.meshes().size(), 1u);
    doc["buffers"][0]["uri"] = "pipe.bin";
    put(root() / "scene.gltf", doc.dump());
    try {
        load_scene((root() / "scene.gltf").string());
        FAIL() << "a pipe was read";
    } catch (const Error& error) {
        EXPECT_CONTAINS(error.line, "scene.gltf: buffers[0].uri: 'pipe.bin' is a pipe or device");
    }
    EXPECT_THROW(load_scene((root() / "pipe.bin").string()), Error);
    EXPECT_THROW(load_scene(root().string()), Error);
    EXPECT_THROW(load_scene((root() / "none.glb").string()), Error);
}

TEST(DataUris, of_every_form_are_decoded) {
    const auto text = [](std::string_view uri) {
        const std::vector<std::byte> bytes = decode_data_uri(uri, "here");
        return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    };
    EXPECT_EQ(text("data:application/octet-stream;base64,aGVsbG8="), "hello");
    EXPECT_EQ(text("DATA:;BASE64,aGVsbG8"), "hello");
    EXPECT_EQ(text("data:;base64,aGVsbG8h"), "hello!");
    EXPECT_EQ(text("data:;base64,"), "");
    EXPECT_EQ(text("data:text/plain,a%20b"), "a b");
    EXPECT_THROW(text("data:;base64,a"), Error);
    EXPECT_THROW(text("data:;base64,aG=sbG8="), Error);
    EXPECT_THROW(text("data:;base64"), Error);
    EXPECT_TRUE(is_data_uri("Data:x"));
    EXPECT_FALSE(is_data_uri("dat"));
}

TEST(DataUris, base64_of_all_lengths_comes_back) {
    std::vector<std::byte> bytes;
    for (int i = 0; i < 100; ++i) {
        EXPECT_EQ(decode_data_uri("data:;base64," + base64(bytes), "here"), bytes);
        bytes.push_back(static_cast<std::byte>(i * 37));
    }
}

}  // namespace parhelion::test::scene_files_test
