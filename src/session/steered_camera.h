#pragma once
// A camera that a person steers: about a point, or as one flies. The world's vertical (+Y) stays the picture's, except in views that
// have not been turned yet. No Vulkan.
#include "scene/camera.h"

namespace parhelion {

class SteeredCamera {
public:
    SteeredCamera() = default;
    // `distance` to the point that orbit() turns about, in metres; it lies in the middle of the picture.
    SteeredCamera(const CameraView& view, float distance) : view_(view), distance_(distance) {}

    const CameraView& view() const { return view_; }
    float distance() const { return distance_; }
    glm::vec3 target() const { return view_.position + view_.forward * distance_; }

    // Radians: to the right and up. orbit() keeps target() where it is, look() the camera.
    void orbit(float right, float up);
    void look(float right, float up);
    // Moves camera and target across the picture, by fractions of its height as seen at the target.
    void pan(float right, float up);
    // Goes nearer to the target, by a factor on the distance to it. An orthographic camera shows less instead.
    void approach(float factor);
    // Moves camera and target along the camera's own axes, in metres.
    void fly(const glm::vec3& right_up_forward);
    // A factor on the field of view, which stays between 1 and 170 degrees (perspective only).
    void zoom(float factor);
    // Of the picture, width over height: an orthographic camera keeps its height.
    void set_aspect(float aspect);

private:
    void turn(float right, float up);
    CameraView view_;
    float distance_ = 1.0f;
};

// How far the point in the middle of the view's picture is, as a first guess for orbits: that where it comes nearest to the middle of
// the bounds, but at least a hundredth of their diagonal in front of the camera.
float orbit_distance(const CameraView& view, const Bounds& bounds);

}  // namespace parhelion
