// How good reconstructed frames are: FLIP against the reference of that very frame, of a sequence in which the camera moves by eight pixels a
// frame while something in the scene moves or is switched, beside one raw frame, plain reprojected accumulation, and Open Image Denoise on
// the same raw frame where its library is found (PARHELION_OIDN).
#include <algorithm>
#include <array>

#include "base/error.h"
#include "image/denoise.h"
#include "scene/load.h"
#include "truth/sequence.h"

namespace parhelion::testing::reconstruction_test {
namespace {

constexpr std::array kLooks{20u, 28u, 35u, 36u, 43u, 44u};  // of 16 to 47; FLIP of the even ones, flicker of those after another

// The mean over the last frames, a tenth of it new, where reprojection finds the surface: nothing else.
ReconstructionOptions plain_control() {
    return {.history = 10, .fast_history = 10, .steps = 0, .firefly = 0.0f, .antilag = 0.0f, .clamp_width = 0.0f, .virtual_motion = false, .antialias = false};
}

std::unique_ptr<image::Denoiser> find_denoiser() {
    try {
        return std::make_unique<image::Denoiser>();
    } catch (const Error&) {
        return nullptr;
    }
}

// What is told of a column: means over the looks.
struct Measured {
    double flip_sum = 0, flicker_sum = 0;
    uint32_t flips = 0, flickers = 0;

    void add_flip(double value) { flip_sum += value, ++flips; }
    void add_flicker(double value) { flicker_sum += value, ++flickers; }
    double flip() const { return flip_sum / flips; }
    double flicker() const { return flicker_sum / flickers; }
};

class RealtimeReconstruction : public TruthTest, public ::testing::WithParamInterface<Sequence> {};

TEST_P(RealtimeReconstruction, frames_of_a_moving_sequence_are_near_the_reference) {
    const TruthScene& scene = scene_of(GetParam());
    if (const std::string why = why_skipped(scene); !why.empty()) return report_skip("reconstruct", scene.name, why);
    TruthStage on = set_up(load_scene(scene.source), truth_stage(scene).camera);
    const std::unique_ptr<image::Denoiser> oidn = find_denoiser();
    RealtimeOptions raw = truth_options(on, true), plain = raw, builtin = raw, upscaled = raw;
    plain.reconstruction = plain_control();
    builtin.reconstruction = upscaled.reconstruction = ReconstructionOptions();
    upscaled.upscale = 2.0;
    std::vector<SequenceRun> runs{{"raw", raw, {"albedo", "normal", "depth", "motion"}}, {"plain", plain}, {"builtin", builtin}, {"upscaled", upscaled}};
    std::map<std::string, Measured> of;
    std::map<std::string, image::ImageF> before;
    uint32_t before_index = 0;
    play(on, scene, GetParam(), picture_size(), pixels_per_frame(), truth_effort() * by_size(scene.noisy ? 4096u : 2048u, 256u), kLooks, runs, [&](const SequenceFrame& frame) {
        std::map<std::string, image::ImageF> now{{"reference", frame.reference}};
        for (const SequenceRun& run : runs) now[run.name] = run.picture;
        if (oidn) oidn->denoise(now["oidn"] = runs[0].picture);
        for (const auto& [name, picture] : now) {
            if (name == "reference") continue;
            if (frame.index % 2 == 0) of[name].add_flip(flip_of(picture, frame.reference));
            if (before_index + 1 == frame.index) of[name].add_flicker(flicker({before.at(name), picture}, {before.at("reference"), frame.reference}, {before.at("raw"), now.at("raw")}, on.exposure));
        }
        before = std::move(now);
        before_index = frame.index;
    });
    std::string note;
    for (const auto& [name, measured] : of) note += fmt::format("{} FLIP {:.3f}, flicker {:.4f}; ", name, measured.flip(), measured.flicker());
    const auto tell = [&](const char* what, double value, double most) {
        report({.test = "reconstruct", .scene = scene.name, .what = what, .value = value, .low = value, .high = value, .least = 0, .most = most, .runs = 1, .frames = static_cast<uint32_t>(kLooks.size()), .note = note});
    };
    // Pictures of a few pixels have an edge in each, which no neighbour helps.
    tell("FLIP over a raw frame's", of["builtin"].flip() / of["raw"].flip(), by_size(0.35, 0.8));
    tell("FLIP over plain's", of["builtin"].flip() / of["plain"].flip(), by_size(0.8, 1.1));
    tell("FLIP of twice the size", of["upscaled"].flip() / of["builtin"].flip(), by_size(1.3, 1.8));
    if (!oidn) return report_skip("reconstruct", scene.name, "Open Image Denoise was not found");
    tell("FLIP over OIDN's", of["builtin"].flip() / of["oidn"].flip(), by_size(1.1, 1.5));
    tell("flicker over OIDN's", of["builtin"].flicker() / of["oidn"].flicker(), by_size(0.25, 1.0));
}
INSTANTIATE_TEST_SUITE_P(Of, RealtimeReconstruction, ::testing::ValuesIn(sequences().begin(), sequences().end()), [](const auto& entry) { return std::string(entry.param.scene); });

}  // namespace
}  // namespace parhelion::testing::reconstruction_test
