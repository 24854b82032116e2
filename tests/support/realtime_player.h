#pragma once
// The realtime renderer frame by frame, while scene and camera change: as a viewer has it, where Stage::play draws one film of a still scene.
#include "session/scene_setup.h"
#include "support/render_fixture.h"

namespace parhelion::testing {

class Player {
public:
    Player(Stage& stage, const Shot& shot, const RealtimeOptions& options)
        : view(stage.make_view(shot)), realtime(stage.frame.device(), view, options), stage_(stage), way_(shot.way), width_(shot.view.width), height_(shot.view.height) {}

    // Draws a frame after this edit; its picture alone.
    image::ImageF next(SceneEdit edit = {});
    // Draws so many frames, the first after this edit, and looks at none.
    void skip(uint32_t frames, SceneEdit edit = {});
    // The mean luminance of so many frames of a still scene.
    double mean(uint32_t frames);
    void set_camera(const CameraView& camera) { view.set_camera(shader_camera(camera, static_cast<float>(width_) / static_cast<float>(height_))); }

    View view;
    Realtime realtime;
    ChangeSet changes;  // of the last edit

private:
    void draw(SceneEdit edit);

    Stage& stage_;
    gpu::TraceWay way_;
    uint32_t width_, height_;
};

// Luminance of a pixel, and the mean of the picture's.
double luminance_of(const image::ImageF& picture, size_t pixel);
double mean_luminance(const image::ImageF& picture);

}  // namespace parhelion::testing
