#include "session/steered_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace parhelion {

namespace {

constexpr float kSteepest = 89.0f / 180.0f * std::numbers::pi_v<float>;  // looking straight up or down leaves no horizon to turn along
constexpr float kNarrowest = std::numbers::pi_v<float> / 180.0f, kWidest = 170.0f * kNarrowest;
constexpr float kNearest = 1e-4f, kFarthest = 1e7f;  // target, metres
constexpr float kAim = 0.05f;  // of the distance to the origin: so far off a point tells directions apart to a millionth

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

// The direction is that from point to point, as another look_at() will find it.
void SteeredCamera::look_along(float distance) {
    const float least = kAim * (1.0f + glm::length(view_.position));
    target_ = view_.position + view_.forward * std::clamp(distance, kNearest, kFarthest);
    aim_ = view_.position + view_.forward * std::max(distance, least);
    const CameraView level = look_at(view_.position, aim_, view_.yfov);
    view_.right = level.right, view_.up = level.up, view_.forward = level.forward;
    moved_ = true;
}

void SteeredCamera::look(float right, float up) {
    const float ahead = distance();
    turn(right, up);
    look_along(ahead);
}

void SteeredCamera::orbit(float right, float up) {
    const float ahead = distance();
    const glm::vec3 about = target_;
    turn(right, up);
    view_.position = about - view_.forward * ahead;
    look_along(ahead);
}

void SteeredCamera::pan(float right, float up) {
    const float ahead = distance(), height = 2.0f * view_.image_half_extents(1.0f).y * (view_.orthographic ? 1.0f : ahead);
    view_.position += (view_.right * right + view_.up * up) * height;
    turn(0, 0);
    look_along(ahead);
}

void SteeredCamera::approach(float factor) {
    const float ahead = distance();
    turn(0, 0);
    if (view_.orthographic) {
        view_.half_extents *= factor;
        return look_along(ahead);
    }
    const float left = std::clamp(ahead * factor, kNearest, kFarthest);
    view_.position = target_ - view_.forward * left;
    look_along(left);
}

void SteeredCamera::fly(const glm::vec3& move) {
    const float ahead = distance();
    view_.position += view_.right * move.x + view_.up * move.y + view_.forward * move.z;
    turn(0, 0);
    look_along(ahead);
}

void SteeredCamera::zoom(float factor) {
    if (!view_.orthographic) view_.yfov = std::clamp(view_.yfov * factor, kNarrowest, kWidest);
    turn(0, 0);
    look_along(distance());
}

void SteeredCamera::set_target(const glm::vec3& point) {
    const glm::vec3 along = point - view_.position;
    const float ahead = glm::length(along);
    if (!(ahead > kNearest)) return;
    view_.forward = along / ahead;
    turn(0, 0);
    look_along(ahead);
}

void SteeredCamera::set_aspect(float aspect) {
    if (view_.orthographic) view_.half_extents.x = view_.half_extents.y * aspect;
}

std::optional<glm::vec2> SteeredCamera::project(const glm::vec3& point, float aspect) const {
    const glm::vec3 along = point - view_.position;
    const float depth = glm::dot(along, view_.forward);
    if (!(depth > 0.0f)) return std::nullopt;
    const glm::vec2 half = view_.image_half_extents(aspect) * (view_.orthographic ? 1.0f : depth);
    return glm::vec2(glm::dot(along, view_.right), glm::dot(along, view_.up)) / half;
}

float orbit_distance(const CameraView& view, const Bounds& bounds) {
    if (bounds.empty()) return 1.0f;
    const float least = 0.01f * bounds.diagonal();
    return std::max({glm::dot(bounds.center() - view.position, view.forward), least, 1e-3f});
}

}  // namespace parhelion
