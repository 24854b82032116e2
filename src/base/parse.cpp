#include "base/parse.h"

#include <charconv>
#include <cmath>
#include <string>

#include "base/error.h"

namespace parhelion {

namespace {

[[noreturn]] void refuse(std::string_view text, std::string_view where, std::string_view wanted) {
    throw Error(ErrorCode::Usage, fmt::format("'{}' is not {}", escape_name(text), wanted), std::string(where));
}

template <class T>
bool read_whole(std::string_view text, T& value) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data(), end, value);
    return result.ec == std::errc{} && result.ptr == end && !text.empty();
}

}  // namespace

int64_t parse_int(std::string_view text, std::string_view where, int64_t min, int64_t max) {
    int64_t value = 0;
    if (!read_whole(text, value)) refuse(text, where, "a whole number");
    if (value < min || value > max)
        throw Error(ErrorCode::Usage, fmt::format("{} is out of range", value), std::string(where), fmt::format("from {} to {}", min, max));
    return value;
}

double parse_float(std::string_view text, std::string_view where, double min, double max) {
    double value = 0;
    if (!read_whole(text, value) || !std::isfinite(value)) refuse(text, where, "a finite number");
    if (value < min || value > max)
        throw Error(ErrorCode::Usage, fmt::format("{} is out of range", value), std::string(where), fmt::format("from {} to {}", min, max));
    return value;
}

bool parse_bool(std::string_view text, std::string_view where) {
    if (text == "on" || text == "true" || text == "1") return true;
    if (text == "off" || text == "false" || text == "0") return false;
    refuse(text, where, "on or off");
}

Size2 parse_size(std::string_view text, std::string_view where) {
    const size_t cross = text.find('x');
    uint32_t width = 0, height = 0;
    if (cross == std::string_view::npos || !read_whole(text.substr(0, cross), width) || !read_whole(text.substr(cross + 1), height))
        refuse(text, where, "a size like 1280x720");
    if (width < 1 || height < 1 || width > 65536 || height > 65536)
        throw Error(ErrorCode::Usage, fmt::format("{}x{} is out of range", width, height), std::string(where), "each side from 1 to 65536");
    return {width, height};
}

IndexRange parse_range(std::string_view text, std::string_view where) {
    const size_t dash = text.find('-');
    IndexRange range;
    if (dash == std::string_view::npos || !read_whole(text.substr(0, dash), range.begin) || !read_whole(text.substr(dash + 1), range.end))
        refuse(text, where, "a range like 0-64");
    if (range.end <= range.begin) throw Error(ErrorCode::Usage, fmt::format("the range {} is empty", text), std::string(where), "A-B with A < B");
    return range;
}

std::array<double, 3> parse_vec3(std::string_view text, std::string_view where) {
    std::array<double, 3> v{};
    std::string_view rest = text;
    for (int k = 0; k < 3; ++k) {
        const size_t comma = rest.find(',');
        if ((comma == std::string_view::npos) != (k == 2) || !read_whole(rest.substr(0, comma), v[k]) || !std::isfinite(v[k]))
            refuse(text, where, "three numbers like 0,1.5,-2");
        if (k < 2) rest.remove_prefix(comma + 1);
    }
    return v;
}

double parse_duration_seconds(std::string_view text, std::string_view where) {
    static constexpr std::pair<std::string_view, double> kUnits[] = {{"ms", 1e-3}, {"s", 1.0}, {"m", 60.0}, {"h", 3600.0}};
    for (const auto& [unit, seconds] : kUnits) {
        if (!text.ends_with(unit)) continue;
        double value = 0;
        if (!read_whole(text.substr(0, text.size() - unit.size()), value) || !std::isfinite(value) || value <= 0) break;
        return value * seconds;
    }
    refuse(text, where, "a duration like 30s, 500ms, 2m or 1h");
}

}  // namespace parhelion
