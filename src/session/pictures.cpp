#include "session/pictures.h"

#include "base/error.h"
#include "base/log.h"
#include "image/encode.h"

namespace parhelion {

image::ImageF resolve_rows(const image::FilmSums& film, std::span<const uint64_t> samples_of_rows) {
    image::ImageF picture = image::resolve_film(film, samples_of_rows);
    picture.attributes[kSamplesAttribute] = fmt::format("{}", film.sample_end - film.sample_begin);
    return picture;
}

void write_pictures(const OutputOptions& output, const image::ImageF& picture) {
    const double scale = image::exposure_scale_from_ev100(recorded_exposure(picture.attributes).value_or(0));
    for (const std::filesystem::path& file : output.files) {
        if (is_png(file)) {
            image::write_png(file, image::tonemap_to_srgb(picture, output.tonemap, scale));
            continue;
        }
        const uint64_t clamped = image::write_exr(file, picture, output.exr_float ? image::ExrPrecision::Float : image::ExrPrecision::Half);
        if (clamped != 0)
            log(LogLevel::Warn, "{}: {} values are too bright for half and were written as 65504 (--exr-type float keeps them)",
                escape_name(file.string()), clamped);
    }
}

}  // namespace parhelion
