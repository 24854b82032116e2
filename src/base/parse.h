#pragma once
// Strict numbers for options, settings and environment: read whole, finite, in range. Every failure is a usage Error that
// names `where` (the option), what was given and what is allowed.
#include <array>
#include <cstdint>
#include <limits>
#include <string_view>

namespace parhelion {

int64_t parse_int(std::string_view text, std::string_view where, int64_t min = std::numeric_limits<int64_t>::min(),
                  int64_t max = std::numeric_limits<int64_t>::max());
double parse_float(std::string_view text, std::string_view where, double min = -std::numeric_limits<double>::max(),
                   double max = std::numeric_limits<double>::max());
bool parse_bool(std::string_view text, std::string_view where);  // on|off, true|false, 1|0

struct Size2 {
    uint32_t width = 0, height = 0;
    friend bool operator==(const Size2&, const Size2&) = default;
};
Size2 parse_size(std::string_view text, std::string_view where);  // "1280x720", each 1 to 65536

struct IndexRange {
    uint64_t begin = 0, end = 0;  // half open
    friend bool operator==(const IndexRange&, const IndexRange&) = default;
};
IndexRange parse_range(std::string_view text, std::string_view where);  // "128-256": begin <= index < end

std::array<double, 3> parse_vec3(std::string_view text, std::string_view where);  // "x,y,z"
double parse_duration_seconds(std::string_view text, std::string_view where);     // "30s", "2m", "1h", "1500ms"

}  // namespace parhelion
