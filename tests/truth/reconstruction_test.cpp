// How good reconstructed frames are: FLIP against the reference of that very frame, of a sequence in which the camera moves by eight pixels a
// frame while something in the scene moves or is switched, beside one raw frame and plain reprojected accumulation.
#include <algorithm>
#include <array>
#include <cmath>

#include "image/flip.h"
#include "scene/load.h"
#include "session/film_state.h"
#include "session/scene_setup.h"
#include "truth/truth.h"

namespace parhelion::testing {
namespace {

constexpr double kFramesPerSecond = 30.0;
constexpr std::array kLooks{20u, 28u, 36u, 44u};  // frames that are judged, of 16 to 47

uint32_t picture_size() { return by_size(512u, 64u); }
float pixels_per_frame() { return by_size(8.0f, 1.0f); }

struct Sequence {
    const char* scene;
    std::vector<const char*> scripts;  // played together
};
const Sequence kSequences[] = {{"cornell", {"torch"}}, {"spheres", {"leave"}}, {"diorama", {"robot", "lamp"}}, {"reflections", {"roll"}}, {"many_lights", {"blink"}}};

// The mean over the last frames, a tenth of it new, where reprojection finds the surface: nothing else.
ReconstructionOptions plain_control() {
    return {.history = 10, .fast_history = 10, .steps = 0, .firefly = 0.0f, .antilag = 0.0f, .clamp_width = 0.0f, .virtual_motion = false, .antialias = false};
}

// To one side for 16 frames and back for 16, past what stands in the middle.
CameraView camera_at(const CameraView& start, float distance, uint32_t frame) {
    const uint32_t phase = (frame + 8) % 32;
    const float frames = static_cast<float>(phase < 16 ? phase : 32 - phase) - 8.0f;
    CameraView moved = start;
    moved.position += start.right * (frames * pixels_per_frame() * 2.0f * distance * std::tan(0.5f * start.yfov) / static_cast<float>(picture_size()));
    return moved;
}

// A run with its own history, in step with others.
struct Played {
    Played(TruthStage& on, const ViewDesc& desc, const RealtimeOptions& options) : view(on.stage->frame.device(), desc), realtime(on.stage->frame.device(), view, options) {}
    View view;
    Realtime realtime;

    image::ImageF next(TruthStage& on, const CameraView& camera) {
        view.set_camera(shader_camera(camera, 1.0f));
        realtime.record(on.stage->frame, on.stage->scene_gpu, on.way, view, true);
        on.stage->frame.run();
        return image::resolve_film(make_film_sums(view.read_film(on.stage->frame), {picture_size(), picture_size()}, {0, 1}, {}));
    }
};

image::ImageF reference_at(TruthStage& on, const CameraView& camera, uint32_t samples) {
    const uint32_t slice = std::clamp((1u << 22) / (picture_size() * picture_size()), 1u, 64u);
    ViewDesc desc = truth_view(on, picture_size(), 5, false);
    desc.filter = PixelFilter::Box;
    return on.stage->picture({.way = on.way, .view = desc, .camera = camera, .sample_count = samples, .slice_samples = slice});
}

double flip_of(const image::ImageF& picture, const image::ImageF& truth) {
    return image::flip_hdr(image::rgb_planes(truth), image::rgb_planes(picture), picture.width, picture.height).mean;
}

class RealtimeReconstruction : public TruthTest, public ::testing::WithParamInterface<Sequence> {};

TEST_P(RealtimeReconstruction, frames_of_a_moving_sequence_are_near_the_reference) {
    const auto all = truth_scenes();
    const auto scene = std::find_if(all.begin(), all.end(), [&](const TruthScene& s) { return std::string_view(s.name) == GetParam().scene; });
    ASSERT_NE(scene, all.end());
    if (const std::string why = why_skipped(*scene); !why.empty()) return report_skip("reconstruct", scene->name, why);
    TruthStage on = set_up(load_scene(scene->source), truth_stage(*scene).camera);
    const float distance = glm::length(on.stage->scene.bounds().center() - on.camera.position);
    const ViewDesc desc = truth_view(on, picture_size(), 1, false);
    RealtimeOptions raw = truth_options(on, true), plain = raw, builtin = raw, upscaled = raw;
    plain.reconstruction = plain_control();
    builtin.reconstruction = upscaled.reconstruction = ReconstructionOptions();
    upscaled.upscale = 2.0;
    std::array runs{Played(on, desc, raw), Played(on, desc, plain), Played(on, desc, builtin), Played(on, desc, upscaled)};
    std::array<double, 4> flip{};
    for (uint32_t frame = 0; frame <= kLooks.back(); ++frame) {
        Scene& moving = on.stage->scene;
        ChangeSet changes = moving.begin_frame();
        for (const ScriptedEdit& scripted : on.scripted_edits)
            for (const char* name : GetParam().scripts)
                if (scripted.name == name) changes.append(moving.apply(scripted.apply(moving, frame / kFramesPerSecond)));
        on.stage->scene_gpu.sync(moving, changes);
        on.stage->scene_gpu.finish(on.stage->frame);
        const CameraView camera = camera_at(on.camera, distance, frame);
        const bool looks = std::find(kLooks.begin(), kLooks.end(), frame) != kLooks.end();
        const image::ImageF truth = looks ? reference_at(on, camera, truth_effort() * by_size(scene->noisy ? 4096u : 2048u, 256u)) : image::ImageF();
        for (size_t k = 0; k < runs.size(); ++k)
            if (const image::ImageF picture = runs[k].next(on, camera); looks) flip[k] += flip_of(picture, truth) / kLooks.size();
    }
    const auto tell = [&](const char* what, double value, double most) {
        report({.test = "reconstruct", .scene = scene->name, .what = what, .value = value, .low = value, .high = value, .least = 0, .most = most, .runs = 1, .frames = static_cast<uint32_t>(kLooks.size()),
                .note = fmt::format("FLIP of a raw frame {:.3f}, of plain accumulation {:.3f}, of builtin {:.3f}", flip[0], flip[1], flip[2])});
    };
    // Pictures of a few pixels have an edge in each, which no neighbour helps.
    tell("FLIP over a raw frame's", flip[2] / flip[0], by_size(0.35, 0.8));
    tell("FLIP over plain's", flip[2] / flip[1], by_size(0.8, 1.1));
    tell("FLIP of twice the size over its own", flip[3] / flip[2], by_size(1.3, 1.8));
}
INSTANTIATE_TEST_SUITE_P(Of, RealtimeReconstruction, ::testing::ValuesIn(kSequences), [](const auto& entry) { return std::string(entry.param.scene); });

}  // namespace
}  // namespace parhelion::testing
