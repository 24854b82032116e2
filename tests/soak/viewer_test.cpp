// The viewer over thousands of frames of a scene that moves: they come evenly, and nothing grows.
#include <sstream>

#include <gtest/gtest.h>

#include "support/gpu_fixture.h"
#include "support/process.h"
#include "support/virtual_display.h"

namespace parhelion::testing::viewer_soak_test {
namespace {

struct Report {
    double frames = 0, median_ms = 0, within_99_ms = 0, kib = 0, device_kib = 0;
};

// Of a line of the step `report`.
Report read_report(const std::string& line) {
    std::vector<double> numbers;
    std::string digits;
    for (const char letter : line + " ") {
        if (std::isdigit(static_cast<unsigned char>(letter)) || (letter == '.' && !digits.empty())) digits += letter;
        else if (!digits.empty()) numbers.push_back(std::stod(digits)), digits.clear();
    }
    EXPECT_EQ(numbers.size(), 9u) << line;
    return numbers.size() == 9 ? Report{numbers[0], numbers[1], numbers[5], numbers[7], numbers[8]} : Report{};
}

class ViewerSoak : public ::testing::TestWithParam<const char*> {};

TEST_P(ViewerSoak, two_thousand_frames_come_evenly_and_nothing_grows) {
    if (!shared_device() || virtual_display().empty()) GTEST_SKIP() << "there is no Vulkan device, or Xvfb is not installed";
    const std::string script = "frames=60,report,play=on,frames=500,report,frames=2000,report";
    const ProcessResult result = run_parhelion({"view", "builtin:cornell", "--animate", "spin", "--renderer", GetParam(), "--size", "96x72", "--present", "mailbox", "--script", script},
                                               {.environment = {{"DISPLAY", virtual_display()}, {"VK_LOADER_LAYERS_DISABLE", "*"}}});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    std::istringstream lines(result.out);
    std::vector<Report> reports;
    for (std::string line; std::getline(lines, line);) reports.push_back(read_report(line));
    ASSERT_EQ(reports.size(), 3u) << result.out;
    const Report &warm = reports[1], &long_run = reports[2];
    RecordProperty("report", result.out);
    EXPECT_GE(long_run.frames, 2000);
    EXPECT_LE(long_run.kib, 1.02 * warm.kib) << result.out;
    EXPECT_LE(long_run.device_kib, warm.device_kib) << result.out;
    EXPECT_LE(long_run.within_99_ms, 4 * long_run.median_ms) << result.out;
}

INSTANTIATE_TEST_SUITE_P(renderers, ViewerSoak, ::testing::Values("reference", "realtime"), [](const auto& entry) { return std::string(entry.param); });

}  // namespace
}  // namespace parhelion::testing::viewer_soak_test
