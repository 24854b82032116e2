#include "base/error.h"

#include <utility>

namespace parhelion {

std::string_view error_code_name(ErrorCode code) {
    switch (code) {
        case ErrorCode::Failed: return "failed";
        case ErrorCode::Usage: return "usage";
        case ErrorCode::MissingFeature: return "missing_feature";
        case ErrorCode::ComparisonExceeded: return "comparison_exceeded";
        case ErrorCode::Interrupted: return "interrupted";
        case ErrorCode::Terminated: return "terminated";
    }
    return "failed";
}

Error::Error(ErrorCode error_code, std::string what_text, std::string where_text, std::string hint_text)
    : code(error_code), problem(std::move(what_text)), where(std::move(where_text)), hint(std::move(hint_text)) {
    line = where.empty() ? problem : where + ": " + problem;
    if (!hint.empty()) line += " (" + hint + ")";
}

void fail_check(const char* condition, const char* file, int line, const std::string& message) {
    const std::string_view path = file;
    const size_t slash = path.rfind("src/");
    throw Error(ErrorCode::Failed, fmt::format("internal error: {} [{}]", message, condition),
                fmt::format("{}:{}", slash == std::string_view::npos ? path : path.substr(slash), line),
                "this is a defect of Parhelion: please report it with the command that led here");
}

namespace {

// Length of the valid UTF-8 sequence at text[i], 0 if there is none.
size_t utf8_length(std::string_view text, size_t i) {
    const auto byte = [&](size_t k) { return static_cast<unsigned char>(text[k]); };
    const unsigned char lead = byte(i);
    const size_t length = lead < 0x80 ? 1 : lead >= 0xC2 && lead < 0xE0 ? 2 : lead >= 0xE0 && lead < 0xF0 ? 3 : lead >= 0xF0 && lead < 0xF5 ? 4 : 0;
    if (length == 0 || i + length > text.size()) return 0;
    for (size_t k = 1; k < length; ++k)
        if ((byte(i + k) & 0xC0) != 0x80) return 0;
    return length;
}

}  // namespace

std::string escape_name(std::string_view name, size_t max_length) {
    std::string out;
    for (size_t i = 0; i < name.size();) {
        if (out.size() >= max_length) return out + "...";
        const size_t length = utf8_length(name, i);
        const unsigned char c = static_cast<unsigned char>(name[i]);
        if (length == 0 || c < 0x20 || c == 0x7F) {
            out += fmt::format("\\x{:02x}", c);
            ++i;
        } else {
            out.append(name.substr(i, length));
            i += length;
        }
    }
    return out;
}

}  // namespace parhelion
