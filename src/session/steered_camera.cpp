#include "session/steered_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace parhelion {

namespace {

constexpr float kSteepest = 89.0f / 180.0f * std::numbers::pi_v<float>;  // looking straight up or down leaves no horizon to turn along
constexpr float kNarrowest = std::numbers::pi_v<float> / 180.0f, kWidest = 170.0f * kNarrowest;

}  // namespace

void SteeredCamera::turn(float right, float up) {
    const glm::vec3 f = view_.forward;
    // At the poles the picture's top tells which way is ahead.
    const bool steep = std::abs(f.y) > 0.9999f;
    const glm::vec3 flat = steep ? view_.up * (f.y > 0.0f ? -1.0f : 1.0f) : f;
    const float yaw = std::atan2(flat.x, -flat.z) + right;
    const float pitch = std::clamp(std::asin(std::clamp(f.y, -1.0f, 1.0f)) + up, -kSteepest, kSteepest);
    view_.forward = {std::sin(yaw) * std::cos(pitch), std::sin(pitch), -std::cos(yaw) * std::cos(pitch)};
    view_.right = {std::cos(yaw), 0.0f, std::sin(yaw)};
    view_.up = glm::cross(view_.right, view_.forward);
}

void SteeredCamera::look(float right, float up) { turn(right, up); }

void SteeredCamera::orbit(float right, float up) {
    const glm::vec3 about = target();
    turn(right, up);
    view_.position = about - view_.forward * distance_;
}

void SteeredCamera::pan(float right, float up) {
    const float height = 2.0f * view_.image_half_extents(1.0f).y * (view_.orthographic ? 1.0f : distance_);
    view_.position += (view_.right * right + view_.up * up) * height;
}

void SteeredCamera::approach(float factor) {
    if (view_.orthographic) {
        view_.half_extents *= factor;
        return;
    }
    const glm::vec3 about = target();
    distance_ = std::clamp(distance_ * factor, 1e-4f, 1e7f);
    view_.position = about - view_.forward * distance_;
}

void SteeredCamera::fly(const glm::vec3& move) { view_.position += view_.right * move.x + view_.up * move.y + view_.forward * move.z; }

void SteeredCamera::zoom(float factor) {
    if (!view_.orthographic) view_.yfov = std::clamp(view_.yfov * factor, kNarrowest, kWidest);
}

void SteeredCamera::set_aspect(float aspect) {
    if (view_.orthographic) view_.half_extents.x = view_.half_extents.y * aspect;
}

float orbit_distance(const CameraView& view, const Bounds& bounds) {
    if (bounds.empty()) return 1.0f;
    const float least = 0.01f * bounds.diagonal();
    return std::max({glm::dot(bounds.center() - view.position, view.forward), least, 1e-3f});
}

}  // namespace parhelion
