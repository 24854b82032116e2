#include "session/scene_setup.h"

#include <cmath>
#include <numbers>

#include <glm/gtc/matrix_transform.hpp>

#include "base/error.h"
#include "base/log.h"
#include "scene/load.h"

namespace parhelion {

namespace {

constexpr std::string_view kClearSky = "sky";  // --env

}  // namespace

bool has_light(const Scene& scene) {
    if (!scene.lights().empty() || !scene.environment().black()) return true;
    bool all_unlit = !scene.materials().empty();
    for (const auto& [handle, material] : scene.materials()) {
        if (material.emission != glm::vec3(0.0f)) return true;
        all_unlit = all_unlit && material.unlit;
    }
    return all_unlit;
}

void add_light(Scene& scene, const RenderOptions& options, const SkyOptions& sky_options) {
    SceneEdit edit;
    const bool asked = options.environment == kClearSky;
    Environment environment = options.environment.empty() || asked ? scene.environment() : load_environment(options.environment);
    const bool needed = environment.black() && options.default_light && !has_light(scene);
    const float factor = static_cast<float>(options.env_intensity), turn = static_cast<float>(options.env_rotation_degrees * std::numbers::pi / 180.0);
    if (asked || needed) {
        if (!asked)
            log(LogLevel::Info,
                "the scene has no light: a clear sky with its sun is added (--no-default-light keeps it black, --env F.hdr lights it)");
        Sky sky = make_clear_sky(sky_options);
        environment = std::move(sky.environment);
        sky.sun.intensity *= factor;
        // The environment turns counter-clockwise seen from above, and the sun with it.
        sky.sun.place.node_from_object = glm::rotate(glm::mat4(1.0f), turn, glm::vec3(0, 1, 0)) * sky.sun.place.node_from_object;
        if (sky.sun.intensity > 0.0f) edit.add(std::move(sky.sun));
    }
    environment.scale *= factor;
    environment.rotation += turn;
    edit.set_environment(std::move(environment));
    scene.apply(std::move(edit));
}

std::optional<Handle<Camera>> scene_camera(const Scene& scene, const RenderOptions& options) {
    if (options.look_from || !options.camera_path.empty()) return std::nullopt;
    if (!options.camera.empty()) return find_camera(scene, options.camera);
    return scene.cameras().empty() ? std::nullopt : std::optional((*scene.cameras().begin()).handle);
}

void apply_fov(CameraView& view, const RenderOptions& options) {
    if (!options.fov_degrees) return;
    if (view.orthographic)
        throw Error(ErrorCode::Usage, "this camera is orthographic", "--fov", "leave it out or choose another camera");
    view.yfov = static_cast<float>(*options.fov_degrees * std::numbers::pi / 180.0);
}

CameraView choose_camera(const Scene& scene, const RenderOptions& options, std::string& description) {
    const float aspect = static_cast<float>(options.size.width) / static_cast<float>(options.size.height);
    const auto vec = [](const std::array<double, 3>& v) { return glm::vec3(v[0], v[1], v[2]); };
    const Bounds bounds = scene.bounds();
    CameraView view;
    if (options.look_from) {
        const glm::vec3 target = options.look_at ? vec(*options.look_at) : bounds.empty() ? glm::vec3(0.0f) : bounds.center();
        view = look_at(vec(*options.look_from), target, 0.8f);
        if (options.ortho_height) {
            const auto half = static_cast<float>(*options.ortho_height / 2);
            view.orthographic = true;
            view.half_extents = {half * aspect, half};
        }
        description = "(--look-from)";
    } else if (const auto handle = scene_camera(scene, options)) {
        view = view_of(scene.get(*handle), aspect);
        description = scene.get(*handle).name;
    } else {
        view = framing_view(bounds, aspect);
        description = "(frames the scene)";
    }
    apply_fov(view, options);
    return view;
}

shared::Camera shader_camera(const CameraView& view, float aspect) {
    const glm::vec2 half = view.image_half_extents(aspect);
    return {.position_ws = view.position,
            .right_ws = view.right * half.x,
            .up_ws = view.up * half.y,
            .forward_ws = view.forward,
            .orthographic = view.orthographic,
            .lens_radius = view.lens_radius,
            .focus_distance = view.focus_distance};
}

gpu::TraceWay choose_trace_way(const gpu::DeviceCaps& caps, TraceChoice choice) {
    if (choice == TraceChoice::Auto) return gpu::device_class(caps).way;
    const gpu::TraceWay way = choice == TraceChoice::Pipeline ? gpu::TraceWay::Pipeline
                              : choice == TraceChoice::Query  ? gpu::TraceWay::Query
                                                              : gpu::TraceWay::Compute;
    if (!caps.supports(way))
        throw Error(ErrorCode::MissingFeature, fmt::format("{} cannot trace by {}", escape_name(caps.name), trace_way_name(way)), "--trace",
                    "use --trace compute: it needs no ray tracing extension");
    return way;
}

}  // namespace parhelion
