#pragma once
// What the options and settings of a render mean for its view and for its scene on the device.
#include "renderers/view.h"
#include "session/camera_setup.h"
#include "session/render_settings.h"
#include "session/trace_choice.h"

namespace parhelion {

ViewDesc describe_view(const RenderOptions& options, const RenderSettings& settings, const MovingCamera& camera);
// `draws_pixels`: may_draw_pixels(), if the realtime renderer may be the one that draws.
SceneGpuOptions describe_scene_gpu(const RenderSettings& settings, const TraceDecision& trace, bool draws_pixels);

}  // namespace parhelion
