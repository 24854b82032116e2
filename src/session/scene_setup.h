#pragma once
// From options to a scene with light and a camera.
#include <optional>
#include <string>

#include "gpu/device_class.h"
#include "renderers/view.h"
#include "scene/camera.h"
#include "scene/sky.h"
#include "session/render_options.h"

namespace parhelion {

// Applies --env and its factors and, in a scene without any light, a clear sky with its sun (and says so) unless the options
// forbid it.
void add_light(Scene& scene, const RenderOptions& options, const SkyOptions& sky);
bool has_light(const Scene& scene);  // or is shown unlit (KHR_materials_unlit) throughout, which needs none

// The camera of the scene that the options choose, if they choose one. Throws a usage Error if the scene does not have it.
std::optional<Handle<Camera>> scene_camera(const Scene& scene, const RenderOptions& options);
// Gives the view the field of view of --fov, if there is one. Throws a usage Error where the camera has none.
void apply_fov(CameraView& view, const RenderOptions& options);
// The options' camera, else the scene's, else one that frames the scene. `description` says which, for the summary.
CameraView choose_camera(const Scene& scene, const RenderOptions& options, std::string& description);
shared::Camera shader_camera(const CameraView& view, float aspect);

// `auto` is the table of device classes (gpu/device_class.h); decide_trace() also knows what was measured.
// Throws MissingFeature if the device lacks a way that was asked for.
gpu::TraceWay choose_trace_way(const gpu::DeviceCaps& caps, TraceChoice choice);

// A hash of everything in the scene that reaches the picture: equal scenes, equal hashes, wherever their files lie.
uint64_t hash_scene(const Scene& scene);
// A hash of what a scene of a file does as time goes on from where it stands: hierarchy, animations, skins, cameras.
uint64_t hash_motion(const Scene& scene);

}  // namespace parhelion
