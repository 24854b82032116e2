#pragma once
// Everything a person reads goes to stderr through here; stdout carries results only.
// PARHELION_LOG=trace|debug|info|warn|error|off sets the level (default info). NO_COLOR turns colours off.
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace parhelion {

enum class LogLevel { Trace, Debug, Info, Warn, Error, Off };

void set_log_level(LogLevel level);
LogLevel log_level();
void log_line(LogLevel level, std::string_view text);

template <class... Args>
void log(LogLevel level, fmt::format_string<Args...> format, Args&&... args) {
    if (level >= log_level()) log_line(level, fmt::format(format, std::forward<Args>(args)...));
}

// Prints a warning the first time this exact text is met in the process.
void warn_once(std::string_view text);

}  // namespace parhelion
