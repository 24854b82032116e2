#include "session/pictures.h"

#include <algorithm>

#include "base/error.h"
#include "base/log.h"
#include "image/encode.h"

namespace parhelion {

image::ImageF resolve_rows(const image::FilmSums& film, std::span<const uint64_t> samples_of_rows) {
    image::ImageF picture = image::resolve_film(film, samples_of_rows);
    picture.attributes[kSamplesAttribute] = fmt::format("{}", film.sample_end - film.sample_begin);
    return picture;
}

namespace {

void remove_layer(std::string_view layer, image::ImageF& picture) {
    const std::string prefix = std::string(layer) + ".";
    for (size_t c = picture.channels.size(); c-- > 0;) {
        if (!picture.channels[c].starts_with(prefix)) continue;
        const auto begin = picture.data.begin() + static_cast<std::ptrdiff_t>(c * picture.pixel_count());
        picture.data.erase(begin, begin + static_cast<std::ptrdiff_t>(picture.pixel_count()));
        picture.channels.erase(picture.channels.begin() + static_cast<std::ptrdiff_t>(c));
    }
}

}  // namespace

void denoise_picture(const image::Denoiser& denoiser, std::span<const std::string> aovs, bool keep_noisy, image::ImageF& picture) {
    if (keep_noisy) {
        for (const char* name : {"R", "G", "B"}) {
            const auto copy = picture.add_channel(fmt::format("noisy.{}", name));
            std::ranges::copy(picture.plane(picture.find_channel(name).value()), copy.begin());
        }
    }
    denoiser.denoise(picture);
    for (const std::string_view guide : kGuideLayers)
        if (std::ranges::find(aovs, guide) == aovs.end()) remove_layer(guide, picture);
    picture.attributes[kDenoiserAttribute] = fmt::format("Open Image Denoise {}", denoiser.version());
}

void write_pictures(const OutputOptions& output, const image::ImageF& picture) {
    const double scale = image::exposure_scale_from_ev100(recorded_exposure(picture.attributes).value_or(0));
    for (const std::filesystem::path& file : output.files) {
        if (is_png(file)) {
            image::Picture8 shown = image::tonemap_to_srgb(picture, output.tonemap, scale);
            if (const auto found = picture.attributes.find(kFrameAttribute); found != picture.attributes.end()) shown.attributes.insert(*found);
            image::write_png(file, shown);
            continue;
        }
        const uint64_t clamped = image::write_exr(file, picture, output.exr_float ? image::ExrPrecision::Float : image::ExrPrecision::Half);
        if (clamped != 0)
            log(LogLevel::Warn, "{}: {} values are too bright for half and were written as 65504 (--exr-type float keeps them)",
                escape_name(file.string()), clamped);
    }
}

}  // namespace parhelion
