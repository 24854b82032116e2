// parhelion export as a process: what it writes, says and refuses.
#include <algorithm>

#include <gtest/gtest.h>

#include "base/file.h"
#include "support/gpu_fixture.h"
#include "support/process.h"

namespace parhelion::testing::cli_export_test {
namespace {

class CliExport : public ::testing::Test {
protected:
    TemporaryFolder folder;
    std::string file(const std::string& name) const { return folder.file(name); }
    static std::vector<std::byte> bytes(const std::string& path) { return read_file(path, 1 << 30); }
};

TEST_F(CliExport, a_builtin_scene_becomes_a_file_that_exports_to_itself) {
    const ProcessResult first = run_parhelion({"export", "builtin:textured", "--out", file("a.glb"), "--json", "-"});
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const nlohmann::json report = nlohmann::json::parse(first.out);
    EXPECT_EQ(report["files"], nlohmann::json::array({file("a.glb")}));
    EXPECT_EQ(report["bytes"], bytes(file("a.glb")).size());
    EXPECT_EQ(report["warnings"].size(), 1u);
    EXPECT_NE(first.err.find("the environment is left out"), std::string::npos);
    ASSERT_EQ(run_parhelion({"export", file("a.glb"), "--out", file("b.glb")}).exit_code, 0);
    EXPECT_TRUE(bytes(file("a.glb")) == bytes(file("b.glb")));
}

TEST_F(CliExport, an_exported_scene_is_the_same_picture) {
    if (!shared_device()) {
        if (is_required("device")) FAIL() << "there is no Vulkan device";
        GTEST_SKIP() << "there is no Vulkan device";
    }
    ASSERT_EQ(run_parhelion({"export", "builtin:cornell", "--out", file("c.glb")}).exit_code, 0);
    for (const std::string& scene : {std::string("builtin:cornell"), file("c.glb")}) {
        const std::string out = scene == file("c.glb") ? file("b.exr") : file("a.exr");
        ASSERT_EQ(run_parhelion({"render", scene, "--size", "24x16", "--spp", "2", "--exposure", "3", "--out", out}).exit_code, 0);
    }
    const ProcessResult compared = run_parhelion({"compare", file("a.exr"), file("b.exr"), "--max-relmse", "1e-6"});
    EXPECT_EQ(compared.exit_code, 0) << compared.out;
}

TEST_F(CliExport, what_is_wrong_is_one_line_and_a_code) {
    const auto expect_error = [](const ProcessResult& result, int code, const std::string& message) {
        EXPECT_EQ(result.exit_code, code) << result.err;
        EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
        EXPECT_EQ(std::ranges::count(result.err, '\n'), 1) << result.err;
    };
    expect_error(run_parhelion({"export", "builtin:cornell"}), 2, "export: there is no output (add --out F.glb or --out F.gltf)");
    expect_error(run_parhelion({"export", "builtin:cornell", "--out", file("a.obj")}), 2, "is neither .glb nor .gltf (the extension chooses the form)");
    expect_error(run_parhelion({"export", "s.glb", "--out", file("a.glb"), "--time", "1"}), 2, "--time: the animations of a file are exported as they are");
    expect_error(run_parhelion({"export", "builtin:cornell", "--out", file("none/a.glb")}), 1, "does not exist (create it first)");
    expect_error(run_parhelion({"export", file("none.glb"), "--out", file("a.glb")}), 1, "there is no such file");
    EXPECT_FALSE(std::filesystem::exists(file("a.glb")));
}

}  // namespace
}  // namespace parhelion::testing::cli_export_test
