// Progress: what a terminal and what a log sees, with a clock of the test's own.
#include "session/progress.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace parhelion::progress_test {
namespace {

struct Recorder {
    double now = 0;
    std::vector<std::string> written;
    ProgressStyle style(bool terminal) {
        return {.terminal = terminal,
                .width = 60,
                .write = [this](std::string_view text) { written.emplace_back(text); },
                .seconds = [this] { return now; }};
    }
};

}  // namespace

TEST(Progress, a_log_gets_at_most_a_line_each_ten_percent_and_five_seconds) {
    Recorder recorder;
    {
        Progress progress("rendering", 1000, recorder.style(false));
        for (int step = 0; step <= 1000; ++step) {
            recorder.now = 0.1 * step;  // 100 s in all
            progress.update(step, "detail");
        }
    }
    ASSERT_GE(recorder.written.size(), 8u);
    EXPECT_LE(recorder.written.size(), 10u);
    EXPECT_EQ(recorder.written.front(), "rendering 10 %, detail, 1 min 30 s left\n");
    for (const std::string& line : recorder.written) EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
}

TEST(Progress, short_work_leaves_no_line_in_a_log) {
    Recorder recorder;
    {
        Progress progress("rendering", 10, recorder.style(false));
        for (int step = 0; step <= 10; ++step) {
            recorder.now = 0.2 * step;
            progress.update(step);
        }
    }
    EXPECT_TRUE(recorder.written.empty());
}

TEST(Progress, a_terminal_gets_a_bar_within_its_width_that_is_taken_away) {
    Recorder recorder;
    {
        Progress progress("rendering a thing with a very long name", 100, recorder.style(true));
        for (int step = 0; step <= 50; ++step) {
            recorder.now = step;
            progress.update(step, "23/64 spp and more words than fit");
        }
    }
    ASSERT_GE(recorder.written.size(), 50u);
    for (const std::string& line : recorder.written) {
        EXPECT_EQ(line.front(), '\r');
        EXPECT_LE(line.size(), 1 + 59 + 3u);
        EXPECT_EQ(line.find('\n'), std::string::npos);
    }
    EXPECT_EQ(recorder.written.back(), "\r\x1b[K");
}

TEST(Progress, work_from_a_checkpoint_does_not_make_the_rest_look_fast) {
    Recorder recorder;
    Progress progress("rendering", 100, recorder.style(false));
    progress.update(80);
    recorder.now = 10;
    progress.update(90);
    ASSERT_EQ(recorder.written.size(), 1u);
    EXPECT_EQ(recorder.written[0], "rendering 90 %, 10 s left\n");
}

TEST(Progress, durations_are_rounded_for_people) {
    EXPECT_EQ(format_duration(0.44), "0.4 s");
    EXPECT_EQ(format_duration(12.4), "12 s");
    EXPECT_EQ(format_duration(59.4), "59 s");
    EXPECT_EQ(format_duration(59.6), "1 min 00 s");
    EXPECT_EQ(format_duration(3 * 60 + 5.2), "3 min 05 s");
    EXPECT_EQ(format_duration(2 * 3600 + 7 * 60), "2 h 07 min");
    EXPECT_EQ(format_duration(-1), "0.0 s");
}

}  // namespace parhelion::progress_test
