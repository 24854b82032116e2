#pragma once
// Progress of long work on stderr: a bar with the time left on a terminal; elsewhere plain lines, one at most each 10 % or 5 s
// (whichever comes later), so that logs stay short.
#include <chrono>
#include <functional>
#include <string>
#include <string_view>

namespace parhelion {

std::string format_duration(double seconds);  // "0.4 s", "12 s", "3 min 05 s", "2 h 07 min"

struct ProgressStyle {
    bool terminal = false;
    unsigned width = 80;                          // columns of the terminal
    std::function<void(std::string_view)> write;  // to stderr
    std::function<double()> seconds;              // a clock that never goes back
};
ProgressStyle stderr_progress_style();

class Progress {
public:
    // `label` is what is being done, `total` in any unit. Silent where the log level hides Info.
    Progress(std::string label, double total, ProgressStyle style = stderr_progress_style());
    ~Progress();  // removes the bar
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // `done` of the total are finished; `detail` is a short remark such as "24/64 spp". The time left is judged from the work done
    // since the first call, so that work taken over from a checkpoint does not count as fast.
    void update(double done, std::string_view detail = {});
    void clear();  // takes the bar away before something else is printed

private:
    double seconds_left(double done, double now) const;
    void draw_bar(double done, double now, std::string_view detail);
    void print_line(double done, double now, std::string_view detail);

    std::string label_;
    double total_;
    ProgressStyle style_;
    double first_time_ = -1, first_done_ = 0;
    double shown_time_ = -1e9, shown_share_ = 0;
    bool bar_visible_ = false, silent_ = false;
};

}  // namespace parhelion
