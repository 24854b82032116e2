#include "renderers/camera_motion.h"

#include <cmath>

#include <glm/gtc/quaternion.hpp>

namespace parhelion {

namespace {

glm::dmat3 frame_of(const shared::Camera& camera) {
    return {glm::normalize(glm::dvec3(camera.right_ws)), glm::normalize(glm::dvec3(camera.up_ws)), glm::normalize(glm::dvec3(camera.forward_ws))};
}

float growth(glm::vec3 begin, glm::vec3 end) { return static_cast<float>(glm::length(glm::dvec3(end)) / glm::length(glm::dvec3(begin)) - 1.0); }

}  // namespace

shared::CameraMotion camera_motion(const shared::Camera& begin, const shared::Camera& end) {
    glm::dquat turn = glm::quat_cast(frame_of(end) * glm::transpose(frame_of(begin)));
    if (turn.w < 0.0) turn = -turn;
    const glm::dvec3 axis(turn.x, turn.y, turn.z);
    const double sine = glm::length(axis);
    return {.translation_ws = glm::vec3(glm::dvec3(end.position_ws) - glm::dvec3(begin.position_ws)),
            .axis_ws = sine > 0.0 ? glm::vec3(axis / sine) : glm::vec3(0.0f, 1.0f, 0.0f),
            .half_angle = static_cast<float>(std::atan2(sine, turn.w)),
            .zoom = {growth(begin.right_ws, end.right_ws), growth(begin.up_ws, end.up_ws)}};
}

}  // namespace parhelion
