#pragma once
// The one error type of the project. Three classes of failure, after Falcor's error policy:
//   programmer error     PARHELION_CHECK(condition, ...)   a broken promise between two pieces of our own code
//   run-time error       throw Error{...}                  a file, an option, a device, the world
//   expected failure     std::optional                     "not there" is a normal answer
#include <cstdint>
#include <exception>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace parhelion {

// The numbers are the exit codes of the programs.
enum class ErrorCode {
    Failed = 1,              // a file, the scene, the device
    Usage = 2,               // a wrong option or value
    MissingFeature = 3,      // the device lacks something needed
    ComparisonExceeded = 4,  // a comparison went over its limit
    Interrupted = 130,       // Ctrl-C; what was finished is written
    Terminated = 143,
};

std::string_view error_code_name(ErrorCode code);

// what: what is wrong; where: which file, option or device; hint: what to do about it.
struct Error : std::exception {
    Error(ErrorCode error_code, std::string what_text, std::string where_text = {}, std::string hint_text = {});
    const char* what() const noexcept override { return line.c_str(); }

    ErrorCode code;
    std::string problem;
    std::string where;
    std::string hint;
    std::string line;  // the three in one clear line
};

// The device is gone with all that was on it; another one, or the same opened again, may work.
struct DeviceLost : Error {
    DeviceLost(std::string what_text, std::string where_text)
        : Error(ErrorCode::Failed, std::move(what_text), std::move(where_text), "a smaller --size or another --device may work") {}
};

[[noreturn]] void fail_check(const char* condition, const char* file, int line, const std::string& message);

// Names that come from files are printed through this: control characters and invalid UTF-8 become \xNN, length is capped.
std::string escape_name(std::string_view name, size_t max_length = 200);

}  // namespace parhelion

#define PARHELION_CHECK(condition, ...)                                                                  \
    do {                                                                                                 \
        if (!(condition)) ::parhelion::fail_check(#condition, __FILE__, __LINE__, fmt::format(__VA_ARGS__)); \
    } while (false)
