// Pictures of an interactive session for the disk, and without noise.
#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/log.h"
#include "session/film_state.h"
#include "session/interactive.h"
#include "session/pictures.h"

namespace parhelion {

// ---- without noise ----

bool Interactive::is_denoised() const { return !denoiser_ || !layer_.empty() || (denoised_samples_ >= options_.samples.end && denoiser_->is_idle()); }

// A film is given away when it has twice the samples of the one before, and when it is finished.
void Interactive::denoise() {
    const uint64_t have = samples(), wanted = std::min(std::max<uint64_t>(1, 2 * denoised_samples_), options_.samples.end);
    if (shrink_ != 1 || !layer_.empty() || !denoiser_->is_idle() || have < wanted || have == denoised_samples_) return;
    denoised_samples_ = have;
    denoiser_->start(copy_film());
}

void Interactive::take_denoised() {
    try {
        const std::optional<image::ImageF> picture = denoiser_->take();
        if (!picture) return;
        const image::RgbPlanes colours = image::rgb_planes(*picture);
        std::vector<float> texels(4 * picture->pixel_count(), 1.0f);
        for (size_t i = 0; i < picture->pixel_count(); ++i) texels[4 * i] = colours.r[i], texels[4 * i + 1] = colours.g[i], texels[4 * i + 2] = colours.b[i];
        denoised_ = gpu::Image(device_, "view/denoised", {.format = gpu::Format::Rgba32Float, .extent = {options_.size.width, options_.size.height}});
        frame_->upload_image(denoised_, std::as_bytes(std::span(texels)));
        fresh_ = true;
    } catch (const Error& error) {
        note_ = error.line;  // the noisy picture stays
        log_line(LogLevel::Error, error.line);
    }
}

void Interactive::show_denoised() {
    hdr_ = denoised_;
    shown_rows_ = {.samples = denoised_samples_};
    tone(hdr_, "view/picture", picture_);
}

// ---- a picture for the disk ----

void Interactive::save_picture(const std::vector<std::filesystem::path>& files) { to_save_ = files; }

// The film goes on as if nothing had happened: its last block is ended on a copy.
FilmCopy Interactive::copy_film() {
    const FilmRows rows = drawer_->rows();
    const passes::Film& film = view_->film();
    const gpu::Buffer block(device_, "film/kept_block", film.block.bytes()), sums(device_, "film/kept_sums", film.sums.bytes());
    frame_->copy(film.block, 0, block, 0, film.block.bytes());
    frame_->copy(film.sums, 0, sums, 0, film.sums.bytes());
    end_block(*frame_, *view_);
    FilmReadback read = view_->read_film(*frame_);
    frame_->copy(block, 0, film.block, 0, film.block.bytes());
    frame_->copy(sums, 0, film.sums, 0, film.sums.bytes());
    const uint64_t hash = hash_render(loaded_->scene, view_->desc(), settings_, options_.upscale);
    const Size2 size{view_->desc().width, view_->desc().height};
    std::vector<uint64_t> counts(size.height, rows.samples);
    std::fill_n(counts.begin(), rows.rows_ahead, rows.samples_ahead);
    return {make_film_sums(std::move(read), size, {0, rows.samples}, film_attributes(hash, show.exposure_ev)), std::move(counts)};
}

void Interactive::write_picture() {
    const FilmCopy film = copy_film();
    OutputOptions output{.files = std::exchange(to_save_, {}), .exr_float = options_.output.exr_float, .tonemap = show.curve};
    try {
        image::ImageF picture = resolve_rows(film.sums, film.samples_of_rows);
        if (denoiser_) denoise_picture(image::Denoiser(), options_.aovs, false, picture);
        write_pictures(output, picture);
        note_ = fmt::format("{} samples written to", film.sums.sample_end);
        for (const std::filesystem::path& file : output.files) note_ += " " + escape_name(file.string());
        log(LogLevel::Info, "{}", note_);
    } catch (const Error& error) {
        note_ = error.line;
        log_line(LogLevel::Error, error.line);
    }
}

}  // namespace parhelion
