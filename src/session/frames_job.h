#pragma once
// A render job that plays frames on the scene's clock: scripted edits, animations and the camera move from one to the next.
#include "session/job.h"

namespace parhelion {

// Draws the frames that options.play names and writes a file for each ("a.####.exr"), or the last one, or their mean. Frame i stands at
// --time + i / fps. The realtime renderer begins with frame 0, since a frame leans on those before it (fewer with FramePlay::preroll): a part
// of a sequence is the very frames of the whole. A path tracer's frames are drawn with all of options.samples each, other ones in every frame; a part of
// them begins where it says. The exposure is that of frame 0. With options.resume frames of a sequence that are there already
// (session/frame_hash.h) are kept: a path tracer does not draw them, the realtime renderer only where a missing one leans on them.
// Throws as run_render_job does; interrupted, what is finished is written.
RenderReport run_frames_job(const RenderOptions& options, gpu::DevicePtr device = nullptr);

}  // namespace parhelion
