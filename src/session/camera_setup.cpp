#include "session/camera_setup.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/log.h"
#include "scene/deform.h"
#include "scene/pose.h"
#include "session/scene_setup.h"

namespace parhelion {

namespace {

constexpr double kNothing = std::numeric_limits<double>::infinity();

// The scene's camera as it is at `seconds`.
Camera moved_camera(LoadedScene& loaded, Handle<Camera> handle, const LoadOptions& load, double seconds) {
    Scene& scene = loaded.scene;
    const auto edit = std::find_if(loaded.scripted_edits.begin(), loaded.scripted_edits.end(), [&](const ScriptedEdit& e) { return e.name == load.animate; });
    if (edit == loaded.scripted_edits.end()) return camera_at(scene, handle, seconds, load.animation);
    scene.apply(edit->apply(scene, seconds));
    const Camera camera = scene.get(handle);
    scene.apply(edit->apply(scene, load.time));
    scene.begin_frame();  // there and back: nothing has moved
    return camera;
}

bool same_place(const CameraView& a, const CameraView& b) {
    return a.position == b.position && a.right == b.right && a.up == b.up && a.forward == b.forward && a.yfov == b.yfov && a.half_extents == b.half_extents;
}

// Invisible from behind: docs/conventions.md, Culling.
bool has_no_back(const Material& material) { return !material.double_sided && (material.unlit || !(material.transmission > 0.0f)); }

// Distance along the ray to a triangle, in units of the direction's length. Möller and Trumbore 1997, in double.
double distance_to(const glm::dvec3& origin, const glm::dvec3& direction, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, bool front_only) {
    const glm::dvec3 ab = b - a, ac = c - a, p = glm::cross(direction, ac);
    const double facing = glm::dot(ab, p);  // > 0: seen from the front
    if (facing == 0.0 || (front_only && facing < 0.0)) return kNothing;
    const glm::dvec3 from_a = origin - a, q = glm::cross(from_a, ab);
    const double u = glm::dot(from_a, p) / facing, v = glm::dot(direction, q) / facing, t = glm::dot(ac, q) / facing;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 ? t : kNothing;
}

bool may_meet(const glm::dvec3& origin, const glm::dvec3& direction, const Bounds& box) {
    double near = 0.0, far = kNothing;
    for (int axis = 0; axis < 3; ++axis) {
        if (direction[axis] == 0.0) {
            if (origin[axis] < box.min[axis] || origin[axis] > box.max[axis]) return false;
            continue;
        }
        const double a = (box.min[axis] - origin[axis]) / direction[axis], b = (box.max[axis] - origin[axis]) / direction[axis];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
    }
    return near <= far * (1.0 + 1e-9);
}

}  // namespace

float find_focus(const Scene& scene, const CameraView& view, bool culling) {
    double nearest = kNothing;
    for (const auto& [handle, instance] : scene.instances()) {
        if (!can_be_seen(instance.place)) continue;
        const Mesh& mesh = scene.get(instance.drawn_mesh());
        const glm::dmat4 object_from_world = glm::inverse(glm::dmat4(instance.place.world_from_object));
        const glm::dvec3 origin(object_from_world * glm::dvec4(view.position, 1.0)), direction(object_from_world * glm::dvec4(view.forward, 0.0));
        if (!may_meet(origin, direction, mesh.bounds)) continue;
        Primitive storage;
        for (size_t g = 0; g < mesh.primitives.size(); ++g) {
            const Primitive& primitive = drawn_shape(scene, mesh, g, storage);
            const bool front_only = culling && (!primitive.material || has_no_back(scene.get(primitive.material)));
            const auto corner = [&](uint32_t index) { return glm::dvec3(primitive.positions[index]); };
            for (const glm::uvec3& t : primitive.triangles)
                nearest = std::min(nearest, distance_to(origin, direction, corner(t.x), corner(t.y), corner(t.z), front_only));
        }
    }
    if (nearest == kNothing)
        throw Error(ErrorCode::Usage, "nothing lies in the middle of the picture to focus on", "--aperture-radius", "add --focus-distance METRES");
    return static_cast<float>(nearest);
}

MovingCamera set_up_camera(LoadedScene& loaded, const RenderOptions& options, bool culling, std::string& description) {
    const double opens = options.load.time, closes = opens + options.shutter_seconds;
    const float aspect = static_cast<float>(options.size.width) / static_cast<float>(options.size.height);
    MovingCamera camera;
    std::optional<CameraView> later;
    if (!options.camera_path.empty()) {
        const CameraPath path = read_camera_path(options.camera_path);
        camera.opens = path.view_at(opens);
        later = path.view_at(closes);
        description = "(--camera-path)";
        apply_fov(camera.opens, options);
    } else {
        camera.opens = choose_camera(loaded.scene, options, description);
        if (const auto handle = scene_camera(loaded.scene, options); handle && closes > opens)
            later = view_of(moved_camera(loaded, *handle, options.load, closes), aspect);
    }
    if (options.aperture_radius > 0) {
        camera.opens.lens_radius = static_cast<float>(options.aperture_radius);
        camera.opens.focus_distance = options.focus_distance ? static_cast<float>(*options.focus_distance) : find_focus(loaded.scene, camera.opens, culling);
        if (!options.focus_distance) log(LogLevel::Info, "the lens is focused on what lies in the middle of the picture, {:.4g} m away", camera.opens.focus_distance);
    }
    if (closes == opens) return camera;
    if (later) apply_fov(*later, options);
    if (later && !same_place(camera.opens, *later)) camera.closes = later;
    return camera;
}

PlayedCamera::PlayedCamera(const Scene& scene, const RenderOptions& options, const CameraView& first)
    : options_(options), first_(first), handle_(scene_camera(scene, options)) {
    if (!options.camera_path.empty()) path_ = read_camera_path(options.camera_path);
}

CameraView PlayedCamera::at(const Scene& scene, double seconds) const {
    if (!path_ && !handle_) return first_;
    const float aspect = static_cast<float>(options_.size.width) / static_cast<float>(options_.size.height);
    CameraView view = path_ ? path_->view_at(seconds) : view_of(scene.get(*handle_), aspect);
    apply_fov(view, options_);
    view.lens_radius = first_.lens_radius;
    view.focus_distance = first_.focus_distance;
    return view;
}

}  // namespace parhelion
