#pragma once
// Sequences in which the camera moves while something in the scene moves or is switched, drawn in step by several runs of the realtime renderer, each
// with its own history, beside the reference of each frame that is looked at.
#include <optional>
#include <span>

#include "truth/truth.h"

namespace parhelion::testing {

struct Sequence {
    const char* scene;
    std::vector<const char*> scripts;  // played together
};

// A sequence of each scene whose frames are judged.
std::span<const Sequence> sequences();
const TruthScene& scene_of(const Sequence& sequence);
inline uint32_t picture_size() { return by_size(512u, 64u); }       // pixels a side of their pictures, and of those of other tests of reconstruction
inline float pixels_per_frame() { return by_size(8.0f, 1.0f); }     // by which the camera moves
// Mean over the pixels.
double flip_of(const image::ImageF& picture, const image::ImageF& reference);

// A run of a sequence. What it shows lies in `picture` after a frame in which it was looked at.
struct SequenceRun {
    std::string name;
    RealtimeOptions options;
    std::vector<std::string> aovs = {};
    std::optional<uint32_t> cut_at = {};  // before this frame it forgets what its reconstruction has kept
    uint32_t seed = 1;
    image::ImageF picture = {};
    double rays_per_pixel = 0;  // of that frame, without the first one of each path
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

// The same, given as functions.
struct SequenceScript {
    std::string name;                                                     // of its pictures
    std::function<ChangeSet(Scene& scene, uint32_t frame)> change = {};   // what happens in the scene before a frame; none: nothing
    std::function<CameraView(uint32_t frame)> camera = {};                // none: the stage's
    std::vector<uint32_t> looks, references = {};                         // ascending; those of the looks that have a reference
    uint32_t samples = 0;                                                 // of each reference
};
void play(TruthStage& on, const SequenceScript& script, uint32_t size, std::vector<SequenceRun>& runs, const std::function<void(const SequenceFrame&)>& look);
// Where the camera of play() above is in a frame.
CameraView strafing_camera(const TruthStage& on, uint32_t size, float pixels, uint32_t frame);

// As a display shows it: luminance, 0 to 1.
std::vector<float> displayed(const image::ImageF& picture, float exposure);
// A layer of a run that asked for it, pixel by pixel.
std::vector<float> layer(const image::ImageF& picture, std::string_view name);

// Two frames, one after the other.
struct FramePair {
    const image::ImageF &before, &now;
};
// How much a picture changes where it should not: mean difference, as displayed (0 to 1), between frame t and frame t - 1 moved to where its
// surfaces are now, less the reference's, pixel by pixel, over those that show what was visible then. `guides` have the layers depth and motion.
double flicker(FramePair pictures, FramePair references, FramePair guides, float exposure);

// For how many frames what a pixel shows has been in sight, this one included; of what was there from the start kSeenForLong and more; of the sky 0.
struct InSight {
    uint32_t frames = 0;
    bool over_edge = false;  // it came in over the picture's edge, not from behind something
};
constexpr uint32_t kSeenForLong = 1000;
// `before`: of the last frame; empty: all of that was there from the start. `guides` as above. Only the camera moves, to a side.
std::vector<InSight> in_sight(const std::vector<InSight>& before, FramePair guides);

}  // namespace parhelion::testing
