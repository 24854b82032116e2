// The table of seeded bugs fits the code: whoever changes a line that a bug is seeded in changes the bug as well.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "support/process.h"

namespace parhelion::seeded_bugs_test {
namespace {

std::string read(const std::filesystem::path& file) {
    std::ifstream in(file);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
}

TEST(SeededBugs, every_row_applies_to_its_file) {
    const std::filesystem::path root = PARHELION_SOURCE_DIR;
    std::istringstream table(read(root / "tests/seeded/bugs.tsv"));
    std::set<std::string> names;
    for (std::string line; std::getline(table, line);) {
        if (line.empty() || line[0] == '#') continue;
        std::vector<std::string> columns;
        std::istringstream row(line);
        for (std::string column; std::getline(row, column, '\t');) columns.push_back(column);
        ASSERT_EQ(columns.size(), 6u) << line;
        EXPECT_TRUE(names.insert(columns[0]).second) << columns[0] << " is there twice";
        EXPECT_NE(read(root / columns[1]).find(columns[2]), std::string::npos) << columns[0] << ": its text is not in " << columns[1];
        EXPECT_NE(columns[2], columns[3]) << columns[0];
    }
    EXPECT_GE(names.size(), 20u);
}

void write(const std::filesystem::path& file, const std::string& text, bool runs = false) {
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
    if (runs) std::filesystem::permissions(file, std::filesystem::perms::owner_all);
}

// The script on a tree of its own, with a test program that does what the one line of a shader says.
TEST(SeededBugs, a_test_that_fails_or_crashes_kills_a_bug_and_a_program_that_cannot_start_does_not) {
    const testing::TemporaryFolder folder;
    const std::filesystem::path tree = folder.path() / "tree", build = folder.path() / "build", log = folder.path() / "log";
    std::filesystem::create_directories(tree / "tests/device/shaders");
    std::filesystem::create_directories(tree / "src/scene_gpu");
    write(tree / "src/scene_gpu/none.comp", "");
    write(tree / "src/passes/p/what.comp", "pass\n");
    write(tree / "shaders/s.glsl", "");
    std::filesystem::create_directories(tree / "tests/seeded");
    std::filesystem::copy_file(std::filesystem::path(PARHELION_SOURCE_DIR) / "tests/seeded/run.sh", tree / "tests/seeded/run.sh");
    std::string table;
    for (const std::string what : {"fail", "crash", "leave", "survive", "refuse"}) table += what + "\tsrc/passes/p/what.comp\tpass\t" + what + "\tprogram\tA.*\n";
    write(tree / "tests/seeded/bugs.tsv", table);
    for (const std::string pack : {"shaders", "test_shaders"}) write(build / "shaders" / pack / "manifest.tsv", "");
    const std::string program = "#!/usr/bin/env bash\n"
                                "what=$(cat \"${PARHELION_SHADER_DIR:-none}/src/passes/p/what.comp\" 2>/dev/null)\n"
                                "[ \"$what\" = refuse ] && { echo no device; exit 1; }\n"
                                "echo '[ RUN      ] A.test'\n"
                                "case $what in fail) echo '[  FAILED  ] A.test (1 ms)'; exit 1 ;; crash) kill -SEGV $$ ;; leave) exit 3 ;; esac\n"
                                "echo '[  PASSED  ] 1 test.'\n";
    write(build / "tests/program", program, true);
    const auto run = [&] { return std::system(("bash '" + (tree / "tests/seeded/run.sh").string() + "' '" + build.string() + "' >'" + log.string() + "' 2>&1").c_str()); };
    EXPECT_NE(run(), 0) << "a bug survives";
    const std::string said = read(log);
    EXPECT_NE(said.find("fail: killed by A.test\n"), std::string::npos) << said;
    EXPECT_NE(said.find("crash: killed by A.test (a crash: signal 11)\n"), std::string::npos) << said;
    EXPECT_NE(said.find("leave: killed by A.test (a crash: exit status 3)\n"), std::string::npos) << said;
    EXPECT_NE(said.find("survive: SURVIVED"), std::string::npos) << said;
    EXPECT_NE(said.find("refuse: NOT STARTED (no device)"), std::string::npos) << said;
    EXPECT_NE(said.find("3 killed, 2 survived"), std::string::npos) << said;

    write(build / "tests/program", "#!/usr/bin/env bash\necho no library; exit 127\n", true);
    EXPECT_NE(run(), 0);
    EXPECT_NE(read(log).find("does not start: no library"), std::string::npos) << read(log);
}

}  // namespace
}  // namespace parhelion::seeded_bugs_test
