#pragma once
// What mouse and keys mean.
#include "app/view/panels.h"

namespace parhelion::view {

class Controls {
public:
    // The window's keys come here from now on.
    Controls(Window& window, Interactive& session, Panels& panels);

    // Between two frames: moves the camera by what the mouse and held keys say.
    void steer(const Panels::Input& input);
    // Writes the picture where --out says, else beside the caller under the scene's name.
    void save();

private:
    void press(int key);
    void next_camera();

    Window& window_;
    Interactive& session_;
    Panels& panels_;
    size_t camera_ = 0;
    bool keys_ = true;  // are not for a panel
    unsigned saved_ = 0;
};

}  // namespace parhelion::view
