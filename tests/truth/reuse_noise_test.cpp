// How much noise reservoirs take away: frames of a sequence in which the camera moves by eight pixels a frame while something in the scene moves or
// is switched, with and without reuse and by plain path tracing, before and after reconstruction.
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

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
    double flip_sum = 0, error_sum = 0, ray_sum = 0;
    uint32_t settled = 0;

    void add(uint32_t frame, const SequenceRun& run, const image::ImageF& reference) {
        error[frame] = relative_error(run.picture, reference);
        if (frame < kSettled) return;
        flip_sum += flip_of(run.picture, reference), error_sum += error[frame], ray_sum += run.rays_per_pixel, ++settled;
    }
    double flip() const { return flip_sum / settled; }
    double settled_error() const { return error_sum / settled; }
    double rays() const { return ray_sum / settled; }
    // Of as many samples as take `rays` a pixel, where samples are independent.
    double error_with(double rays_per_pixel) const { return settled_error() * rays() / rays_per_pixel; }
};

// How far a value lies off another one's in runs of the same seeds: the mean of the quotients, and its standard error.
struct Quotient {
    double mean = 0, error = 0;
};
Quotient quotient(std::span<const double> values, std::span<const double> others) {
    double sum = 0, squares = 0;
    const auto count = static_cast<double>(values.size());
    for (size_t i = 0; i < values.size(); ++i) sum += values[i] / others[i], squares += values[i] * values[i] / (others[i] * others[i]);
    return {sum / count, std::sqrt(std::max(0.0, squares / count - sum * sum / (count * count)) / std::max(1.0, count - 1))};
}

class RealtimeReuseNoise : public TruthTest, public ::testing::WithParamInterface<Sequence> {};

TEST_P(RealtimeReuseNoise, reuse_makes_frames_better_before_and_after_reconstruction) {
    const TruthScene& scene = scene_of(GetParam());
    if (const std::string why = why_skipped(scene); !why.empty()) return report_skip("reuse-noise", scene.name, why);
    TruthStage on = set_up(load_scene(scene.source), truth_stage(scene).camera);
    RealtimeOptions none = truth_options(on, true);
    none.reuse = RealtimeReuse::None;
    none.reuse_options = {};
    RealtimeOptions full = none, split = none, plain = none;
    full.reuse = split.reuse = RealtimeReuse::Full;
    split.reuse_options.sets = ReservoirSets::Split;
    plain.cache = plain.tiles = false;  // the reference's paths, one a pixel
    const std::array<SequenceRun, 4> kinds{{{"none", none}, {"full", full}, {"split", split}, {"path traced", plain}}};
    const uint32_t seeds = by_size(4u, 1u);
    std::vector<SequenceRun> runs{kinds.begin(), kinds.end()};
    for (SequenceRun run : kinds) {
        run.name += ", reconstructed";
        run.options.reconstruction = ReconstructionOptions();
        for (run.seed = 1; run.seed <= seeds; ++run.seed) runs.push_back(run);
    }
    std::map<std::string, std::vector<Measured>> of;
    for (const SequenceRun& run : runs) of[run.name].resize(run.seed);
    play(on, scene, GetParam(), picture_size(), pixels_per_frame(), truth_effort() * by_size(scene.noisy ? 4096u : 2048u, 256u), kLooks, runs, [&](const SequenceFrame& frame) {
        for (const SequenceRun& run : runs) of[run.name][run.seed - 1].add(frame.index, run, frame.reference);
    });
    const auto flips = [&](const std::string& name) {
        std::vector<double> values;
        for (const Measured& measured : of[name]) values.push_back(measured.flip());
        return values;
    };
    std::string note;
    for (const auto& [name, measured] : of) {
        const std::vector<double> flip = flips(name);
        note += fmt::format("{}: {:.2f} rays, FLIP {:.4f}, relative MSE", name, measured.front().rays(), std::accumulate(flip.begin(), flip.end(), 0.0) / static_cast<double>(flip.size()));
        for (const auto& [frame, error] : measured.front().error)
            if (frame <= kSettled) note += fmt::format(" {:.4f}", error);
        note += "; ";
    }
    const auto tell = [&](const char* what, Quotient q, double most, uint32_t run_count) {
        report({.test = "reuse-noise", .scene = scene.name, .what = what, .value = q.mean, .low = q.mean - q.error, .high = q.mean + q.error, .least = 0, .most = most, .runs = run_count, .frames = static_cast<uint32_t>(kLooks.size()), .note = note});
    };
    tell("FLIP over none's, reconstructed", quotient(flips("full, reconstructed"), flips("none, reconstructed")), by_size(std::string_view(scene.name) == "many_lights" ? 0.85 : 1.0, 1.2), seeds);
    tell("error over none's, one frame", {of["full"].front().settled_error() / of["none"].front().settled_error()}, by_size(1.0, 1.2), 1);
    tell("path tracing's error at equal rays, over full's", {of["path traced"].front().error_with(of["full"].front().rays()) / of["full"].front().settled_error()}, std::numeric_limits<double>::infinity(), 1);
    tell("path traced: FLIP over full's, reconstructed", quotient(flips("path traced, reconstructed"), flips("full, reconstructed")), std::numeric_limits<double>::infinity(), seeds);
    tell("split: FLIP over unified's, reconstructed", quotient(flips("split, reconstructed"), flips("full, reconstructed")), std::numeric_limits<double>::infinity(), seeds);
}
INSTANTIATE_TEST_SUITE_P(Of, RealtimeReuseNoise, ::testing::ValuesIn(sequences().begin(), sequences().end()), [](const auto& entry) { return std::string(entry.param.scene); });

}  // namespace
}  // namespace parhelion::testing::reuse_noise_test
