#pragma once
// A camera that a person steers: about a point, or as one flies. The world's vertical (+Y) is the picture's, except in views that
// have not been moved yet. One that has been moved is look_at(position, aim()) to the bit, so that two points and an angle say all of it
// (session/render_words.h). No Vulkan.
#include <optional>

#include "scene/camera.h"

namespace parhelion {

class SteeredCamera {
public:
    SteeredCamera() = default;
    // `distance` to the point that orbit() turns about, in metres; it lies in the middle of the picture.
    SteeredCamera(const CameraView& view, float distance) : view_(view), target_(view.position + view.forward * distance), aim_(target_) {}

    const CameraView& view() const { return view_; }
    float distance() const { return glm::distance(view_.position, target_); }
    glm::vec3 target() const { return target_; }
    bool has_moved() const { return moved_; }  // since it was made
    glm::vec3 aim() const { return aim_; }     // a point that it looks at: the target, or farther off where floats would not tell that apart

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
    // Looks at another point and turns about it from now on.
    void set_target(const glm::vec3& point);
    // Metres: 0 is a pinhole; along the direction to the plane that the lens shows sharp.
    void set_lens(float radius, float focus_distance) { view_.lens_radius = radius, view_.focus_distance = focus_distance; }
    // Where on the picture a point is seen: from -1 to 1, x to the right, y up. None: it is not in front of the camera.
    std::optional<glm::vec2> project(const glm::vec3& point, float aspect) const;
    // Of the picture, width over height: an orthographic camera keeps its height.
    void set_aspect(float aspect);

private:
    void turn(float right, float up);
    void look_along(float distance);  // to a target so far ahead
    CameraView view_;
    glm::vec3 target_{0.0f, 0.0f, -1.0f}, aim_ = target_;
    bool moved_ = false;
};

// How far the point in the middle of the view's picture is, as a first guess for orbits: that where it comes nearest to the middle of
// the bounds, but at least a hundredth of their diagonal in front of the camera.
float orbit_distance(const CameraView& view, const Bounds& bounds);

}  // namespace parhelion
