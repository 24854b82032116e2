#pragma once
// Sequences in which the camera moves while something in the scene moves or is switched, drawn in step by several runs of the realtime renderer, each
// with its own history, beside the reference of each frame that is looked at.
#include "truth/truth.h"

namespace parhelion::testing {

struct Sequence {
    const char* scene;
    std::vector<const char*> scripts;  // played together
};

// A run of a sequence. What it shows lies in `picture` after a frame in which it was looked at.
struct SequenceRun {
    std::string name;
    RealtimeOptions options;
    std::vector<std::string> aovs = {};
    image::ImageF picture = {};
};

struct SequenceFrame {
    uint32_t index = 0;
    image::ImageF reference = {};  // of the same moment, pixel centres weighed by a box
};

// Draws frames 0 to the last of `looks`, and calls `look` after each of those. The camera goes to one side for 16 frames and back for 16, by
// `pixels` a frame of what stands in the middle of the scene; 0: it stands still. `samples`: of the references; 0: there is none.
// PARHELION_TRUTH_REFERENCES names a folder in which references are kept and taken from (to be emptied when the tracer or a scene changes);
// PARHELION_TRUTH_PICTURES one for the pictures (EXR) of every look.
void play(TruthStage& on, const TruthScene& scene, const Sequence& sequence, uint32_t size, float pixels, uint32_t samples, std::span<const uint32_t> looks, std::vector<SequenceRun>& runs,
          const std::function<void(const SequenceFrame&)>& look);

// Two frames, one after the other.
struct FramePair {
    const image::ImageF &before, &now;
};
// How much a picture changes where it should not: mean difference, as displayed (0 to 1), between frame t and frame t - 1 moved to where its
// surfaces are now, less the reference's, pixel by pixel, over those that show what was visible then. `guides` have the layers depth and motion.
double flicker(FramePair pictures, FramePair references, FramePair guides, float exposure);

}  // namespace parhelion::testing
