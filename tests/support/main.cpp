// Runs the tests. Tests of real assets (suites named ...Assets) are there only where PARHELION_ASSETS names their folder: each has
// a built-in twin, so leaving them out is not a skip.
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

int main(int argc, char** argv) {
    ::testing::InitGoogleTest(&argc, argv);
    if (std::getenv("PARHELION_ASSETS") == nullptr) {
        std::string& filter = ::testing::GTEST_FLAG(filter);
        filter += (filter.find('-') == std::string::npos ? "-" : ":") + std::string("*Assets.*");
    }
    return RUN_ALL_TESTS();
}
