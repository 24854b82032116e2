#include "scene/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace parhelion {

namespace {

// An orthonormal frame that looks along `forward` (unit) with the image's vertical nearest to `up_hint`.
void set_frame(CameraView& view, glm::dvec3 forward, glm::dvec3 up_hint) {
    glm::dvec3 right = glm::cross(forward, up_hint);
    // Looking straight up or down: the image's top is then where -Z (down) or +Z (up) lies, as a head tilts.
    if (glm::dot(right, right) < 1e-12 * glm::dot(up_hint, up_hint))
        right = glm::cross(forward, glm::dvec3(0.0, 0.0, forward.y < 0.0 ? -1.0 : 1.0));
    if (glm::dot(right, right) < 1e-12) right = glm::cross(forward, glm::dvec3(0.0, 1.0, 0.0));
    right = glm::normalize(right);
    view.forward = glm::vec3(forward);
    view.right = glm::vec3(right);
    view.up = glm::vec3(glm::cross(right, forward));
}

std::string camera_list(const Scene& scene) {
    std::string out;
    size_t index = 0;
    for (const auto& [handle, camera] : scene.cameras())
        out += fmt::format("{}{} '{}'", index == 0 ? "" : ", ", index, escape_name(camera.name)), ++index;
    return index == 0 ? "the scene has no camera: use --look-from and --look-at" : "cameras: " + out;
}

}  // namespace

glm::vec2 CameraView::image_half_extents(float aspect) const {
    if (orthographic) return half_extents;
    const float half = std::tan(0.5f * yfov);
    return {half * aspect, half};
}

CameraView look_at(glm::vec3 from, glm::vec3 at, float yfov) {
    const glm::dvec3 along = glm::dvec3(at) - glm::dvec3(from);
    const double distance = glm::length(along);
    if (!(distance > 0.0) || !std::isfinite(distance))
        throw Error(ErrorCode::Usage, "the camera looks at the point where it stands", "--look-at", "give two different points");
    CameraView view;
    view.position = from;
    view.yfov = yfov;
    view.near_plane = static_cast<float>(std::min(0.01, 0.01 * distance));
    set_frame(view, along / distance, {0.0, 1.0, 0.0});
    return view;
}

CameraView view_of(const Camera& camera, float aspect) {
    const glm::dmat4 world(camera.place.world_from_object);
    CameraView view;
    view.position = glm::vec3(world[3]);
    // Only position and direction of the placement count: scale and shear do not reach the image.
    const glm::dvec3 back(world[2]);
    const double length = glm::length(back);
    set_frame(view, length > 0.0 ? -back / length : glm::dvec3(0.0, 0.0, -1.0), glm::dvec3(world[1]));
    view.near_plane = camera.near_plane;
    view.orthographic = camera.kind == CameraKind::Orthographic;
    view.yfov = camera.yfov;
    if (view.orthographic) {
        view.half_extents = {std::max(camera.xmag, camera.ymag * aspect), std::max(camera.ymag, camera.xmag / aspect)};
        view.far_plane = camera.far_plane.value_or(camera.near_plane + 1000.0f);
    }
    return view;
}

CameraView framing_view(const Bounds& bounds, float aspect) {
    constexpr float kYfov = 0.7f;     // 40 degrees
    constexpr float kMargin = 1.08f;  // room around the scene
    const glm::vec3 center = bounds.empty() ? glm::vec3(0.0f) : bounds.center();
    const glm::vec3 half = bounds.empty() ? glm::vec3(1.0f) : glm::max(0.5f * (bounds.max - bounds.min), 1e-4f * bounds.diagonal());
    const glm::vec3 towards_camera = glm::normalize(glm::vec3(0.45f, 0.35f, 1.0f));
    CameraView view = look_at(center + towards_camera, center, kYfov);
    // The nearest distance at which every corner of the box lies inside the image.
    const glm::vec2 extents = view.image_half_extents(aspect) / kMargin;
    float distance = 0.0f;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y, corner & 4 ? half.z : -half.z);
        const float depth = glm::dot(p, view.forward);
        distance =
            std::max({distance, std::abs(glm::dot(p, view.right)) / extents.x - depth, std::abs(glm::dot(p, view.up)) / extents.y - depth});
    }
    if (!(distance > 0.0f)) distance = 1.0f;  // a single point
    view.position = center + distance * towards_camera;
    view.near_plane = 1e-3f * distance;
    return view;
}

Handle<Camera> find_camera(const Scene& scene, std::string_view name_or_index) {
    for (const auto& [handle, camera] : scene.cameras())
        if (!camera.name.empty() && camera.name == name_or_index) return handle;
    size_t wanted = 0;
    const auto [end, error] = std::from_chars(name_or_index.data(), name_or_index.data() + name_or_index.size(), wanted);
    if (error == std::errc{} && end == name_or_index.data() + name_or_index.size()) {
        size_t index = 0;
        for (const auto& [handle, camera] : scene.cameras())
            if (index++ == wanted) return handle;
    }
    throw Error(ErrorCode::Usage, fmt::format("there is no camera '{}'", escape_name(name_or_index)), "--camera", camera_list(scene));
}

glm::mat4 view_from_world(const CameraView& view) {
    const auto row = [&](glm::vec3 axis) { return glm::vec4(axis, -glm::dot(axis, view.position)); };
    return glm::transpose(glm::mat4(row(view.right), row(view.up), row(-view.forward), glm::vec4(0.0f, 0.0f, 0.0f, 1.0f)));
}

glm::mat4 clip_from_view(const CameraView& view, float aspect) {
    const glm::vec2 half = view.image_half_extents(aspect);
    glm::mat4 m(0.0f);
    m[0][0] = 1.0f / half.x;
    m[1][1] = -1.0f / half.y;  // y down
    if (view.orthographic) {
        const float depth = view.far_plane - view.near_plane;
        m[2][2] = 1.0f / depth;
        m[3][2] = view.far_plane / depth;
        m[3][3] = 1.0f;
    } else {
        m[2][3] = -1.0f;  // w = distance along the view direction
        m[3][2] = view.near_plane;
    }
    return m;
}

glm::mat4 clip_from_world(const CameraView& view, float aspect) { return clip_from_view(view, aspect) * view_from_world(view); }

}  // namespace parhelion
