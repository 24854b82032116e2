#pragma once
// The film's exact sums between the device, the parts of --spp-range, checkpoints (both are film EXRs) and pictures.
#include <filesystem>
#include <optional>
#include <span>

#include "image/film.h"
#include "renderers/view.h"
#include "scene/scene.h"
#include "session/render_options.h"
#include "session/render_settings.h"

namespace parhelion {

// Attributes of every EXR that a render writes. The hash covers scene, camera and all else that samples depend on; the number of
// samples and the device are no part of it.
inline constexpr const char* kExposureAttribute = "exposure_ev100";
inline constexpr const char* kSettingsAttribute = "settings_hash";
inline constexpr const char* kSamplesAttribute = "samples";  // pictures only
inline constexpr const char* kFrameAttribute = "frame_hash";  // frames only, in their PNGs too (session/frame_hash.h)

uint64_t hash_render(const Scene& scene, const ViewDesc& view, const RenderSettings& settings, double upscale = 1);
image::Attributes film_attributes(uint64_t settings_hash, double exposure_ev);
std::optional<double> recorded_exposure(const image::Attributes& attributes);

image::FilmSums make_film_sums(FilmReadback film, Size2 size, IndexRange samples, image::Attributes attributes);

// The way back, for View::restore_film: `layout` is the view's, whose film this is.
FilmReadback film_readback(image::FilmSums film, FilmReadback layout);

// The film of a checkpoint, which must be of the same render as `expected` (its sums are not looked at) and hold no more samples.
// Throws Error naming the file.
image::FilmSums read_checkpoint(const std::filesystem::path& file, const image::FilmSums& expected, IndexRange wanted);

}  // namespace parhelion
