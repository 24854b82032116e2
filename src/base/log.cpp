#include "base/log.h"

#include <atomic>
#include <cstdlib>
#include <mutex>
#include <set>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "base/error.h"

namespace parhelion {

namespace {

LogLevel level_from_environment() {
    const char* text = std::getenv("PARHELION_LOG");
    if (!text || !*text) return LogLevel::Info;
    static constexpr std::pair<std::string_view, LogLevel> kNames[] = {
        {"trace", LogLevel::Trace}, {"debug", LogLevel::Debug}, {"info", LogLevel::Info},
        {"warn", LogLevel::Warn},   {"error", LogLevel::Error}, {"off", LogLevel::Off}};
    for (const auto& [name, level] : kNames)
        if (name == text) return level;
    throw Error(ErrorCode::Usage, fmt::format("'{}' is not a log level", escape_name(text)), "PARHELION_LOG",
                "use trace, debug, info, warn, error or off");
}

std::atomic<LogLevel>& current_level() {
    static std::atomic<LogLevel> level = level_from_environment();
    return level;
}

spdlog::logger& logger() {
    static const std::shared_ptr<spdlog::logger> instance = [] {
        const bool plain = std::getenv("NO_COLOR") != nullptr;
        auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>(plain ? spdlog::color_mode::never : spdlog::color_mode::automatic);
        auto made = std::make_shared<spdlog::logger>("parhelion", std::move(sink));
        made->set_pattern("%^%v%$");
        made->set_level(spdlog::level::trace);
        return made;
    }();
    return *instance;
}

}  // namespace

void set_log_level(LogLevel level) { current_level() = level; }
LogLevel log_level() { return current_level(); }

void log_line(LogLevel level, std::string_view text) {
    switch (level) {
        case LogLevel::Trace: logger().trace("{}", text); break;
        case LogLevel::Debug: logger().debug("{}", text); break;
        case LogLevel::Info: logger().info("{}", text); break;
        case LogLevel::Warn: logger().warn("warning: {}", text); break;
        case LogLevel::Error: logger().error("error: {}", text); break;
        case LogLevel::Off: break;
    }
}

void warn_once(std::string_view text) {
    static std::mutex mutex;
    static std::set<std::string, std::less<>> seen;
    const std::lock_guard lock(mutex);
    if (seen.emplace(text).second) log(LogLevel::Warn, "{}", text);
}

}  // namespace parhelion
