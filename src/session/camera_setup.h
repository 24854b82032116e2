#pragma once
// The camera of a render, over the time that its shutter is open, with its lens.
#include <optional>
#include <string>

#include "scene/builtin.h"
#include "scene/camera.h"
#include "scene/camera_path.h"
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

// The camera of a job that plays frames: the one that set_up_camera has chosen, as time goes on.
class PlayedCamera {
public:
    // `first`: where it stands in the first frame. Its lens stays, and so does a camera that neither the scene nor a path moves.
    PlayedCamera(const Scene& scene, const RenderOptions& options, const CameraView& first);
    // `scene` is as it is at `seconds`.
    CameraView at(const Scene& scene, double seconds) const;

private:
    const RenderOptions& options_;
    CameraView first_;
    std::optional<CameraPath> path_;
    std::optional<Handle<Camera>> handle_;
};

// Metres along the camera's direction to what lies in the middle of its picture: the first surface, however transparent. Throws a
// usage Error if there is none.
float find_focus(const Scene& scene, const CameraView& view, bool culling);

}  // namespace parhelion
