#pragma once
// `parhelion merge`: the parts of `render --spp-range` become one picture, bit for bit that of a render of all samples.
#include <filesystem>
#include <span>

#include "image/film.h"
#include "session/render_options.h"

namespace parhelion {

// The film of all parts, in any order. Holds three films in memory, however many parts there are. Throws Error for parts that
// overlap, that leave a gap (one before the first included), or that are not of one render.
image::FilmSums merge_parts(std::span<const std::filesystem::path> parts);

// merge_parts and the pictures. Outputs are checked before the first part is read. Returns the number of samples.
uint64_t merge_to_pictures(std::span<const std::filesystem::path> parts, const OutputOptions& output);

}  // namespace parhelion
