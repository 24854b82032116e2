#include "session/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>

#include "base/log.h"
#include "base/platform.h"

namespace parhelion {

namespace {

constexpr double kBarInterval = 0.1;   // seconds between two drawings of the bar
constexpr double kLineInterval = 5.0;  // seconds between two plain lines
constexpr double kLineShare = 0.1 - 1e-9;
constexpr unsigned kBarCells = 24;

}  // namespace

std::string format_duration(double seconds) {
    if (!(seconds >= 0)) seconds = 0;
    if (seconds < 10) return fmt::format("{:.1f} s", seconds);
    if (seconds < 59.5) return fmt::format("{:.0f} s", seconds);
    const auto whole = static_cast<uint64_t>(std::llround(std::min(seconds, 1e15)));
    if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
    return fmt::format("{} h {:02} min", whole / 3600, whole / 60 % 60);
}

ProgressStyle stderr_progress_style() {
    ProgressStyle style;
    style.terminal = platform::is_terminal(2);
    style.width = platform::terminal_width();
    style.write = [](std::string_view text) {
        std::fwrite(text.data(), 1, text.size(), stderr);
        std::fflush(stderr);
    };
    style.seconds = [] { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); };
    return style;
}

Progress::Progress(std::string label, double total, ProgressStyle style)
    : label_(std::move(label)), total_(std::max(total, 1e-300)), style_(std::move(style)), silent_(log_level() > LogLevel::Info) {}

Progress::~Progress() { clear(); }

void Progress::update(double done, std::string_view detail) {
    if (silent_) return;
    const double now = style_.seconds();
    if (first_time_ < 0) {
        first_time_ = now;
        first_done_ = done;
        shown_share_ = done / total_;
        if (!style_.terminal) shown_time_ = now;
    }
    const double share = done / total_;
    if (style_.terminal) {
        if (now - shown_time_ < kBarInterval && share < 1) return;
        draw_bar(done, now, detail);
    } else {
        if (now - shown_time_ < kLineInterval || share - shown_share_ < kLineShare || share >= 1) return;
        print_line(done, now, detail);
    }
    shown_time_ = now;
    shown_share_ = share;
}

double Progress::seconds_left(double done, double now) const {
    const double worked = done - first_done_;
    return worked > 0 ? (now - first_time_) * (total_ - done) / worked : -1;
}

void Progress::draw_bar(double done, double now, std::string_view detail) {
    const double share = std::clamp(done / total_, 0.0, 1.0);
    const auto filled = static_cast<unsigned>(share * kBarCells);
    std::string line =
        fmt::format("{} [{}{}] {:3.0f} %", label_, std::string(filled, '#'), std::string(kBarCells - filled, '.'), share * 100);
    if (!detail.empty()) line += fmt::format("  {}", detail);
    if (const double left = seconds_left(done, now); left >= 0) line += fmt::format("  {} left", format_duration(left));
    if (style_.width > 1 && line.size() > style_.width - 1) line.resize(style_.width - 1);
    style_.write("\r" + line + "\x1b[K");
    bar_visible_ = true;
}

void Progress::print_line(double done, double now, std::string_view detail) {
    std::string line = fmt::format("{} {:.0f} %", label_, std::clamp(done / total_, 0.0, 1.0) * 100);
    if (!detail.empty()) line += fmt::format(", {}", detail);
    if (const double left = seconds_left(done, now); left >= 0) line += fmt::format(", {} left", format_duration(left));
    style_.write(line + "\n");
}

void Progress::clear() {
    if (bar_visible_) style_.write("\r\x1b[K");
    bar_visible_ = false;
}

}  // namespace parhelion
