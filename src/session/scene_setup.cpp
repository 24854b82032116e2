#include "session/scene_setup.h"

#include <cmath>
#include <numbers>

#include "base/error.h"
#include "base/log.h"
#include "scene/load.h"

namespace parhelion {

bool has_light(const Scene& scene) {
    if (!scene.lights().empty() || !scene.environment().black()) return true;
    for (const auto& [handle, material] : scene.materials())
        if (material.emission != glm::vec3(0.0f)) return true;
    return false;
}

Environment overcast_sky() {
    constexpr float kZenith = 4000.0f;  // nits
    // A fifth of the sky's horizontal illuminance 7/9 pi Lz comes back from the ground.
    constexpr float kGround = 0.2f * 7.0f / 9.0f * kZenith;
    Environment sky;
    sky.name = "overcast sky";
    sky.width = 2;
    sky.height = 64;
    sky.scale = glm::vec3(1.0f);
    for (uint32_t row = 0; row < sky.height; ++row) {
        const float polar = (static_cast<float>(row) + 0.5f) / static_cast<float>(sky.height) * std::numbers::pi_v<float>;
        const float up = std::cos(polar);
        const float nits = up > 0 ? kZenith * (1.0f + 2.0f * up) / 3.0f : kGround;
        sky.radiance.insert(sky.radiance.end(), sky.width, glm::vec3(nits));
    }
    return sky;
}

void add_light(Scene& scene, const RenderOptions& options) {
    SceneEdit edit;
    Environment environment = options.environment.empty() ? scene.environment() : load_environment(options.environment);
    if (environment.black() && options.default_light && !has_light(scene)) {
        log(LogLevel::Info, "the scene has no light: an overcast sky is added (--no-default-light keeps it black, --env F.hdr lights it)");
        environment = overcast_sky();
    }
    environment.scale *= static_cast<float>(options.env_intensity);
    environment.rotation += static_cast<float>(options.env_rotation_degrees * std::numbers::pi / 180.0);
    edit.set_environment(std::move(environment));
    scene.apply(std::move(edit));
}

CameraView choose_camera(const Scene& scene, const RenderOptions& options, std::string& description) {
    const float aspect = static_cast<float>(options.size.width) / static_cast<float>(options.size.height);
    const auto vec = [](const std::array<double, 3>& v) { return glm::vec3(v[0], v[1], v[2]); };
    const Bounds bounds = scene.bounds();
    CameraView view;
    if (options.look_from) {
        const glm::vec3 target = options.look_at ? vec(*options.look_at) : bounds.empty() ? glm::vec3(0.0f) : bounds.center();
        view = look_at(vec(*options.look_from), target, 0.8f);
        description = "(--look-from)";
    } else if (!options.camera.empty() || !scene.cameras().empty()) {
        const Handle<Camera> handle = options.camera.empty() ? (*scene.cameras().begin()).handle : find_camera(scene, options.camera);
        view = view_of(scene.get(handle), aspect);
        description = scene.get(handle).name;
    } else {
        view = framing_view(bounds, aspect);
        description = "(frames the scene)";
    }
    if (options.fov_degrees) {
        if (view.orthographic)
            throw Error(ErrorCode::Usage, "this camera is orthographic", "--fov", "leave it out or choose another camera");
        view.yfov = static_cast<float>(*options.fov_degrees * std::numbers::pi / 180.0);
    }
    return view;
}

shared::Camera shader_camera(const CameraView& view, float aspect) {
    const glm::vec2 half = view.image_half_extents(aspect);
    return {.position_ws = view.position,
            .right_ws = view.right * half.x,
            .up_ws = view.up * half.y,
            .forward_ws = view.forward,
            .orthographic = view.orthographic};
}

gpu::TraceWay choose_trace_way(const gpu::DeviceCaps& caps, TraceChoice choice) {
    if (choice == TraceChoice::Auto)
        return caps.type != gpu::DeviceType::Cpu && caps.ray_query ? gpu::TraceWay::Query : gpu::TraceWay::Compute;
    const gpu::TraceWay way = choice == TraceChoice::Pipeline ? gpu::TraceWay::Pipeline
                              : choice == TraceChoice::Query  ? gpu::TraceWay::Query
                                                              : gpu::TraceWay::Compute;
    if (!caps.supports(way))
        throw Error(ErrorCode::MissingFeature, fmt::format("{} cannot trace by {}", escape_name(caps.name), trace_way_name(way)), "--trace",
                    "use --trace compute: it needs no ray tracing extension");
    return way;
}

}  // namespace parhelion
