#pragma once
// The panels over the picture, by Dear ImGui.
#include <string>
#include <vector>

#include "app/view/times_panel.h"
#include "app/view/window.h"
#include "gpu/swapchain.h"
#include "session/interactive.h"

namespace parhelion::view {

class Panels {
public:
    explicit Panels(const Window& window, const gpu::DevicePtr& device);
    ~Panels();
    Panels(const Panels&) = delete;
    Panels& operator=(const Panels&) = delete;

    // What the person did since the last frame that no panel wants.
    struct Input {
        float move_x = 0, move_y = 0, wheel = 0;  // pixels, notches
        bool left = false, right = false, middle = false;
        bool keys = true;  // they are not for a panel
        float seconds = 0;  // since the last frame
        bool clicked = false, double_clicked = false;  // left
    };
    // Begins a frame, with all panels.
    Input begin(Interactive& session, gpu::Swapchain& swapchain);
    // Draws them over the picture.
    void draw(Frame& frame, const gpu::Image& canvas);

    // Does it; where it is refused, the session's note says why. A lost device is for the caller.
    static void change(Interactive& session, const std::function<void()>& what);

    bool shown = true, help = false;
    std::string wanted_device;  // chosen by its number; empty: none
    bool wants_copy = false, wants_preset_file = false;  // buttons for what Controls does

private:
    void show_state(Interactive& session, gpu::Swapchain& swapchain);
    void show_help();

    gpu::DevicePtr device_;
    gpu::Image font_;
    float scale_ = 1;
    double frame_seconds_ = 0;
    TimesPanel times_;
};

}  // namespace parhelion::view
