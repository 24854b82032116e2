#pragma once
// Pictures denoised beside the caller, one at a time. Every picture belongs to a generation; a result of one that is over is never handed out.
#include <cstdint>
#include <future>
#include <optional>
#include <vector>

#include "image/denoise.h"
#include "session/film_state.h"

namespace parhelion {

struct FilmCopy {
    image::FilmSums sums;  // with the guides' layers
    std::vector<uint64_t> samples_of_rows;
};

class AsyncDenoiser {
public:
    AsyncDenoiser() = default;  // throws Error as image::Denoiser
    ~AsyncDenoiser() = default; // waits for what runs: nothing can end a thread

    bool is_idle() const { return !running_.valid(); }
    // Only while idle.
    void start(FilmCopy film);
    // What was begun shows something that is no more.
    void discard() { ++generation_; }
    // What has been denoised since, once. None: it still runs, was discarded, or nothing was begun. Throws Error if denoising failed and was not discarded.
    std::optional<image::ImageF> take();

private:
    image::Denoiser denoiser_;
    uint64_t generation_ = 0, begun_in_ = 0;
    std::future<image::ImageF> running_;  // destroyed, and so waited for, before the denoiser
};

}  // namespace parhelion
