#pragma once
// A dark room with one light that can be switched off and on.
#include "truth/truth.h"

namespace parhelion::testing {

// The one light of a room that is dark without it.
enum class Lit { Sun, Lamp, Mesh };

// The room, and the edits that take that away and give it back.
struct Switched {
    LoadedScene loaded;
    std::function<SceneEdit(bool on)> set;
};

Switched make_switched(Lit lit);
CameraView switched_room_camera();

}  // namespace parhelion::testing
