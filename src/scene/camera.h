#pragma once
// Cameras as renderers use them: an orthonormal frame and an angle, and the matrices of one (column vectors, right-handed, +Y up).
#include <string_view>

#include "scene/scene.h"

namespace parhelion {

struct CameraView {
    glm::vec3 position{0.0f};                                                             // world, metres
    glm::vec3 right{1.0f, 0.0f, 0.0f}, up{0.0f, 1.0f, 0.0f}, forward{0.0f, 0.0f, -1.0f};  // orthonormal, right = forward x up
    bool orthographic = false;
    float yfov = 0.8f;             // perspective: full vertical angle, radians
    glm::vec2 half_extents{1.0f};  // orthographic: metres, for the aspect that the view was made for
    float near_plane = 0.01f;      // metres, for depth only
    float far_plane = 1000.0f;     // orthographic depth only; perspective has none
    float lens_radius = 0.0f;      // metres; 0: everything is sharp. An orthographic lens blurs about parallel rays (telecentric)
    float focus_distance = 1.0f;   // metres along `forward` to the plane that a lens shows sharp

    // Half extents of the image at unit distance (perspective) or in metres (orthographic).
    glm::vec2 image_half_extents(float aspect) const;
};

// Looks from one point at another; the image's vertical is as near +Y as can be. Throws Error if the points coincide.
CameraView look_at(glm::vec3 from, glm::vec3 at, float yfov);

// The view of a scene's camera for an image of `aspect` = width / height. Perspective keeps yfov, whatever the file's own aspect
// (glTF 2.0, 3.10.3); orthographic shows at least xmag x ymag, undistorted.
CameraView view_of(const Camera& camera, float aspect);

// A camera that has the whole scene in its image, seen from the front, a little from above and the right.
CameraView framing_view(const Bounds& bounds, float aspect);

// By name, else by index in slot order. Throws a usage Error that lists the cameras.
Handle<Camera> find_camera(const Scene& scene, std::string_view name_or_index);

glm::mat4 view_from_world(const CameraView& view);
// Vulkan clip space (x right, y down); depth 1 at the near plane falls to 0 at infinity (perspective: reversed z, infinite far,
// Lapidous and Jiao 1999; Upchurch and Desbrun 2012) or at the far plane (orthographic).
glm::mat4 clip_from_view(const CameraView& view, float aspect);
glm::mat4 clip_from_world(const CameraView& view, float aspect);

}  // namespace parhelion
