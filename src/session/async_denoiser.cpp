#include "session/async_denoiser.h"

#include <chrono>
#include <utility>

#include "base/error.h"
#include "session/pictures.h"

namespace parhelion {

void AsyncDenoiser::start(FilmCopy film) {
    PARHELION_CHECK(is_idle(), "two pictures are denoised at once");
    begun_in_ = generation_;
    running_ = std::async(std::launch::async, [this, film = std::move(film)] {
        image::ImageF picture = resolve_rows(film.sums, film.samples_of_rows);
        denoiser_.denoise(picture);
        return picture;
    });
}

std::optional<image::ImageF> AsyncDenoiser::take() {
    if (is_idle() || running_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
    std::future<image::ImageF> finished = std::exchange(running_, {});
    if (begun_in_ != generation_) return std::nullopt;
    return finished.get();
}

}  // namespace parhelion
