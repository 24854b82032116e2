#pragma once
// The camera of a render, over the time that its shutter is open, with its lens.
#include <optional>
#include <string>

#include "scene/builtin.h"
#include "scene/camera.h"
#include "session/render_options.h"

namespace parhelion {

struct MovingCamera {
    CameraView opens;                  // where it stands when the shutter opens
    std::optional<CameraView> closes;  // and when it closes; none: it is still
};

// The camera that the options choose at --time, and at the end of --shutter: on its path, or where the scene's animations or its
// scripted edit have taken it. Leaves the scene as it is. `culling`: single-sided surfaces are no focus from behind. Throws Error for
// options that do not fit the scene.
MovingCamera set_up_camera(LoadedScene& loaded, const RenderOptions& options, bool culling, std::string& description);

// Metres along the camera's direction to what lies in the middle of its picture: the first surface, however transparent. Throws a
// usage Error if there is none.
float find_focus(const Scene& scene, const CameraView& view, bool culling);

}  // namespace parhelion
