#include "support/realtime_player.h"

#include "session/film_state.h"

namespace parhelion::testing {

void Player::draw(SceneEdit edit) {
    changes = stage_.step(std::move(edit));
    stage_.scene_gpu.finish(stage_.frame);
    view.clear_film();
    realtime.record(stage_.frame, stage_.scene_gpu, way_, view, true);
    stage_.frame.run();
}

image::ImageF Player::next(SceneEdit edit) {
    draw(std::move(edit));
    return image::resolve_film(make_film_sums(view.read_film(stage_.frame), {width_, height_}, {0, 1}, {}));
}

void Player::skip(uint32_t frames, SceneEdit edit) {
    for (uint32_t i = 0; i < frames; ++i) draw(i == 0 ? std::move(edit) : SceneEdit());
}

double Player::mean(uint32_t frames) {
    stage_.step({});
    stage_.scene_gpu.finish(stage_.frame);
    view.clear_film();
    for (uint32_t i = 1; i <= frames; ++i) {
        realtime.record(stage_.frame, stage_.scene_gpu, way_, view, i == frames);
        stage_.frame.run();
    }
    return mean_luminance(image::resolve_film(make_film_sums(view.read_film(stage_.frame), {width_, height_}, {0, frames}, {})));
}

double luminance_of(const image::ImageF& picture, size_t pixel) {
    return 0.2126 * picture.plane(0)[pixel] + 0.7152 * picture.plane(1)[pixel] + 0.0722 * picture.plane(2)[pixel];
}

double mean_luminance(const image::ImageF& picture) {
    double sum = 0;
    for (size_t p = 0; p < picture.pixel_count(); ++p) sum += luminance_of(picture, p);
    return sum / static_cast<double>(picture.pixel_count());
}

}  // namespace parhelion::testing
