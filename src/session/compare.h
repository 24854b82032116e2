#pragma once
// `parhelion compare`: pictures or sequences against their references, as numbers and as a report.
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "image/compare.h"

namespace parhelion {

struct CompareLimits {
    std::optional<double> flip, relmse;
};

struct ComparedFrame {
    std::string name;  // number of a frame of a sequence; "" for a single picture
    std::filesystem::path test, reference;
    image::Comparison result;
    bool exposure_recorded = false;  // in the reference; else it was metered from it
};

struct CompareReport {
    std::string test, reference;  // as named by the user
    std::vector<ComparedFrame> frames;
    std::vector<std::string> exceeded;  // one line for each limit that some frame went over
};

// A picture, or a sequence "F.####.exr" (one run of '#', which stands for a number of at least that many digits). A frame that only
// one side has is an Error. `layer`: "" is the beauty. `html`: a folder for the report, made if it is not there; empty: none.
CompareReport compare_files(const std::string& test, const std::string& reference, const std::string& layer, const CompareLimits& limits,
                            const std::filesystem::path& html);

nlohmann::ordered_json compare_json(const CompareReport& report);  // the means over the frames, and each frame
std::string compare_text(const CompareReport& report);

namespace detail {
// Files of a sequence by frame number; the pattern itself under "" if it is no sequence.
std::vector<std::pair<std::string, std::filesystem::path>> find_frames(const std::string& pattern);
std::string html_text(std::string_view text);  // escaped
std::string html_page(const CompareReport& report);
}  // namespace detail

}  // namespace parhelion
