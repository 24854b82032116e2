// How much noise reservoirs take away: frames of a sequence in which the camera moves by eight pixels a frame while something in the scene moves or
// is switched, with and without reuse, before and after reconstruction.
#include <array>
#include <limits>

#include "scene/load.h"
#include "truth/sequence.h"

namespace parhelion::testing::reuse_noise_test {
namespace {

constexpr std::array kLooks{1u, 8u, 32u, 36u, 40u, 44u};  // frames; those from kSettled on have a history
constexpr uint32_t kSettled = 32;

// Of luminance, relative to the reference's, a pixel at a time.
double relative_error(const image::ImageF& picture, const image::ImageF& reference) {
    double sum = 0, mean = mean_luminance(reference);
    for (size_t p = 0; p < picture.pixel_count(); ++p) {
        const double r = luminance_of(reference, p), d = luminance_of(picture, p) - r;
        sum += d * d / (r * r + 0.01 * mean * mean);
    }
    return sum / static_cast<double>(picture.pixel_count());
}

// Of one run: the error of the frames before a history has settled, and means over those after.
struct Measured {
    std::map<uint32_t, double> error;
    double flip_sum = 0, error_sum = 0;
    uint32_t settled = 0;

    void add(uint32_t frame, const image::ImageF& picture, const image::ImageF& reference) {
        error[frame] = relative_error(picture, reference);
        if (frame < kSettled) return;
        flip_sum += flip_of(picture, reference), error_sum += error[frame], ++settled;
    }
    double flip() const { return flip_sum / settled; }
    double settled_error() const { return error_sum / settled; }
};

class RealtimeReuseNoise : public TruthTest, public ::testing::WithParamInterface<Sequence> {};

TEST_P(RealtimeReuseNoise, reuse_makes_frames_better_before_and_after_reconstruction) {
    const TruthScene& scene = scene_of(GetParam());
    if (const std::string why = why_skipped(scene); !why.empty()) return report_skip("reuse-noise", scene.name, why);
    TruthStage on = set_up(load_scene(scene.source), truth_stage(scene).camera);
    RealtimeOptions none = truth_options(on, true);
    none.reuse = RealtimeReuse::None;
    none.reuse_options = {};
    RealtimeOptions full = none, split = none;
    full.reuse = split.reuse = RealtimeReuse::Full;
    split.reuse_options.sets = ReservoirSets::Split;
    std::vector<SequenceRun> runs{{"none", none}, {"full", full}, {"split", split}};
    for (size_t i = 0; i < 3; ++i) {
        SequenceRun& run = runs.emplace_back(runs[i]);
        run.name += ", reconstructed";
        run.options.reconstruction = ReconstructionOptions();
    }
    std::map<std::string, Measured> of;
    play(on, scene, GetParam(), picture_size(), pixels_per_frame(), truth_effort() * by_size(scene.noisy ? 4096u : 2048u, 256u), kLooks, runs, [&](const SequenceFrame& frame) {
        for (const SequenceRun& run : runs) of[run.name].add(frame.index, run.picture, frame.reference);
    });
    std::string note;
    for (const auto& [name, measured] : of) {
        note += fmt::format("{}: FLIP {:.4f}, relative MSE", name, measured.flip());
        for (const auto& [frame, error] : measured.error)
            if (frame <= kSettled) note += fmt::format(" {:.4f}", error);
        note += "; ";
    }
    const auto tell = [&](const char* what, double value, double most) {
        report({.test = "reuse-noise", .scene = scene.name, .what = what, .value = value, .low = value, .high = value, .least = 0, .most = most, .runs = 1, .frames = static_cast<uint32_t>(kLooks.size()), .note = note});
    };
    tell("FLIP over none's, reconstructed", of["full, reconstructed"].flip() / of["none, reconstructed"].flip(), by_size(std::string_view(scene.name) == "many_lights" ? 0.85 : 1.0, 1.2));
    tell("error over none's, one frame", of["full"].settled_error() / of["none"].settled_error(), by_size(1.0, 1.2));
    tell("split: FLIP over unified's, reconstructed", of["split, reconstructed"].flip() / of["full, reconstructed"].flip(), std::numeric_limits<double>::infinity());
}
INSTANTIATE_TEST_SUITE_P(Of, RealtimeReuseNoise, ::testing::ValuesIn(sequences().begin(), sequences().end()), [](const auto& entry) { return std::string(entry.param.scene); });

}  // namespace
}  // namespace parhelion::testing::reuse_noise_test
