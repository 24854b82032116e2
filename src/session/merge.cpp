#include "session/merge.h"

#include <algorithm>
#include <array>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "session/pictures.h"

namespace parhelion {

namespace {

// Paths in order of their samples.
std::vector<std::filesystem::path> sort_by_samples(std::span<const std::filesystem::path> parts) {
    std::vector<std::pair<uint64_t, std::filesystem::path>> begins;
    for (const std::filesystem::path& part : parts) begins.emplace_back(image::read_film_exr(part).sample_begin, part);
    std::stable_sort(begins.begin(), begins.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::filesystem::path> sorted;
    for (auto& [begin, part] : begins) sorted.push_back(std::move(part));
    return sorted;
}

}  // namespace

image::FilmSums merge_parts(std::span<const std::filesystem::path> parts) {
    const std::vector<std::filesystem::path> sorted = sort_by_samples(parts);
    PARHELION_CHECK(!sorted.empty(), "there are no parts");
    image::FilmSums merged = image::read_film_exr(sorted.front());
    if (merged.sample_begin != 0)
        throw Error(ErrorCode::Failed, fmt::format("the samples 0-{} are missing before it", merged.sample_begin),
                    escape_name(sorted.front().string()), "render them with --spp-range");
    for (size_t i = 1; i < sorted.size(); ++i) {
        const image::FilmSums next = image::read_film_exr(sorted[i]);
        const std::array<image::FilmPart, 2> pair = {image::FilmPart{&merged, sorted[i - 1].string()},
                                                     image::FilmPart{&next, sorted[i].string()}};
        merged = image::merge_films(pair);
    }
    return merged;
}

uint64_t merge_to_pictures(std::span<const std::filesystem::path> parts, const OutputOptions& output) {
    if (output.files.empty()) throw Error(ErrorCode::Usage, "there is no output", "merge", "add --out F.exr or --out F.png");
    for (const std::filesystem::path& file : output.files) {
        check_writable(file);
        if (std::find(parts.begin(), parts.end(), file) != parts.end())
            throw Error(ErrorCode::Usage, fmt::format("'{}' is a part too", escape_name(file.string())), "--out", "choose another output");
    }
    const image::FilmSums film = merge_parts(parts);
    const uint64_t samples = film.sample_end - film.sample_begin;
    write_pictures(output, resolve_rows(film, std::vector<uint64_t>(film.height, samples)));
    return samples;
}

}  // namespace parhelion
