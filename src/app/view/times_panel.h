#pragma once
// The passes of a frame with what the device took for them, and how frames came over the last seconds.
#include <vector>

#include "session/interactive.h"

namespace parhelion::view {

class TimesPanel {
public:
    void note(double frame_seconds);  // once a frame
    void show(const Interactive& session);  // into the open window

private:
    std::vector<PassTime> times_;    // smoothed
    std::vector<float> frames_ms_;   // the newest last
};

}  // namespace parhelion::view
