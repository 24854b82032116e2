#include "session/compare.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "image/decode.h"
#include "image/encode.h"
#include "session/film_state.h"

namespace parhelion {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace detail {

std::vector<std::pair<std::string, fs::path>> find_frames(const std::string& pattern) {
    const fs::path path = pattern;
    const std::string name = path.filename().string();
    const size_t first = name.find('#');
    if (first == std::string::npos) return {{"", path}};
    const size_t last = name.find_last_of('#');
    const std::string prefix = name.substr(0, first), suffix = name.substr(last + 1);
    std::vector<std::pair<std::string, fs::path>> frames;
    std::error_code ec;
    for (const fs::directory_entry& entry : fs::directory_iterator(path.has_parent_path() ? path.parent_path() : ".", ec)) {
        const std::string file = entry.path().filename().string();
        if (file.size() < prefix.size() + suffix.size() + (last - first + 1) || !file.starts_with(prefix) || !file.ends_with(suffix))
            continue;
        const std::string number = file.substr(prefix.size(), file.size() - prefix.size() - suffix.size());
        if (number.find_first_not_of("0123456789") == std::string::npos) frames.emplace_back(number, entry.path());
    }
    if (frames.empty())
        throw Error(ErrorCode::Failed, "no file matches", escape_name(pattern), "# stands for digits: F.####.exr finds F.0001.exr");
    std::sort(frames.begin(), frames.end(), [](const auto& a, const auto& b) { return std::stoull(a.first) < std::stoull(b.first); });
    return frames;
}

}  // namespace detail

namespace {

ComparedFrame compare_pair(ComparedFrame frame, const std::string& layer, image::ImageF& test, image::ImageF& reference) {
    test = image::read_linear(frame.test);
    reference = image::read_linear(frame.reference);
    image::CompareOptions options{.layer = layer, .test_name = frame.test.string(), .reference_name = frame.reference.string()};
    if (const auto ev = recorded_exposure(reference.attributes)) {
        options.exposure_scale = image::exposure_scale_from_ev100(*ev);
        frame.exposure_recorded = true;
    }
    frame.result = image::compare_images(test, reference, options);
    return frame;
}

std::vector<ComparedFrame> pair_frames(const std::string& test, const std::string& reference) {
    const auto tests = detail::find_frames(test), references = detail::find_frames(reference);
    const bool sequence = !tests.front().first.empty();
    if (sequence == references.front().first.empty())
        throw Error(ErrorCode::Usage, "a sequence is compared with a sequence", "compare", "write both as F.####.exr");
    std::vector<ComparedFrame> frames;
    for (const auto& [number, path] : tests) {
        const auto found = std::find_if(references.begin(), references.end(),
                                        [&](const auto& other) { return !sequence || std::stoull(other.first) == std::stoull(number); });
        if (found == references.end())
            throw Error(ErrorCode::Failed, fmt::format("frame {} is missing", number), escape_name(reference), "render it");
        frames.push_back({.name = number, .test = path, .reference = found->second});
    }
    for (const auto& [number, path] : references)
        if (std::none_of(tests.begin(), tests.end(),
                         [&](const auto& other) { return !sequence || std::stoull(other.first) == std::stoull(number); }))
            throw Error(ErrorCode::Failed, fmt::format("frame {} is missing", number), escape_name(test), "render it");
    return frames;
}

std::string file_name(const ComparedFrame& frame, const std::string& kind) {
    return frame.name.empty() ? kind + ".png" : fmt::format("{}.{}.png", kind, frame.name);
}

// Both pictures as the comparison exposed them, and the FLIP map.
void write_report_pictures(const ComparedFrame& frame, const std::string& layer, const image::ImageF& test, const image::ImageF& reference,
                           const fs::path& folder) {
    const image::ToneCurve curve = frame.result.display_referred ? image::ToneCurve::Linear : image::ToneCurve::Agx;
    const double scale = frame.result.exposure_scale;
    image::write_png(folder / file_name(frame, "test"), image::tonemap_to_srgb(test, curve, scale, layer));
    image::write_png(folder / file_name(frame, "reference"), image::tonemap_to_srgb(reference, curve, scale, layer));
    image::write_png(folder / file_name(frame, "flip"), image::flip_picture(frame.result.flip, frame.result.width, frame.result.height));
}

void prepare_folder(const fs::path& folder) {
    std::error_code ec;
    fs::create_directory(folder, ec);
    if (!fs::is_directory(folder, ec))
        throw Error(ErrorCode::Failed, "the folder cannot be made", escape_name(folder.string()), "choose a folder that you may write to");
    check_writable(folder / "index.html");
}

// NaN is over every limit.
void check_limit(CompareReport& report, std::string_view what, std::optional<double> limit, double (*value)(const ComparedFrame&)) {
    if (!limit) return;
    const auto over = [&](const ComparedFrame& frame) { return !(value(frame) <= *limit); };
    const auto count = std::count_if(report.frames.begin(), report.frames.end(), over);
    if (count == 0) return;
    const auto worst =
        std::max_element(report.frames.begin(), report.frames.end(), [&](const auto& a, const auto& b) { return value(a) < value(b); });
    std::string line = fmt::format("{} is {:.6g}, the limit is {:.6g}", what, value(*worst), *limit);
    if (!worst->name.empty()) line += fmt::format(" ({} of {} frames are over it, worst {})", count, report.frames.size(), worst->name);
    report.exceeded.push_back(line);
}

void check_limits(CompareReport& report, const CompareLimits& limits) {
    check_limit(report, "FLIP", limits.flip, [](const ComparedFrame& frame) { return frame.result.flip.mean; });
    check_limit(report, "relMSE", limits.relmse, [](const ComparedFrame& frame) { return frame.result.relmse; });
    if (limits.flip || limits.relmse)
        check_limit(report, "the number of broken pixels (NaN, infinite)", 0.0,
                    [](const ComparedFrame& frame) { return static_cast<double>(frame.result.bad.nan + frame.result.bad.infinite); });
}

Json numbers_json(const image::Comparison& c) {
    return {{"mean_ratio", c.mean_ratio.luminance},
            {"mean_ratio_rgb", {c.mean_ratio.r, c.mean_ratio.g, c.mean_ratio.b}},
            {"mse", c.mse},
            {"relmse", c.relmse},
            {"max_abs_error", c.max_abs_error},
            {"psnr", c.psnr},
            {"ssim", c.ssim},
            {"flip", c.flip.mean},
            {"nan_count", c.bad.nan},
            {"inf_count", c.bad.infinite},
            {"negative_count", c.bad.negative},
            {"reference_nan_count", c.reference_bad.nan}};
}

// Means over the frames, counts as sums.
image::Comparison mean_of(const std::vector<ComparedFrame>& frames) {
    image::Comparison mean;
    const double share = 1.0 / static_cast<double>(frames.size());
    for (const ComparedFrame& frame : frames) {
        const image::Comparison& c = frame.result;
        mean.mean_ratio.r += share * c.mean_ratio.r;
        mean.mean_ratio.g += share * c.mean_ratio.g;
        mean.mean_ratio.b += share * c.mean_ratio.b;
        mean.mean_ratio.luminance += share * c.mean_ratio.luminance;
        mean.mse += share * c.mse;
        mean.relmse += share * c.relmse;
        mean.max_abs_error = std::max(mean.max_abs_error, c.max_abs_error);
        mean.psnr += share * c.psnr;
        mean.ssim += share * c.ssim;
        mean.flip.mean += share * c.flip.mean;
        mean.bad.nan += c.bad.nan;
        mean.bad.infinite += c.bad.infinite;
        mean.bad.negative += c.bad.negative;
        mean.reference_bad.nan += c.reference_bad.nan;
    }
    return mean;
}

// The frame that differs most by FLIP; one with NaN is worst of all.
const ComparedFrame& worst_frame(const CompareReport& report) {
    const auto error = [](const ComparedFrame& frame) { return std::isnan(frame.result.flip.mean) ? 2.0 : double(frame.result.flip.mean); };
    return *std::ranges::max_element(report.frames, {}, error);
}

std::string frame_table(const CompareReport& report) {
    std::string out = fmt::format("{:>8}  {:>10}  {:>12}  {:>12}  {:>9}  {:>7}\n", "frame", "mean ratio", "MSE", "relMSE", "PSNR", "FLIP");
    for (const ComparedFrame& frame : report.frames) {
        const image::Comparison& c = frame.result;
        out += fmt::format("{:>8}  {:>10.6g}  {:>12.6g}  {:>12.6g}  {:>6.2f} dB  {:>7.5f}\n", frame.name, c.mean_ratio.luminance, c.mse, c.relmse, c.psnr, c.flip.mean);
    }
    const ComparedFrame& worst = worst_frame(report);
    return out + fmt::format("worst       frame {}: FLIP {:.5f}\n", worst.name, worst.result.flip.mean);
}

}  // namespace

CompareReport compare_files(const std::string& test, const std::string& reference, const std::string& layer, const CompareLimits& limits,
                            const fs::path& html) {
    CompareReport report{.test = test, .reference = reference, .frames = pair_frames(test, reference)};
    if (!html.empty()) prepare_folder(html);
    for (ComparedFrame& frame : report.frames) {
        image::ImageF test_image, reference_image;
        frame = compare_pair(std::move(frame), layer, test_image, reference_image);
        if (!html.empty()) write_report_pictures(frame, layer, test_image, reference_image, html);
        frame.result.flip.map = {};
    }
    check_limits(report, limits);
    if (!html.empty()) write_text_file(html / "index.html", detail::html_page(report));
    return report;
}

Json compare_json(const CompareReport& report) {
    Json out = {{"test", report.test}, {"reference", report.reference}};
    out.update(numbers_json(mean_of(report.frames)));
    const image::Comparison& first = report.frames.front().result;
    out["size"] = {first.width, first.height};
    out["exposure_scale"] = first.exposure_scale;
    out["exposure_recorded"] = report.frames.front().exposure_recorded;
    out["flip_kind"] = first.display_referred ? "ldr" : "hdr";
    out["exceeded"] = report.exceeded;
    if (report.frames.front().name.empty()) return out;
    out["worst_frame"] = worst_frame(report).name;
    out["frames"] = Json::array();
    for (const ComparedFrame& frame : report.frames) {
        Json entry = {{"frame", frame.name}};
        entry.update(numbers_json(frame.result));
        out["frames"].push_back(std::move(entry));
    }
    return out;
}

std::string compare_text(const CompareReport& report) {
    const image::Comparison mean = mean_of(report.frames);
    std::string out;
    if (!report.frames.front().name.empty()) out += frame_table(report) + fmt::format("frames      {} (means)\n", report.frames.size());
    out += fmt::format(
        "mean ratio  {:.6g}\nMSE         {:.6g}\nrelMSE      {:.6g}\nPSNR        {:.2f} dB\nSSIM        {:.5f}\nFLIP        {:.5f}\n",
        mean.mean_ratio.luminance, mean.mse, mean.relmse, mean.psnr, mean.ssim, mean.flip.mean);
    if (mean.bad.nan + mean.bad.infinite + mean.bad.negative > 0)
        out += fmt::format("broken      {} NaN, {} infinite, {} negative pixels\n", mean.bad.nan, mean.bad.infinite, mean.bad.negative);
    return out;
}

}  // namespace parhelion
