#pragma once
// Pictures from film sums: EXR (nits before exposure, all channels) and PNG (exposed and tone mapped).
#include <span>

#include "session/film_state.h"

namespace parhelion {

// The mean of every channel. `samples_of_rows` tells how many samples each row's sums hold: all the film's, unless a job stopped in
// the middle of some.
image::ImageF resolve_rows(const image::FilmSums& film, std::span<const uint64_t> samples_of_rows);

// Writes all files of the options. The image's attributes say its exposure.
void write_pictures(const OutputOptions& output, const image::ImageF& picture);

}  // namespace parhelion
