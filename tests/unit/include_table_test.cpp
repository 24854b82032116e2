// Holds the sources against the layer table (docs/architecture.md, CMakeLists.txt).
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

namespace {

namespace fs = std::filesystem;

const fs::path kRoot = PARHELION_SOURCE_DIR;

const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"base", {}},
    {"image", {"base"}},
    {"sampling", {"base", "lib"}},  // the sampler of shaders/lib, compiled as C++
    {"bvh", {"base", "lib"}},       // the traversal of shaders/lib, compiled as C++
    {"scene", {"base", "image", "sampling"}},
    {"gpu", {"base"}},
    {"frame", {"base", "gpu"}},
    {"scene_gpu", {"base", "sampling", "bvh", "scene", "gpu", "frame"}},
    {"passes", {"base", "gpu", "frame", "scene_gpu", "scene"}},
    {"renderers", {"base", "scene", "frame", "scene_gpu", "passes"}},
    {"session", {"base", "image", "sampling", "scene", "gpu", "renderers"}},
    {"app", {"session", "base", "image", "scene", "gpu", "frame", "passes", "renderers"}},
};

std::vector<std::string> quoted_includes(const fs::path& file) {
    std::ifstream in(file);
    std::vector<std::string> out;
    static const std::regex pattern(R"re(^\s*#\s*include\s*"([^"]+)")re");
    std::smatch match;
    for (std::string line; std::getline(in, line);)
        if (std::regex_search(line, match, pattern)) out.push_back(match[1]);
    return out;
}

std::vector<fs::path> files_below(const fs::path& folder, const std::set<std::string>& extensions) {
    std::vector<fs::path> out;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file() && extensions.count(entry.path().extension().string())) out.push_back(entry.path());
    return out;
}

}  // namespace

TEST(Layers, every_include_is_allowed_by_the_table) {
    for (const fs::path& file : files_below(kRoot / "src", {".h", ".cpp"})) {
        const std::string layer = fs::relative(file, kRoot / "src").begin()->string();
        ASSERT_TRUE(kMayInclude.count(layer)) << file << " lies in a folder that the table does not know";
        for (const std::string& include : quoted_includes(file)) {
            const std::string target = fs::path(include).begin()->string();
            EXPECT_TRUE(target == layer || target == "shared" || kMayInclude.at(layer).count(target)) << file << " includes \"" << include << '"';
        }
    }
}

TEST(Layers, only_gpu_sees_vulkan) {
    static const std::regex pattern(R"(#\s*include\s*[<"](vulkan/|volk|vk_mem_alloc))");
    for (const fs::path& file : files_below(kRoot / "src", {".h", ".cpp"})) {
        if (fs::relative(file, kRoot / "src").begin()->string() == "gpu") continue;
        std::ifstream in(file);
        for (std::string line; std::getline(in, line);) EXPECT_FALSE(std::regex_search(line, pattern)) << file << ": " << line;
    }
}

TEST(Layers, shader_libraries_include_only_lib_and_shared) {
    for (const fs::path& file : files_below(kRoot / "shaders" / "lib", {".glsl"})) {
        for (const std::string& include : quoted_includes(file)) {
            const std::string target = fs::path(include).begin()->string();
            EXPECT_TRUE(target == "lib" || target == "shared") << file << " includes \"" << include << '"';
        }
        std::ifstream in(file);
        for (std::string line; std::getline(in, line);)
            EXPECT_EQ(line.find("binding ="), std::string::npos) << file << " declares a binding; lib is pure: " << line;
    }
}

TEST(Layers, tracing_passes_use_no_workgroup_features) {
    static const std::regex pattern(R"(\b(shared\s+\w+\s+\w+|barrier\s*\(|gl_WorkGroupID|gl_LocalInvocation\w*|subgroup\w+\s*\())");
    std::vector<fs::path> files = files_below(kRoot / "src" / "passes", {".trace"});
    for (const fs::path& file : files_below(kRoot / "shaders" / "scene", {".glsl"})) files.push_back(file);
    for (const fs::path& file : files) {
        std::ifstream in(file);
        for (std::string line; std::getline(in, line);) {
            const std::string code = line.substr(0, line.find("//"));
            EXPECT_FALSE(std::regex_search(code, pattern)) << file << ": " << line;
        }
    }
}

TEST(Layers, files_stay_within_their_size_budget) {
    const auto lines = [](const fs::path& file) {
        std::ifstream in(file);
        size_t count = 0;
        for (std::string line; std::getline(in, line);) ++count;
        return count;
    };
    for (const char* folder : {"src", "tests", "examples"})
        for (const fs::path& file : files_below(kRoot / folder, {".h", ".cpp"})) {
            if (file.filename().string().find("_data") != std::string::npos) continue;
            EXPECT_LE(lines(file), 500u) << file;
        }
    for (const char* folder : {"src", "shaders", "tests"})
        for (const fs::path& file : files_below(kRoot / folder, {".glsl", ".comp", ".trace", ".rchit", ".rahit", ".rmiss", ".vert", ".frag"}))
            EXPECT_LE(lines(file), 300u) << file;
}

TEST(Layers, every_shader_entry_says_what_it_reads_and_writes) {
    for (const char* folder : {"src/passes", "src/scene_gpu", "shaders/scene"})
        for (const fs::path& file : files_below(kRoot / folder, {".comp", ".trace", ".rchit", ".rahit", ".rmiss", ".vert", ".frag"})) {
            std::ifstream in(file);
            std::string head, line;
            for (int i = 0; i < 8 && std::getline(in, line); ++i) head += line + "\n";
            EXPECT_NE(head.find("\n// "), std::string::npos) << file;
            EXPECT_NE(head.find("eads"), std::string::npos) << file;
            EXPECT_NE(head.find("rites"), std::string::npos) << file;
        }
}
