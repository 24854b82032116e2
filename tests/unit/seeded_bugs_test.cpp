// The table of seeded bugs fits the code: whoever changes a line that a bug is seeded in changes the bug as well.
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace parhelion {
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

}  // namespace
}  // namespace parhelion
