#pragma once
// Pictures from film sums: EXR (nits before exposure, all channels) and PNG (exposed and tone mapped).
#include <span>
#include <string>
#include <string_view>

#include "image/denoise.h"
#include "session/film_state.h"

namespace parhelion {

// The mean of every channel. `samples_of_rows` tells how many samples each row's sums hold: all the film's, unless a job stopped in
// the middle of some.
image::ImageF resolve_rows(const image::FilmSums& film, std::span<const uint64_t> samples_of_rows);

// The layers that a denoiser is guided by; a film that is to be denoised has them.
inline constexpr std::string_view kGuideLayers[] = {"albedo", "normal"};
inline constexpr const char* kDenoiserAttribute = "denoiser";

// The picture's R, G, B without noise. Guides that are not among `aovs` are taken out of it; with `keep_noisy` the colours of before become
// the layer "noisy". Throws Error as image::Denoiser.
void denoise_picture(const image::Denoiser& denoiser, std::span<const std::string> aovs, bool keep_noisy, image::ImageF& picture);

// Writes all files of the options. The image's attributes say its exposure.
void write_pictures(const OutputOptions& output, const image::ImageF& picture);

}  // namespace parhelion
