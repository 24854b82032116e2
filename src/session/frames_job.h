#pragma once
// A render job that plays frames on the scene's clock: scripted edits, animations and the camera move from one to the next.
#include "session/job.h"

namespace parhelion {

// Draws the frames that options.play names and writes a file for each ("a.####.exr"), or the last one, or their mean. Frame i stands at
// --time + i / fps. The realtime renderer always begins with frame 0, since a frame leans on those before it: a part of a sequence is the
// very frames of the whole. A path tracer's frames are drawn with all of options.samples each, other ones in every frame; a part of
// them begins where it says. The exposure is that of frame 0. Throws as run_render_job does; interrupted, what is finished is written.
RenderReport run_frames_job(const RenderOptions& options, gpu::DevicePtr device = nullptr);

}  // namespace parhelion
