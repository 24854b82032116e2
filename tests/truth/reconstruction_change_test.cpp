// Light that changes, as reconstructed frames show it: how long they keep what is no longer so, and how late they have what is.
#include <algorithm>
#include <limits>
#include <utility>

#include "truth/switched_room.h"

namespace parhelion::testing::reconstruction_change_test {
namespace {

constexpr const char* kNames[] = {"sun", "lamp", "emissive_mesh"};  // of Lit

// Of pictures of one moment, run by run: their mean, and their brightest 8x8 tile's.
struct Seen {
    std::vector<double> mean, brightest;

    void add(const image::ImageF& picture) {
        mean.push_back(mean_luminance(picture));
        const uint32_t across = picture.width / Runs::kTileSize;
        std::vector<double> tiles(size_t{across} * across);
        const std::vector<float> pixels = luminance(picture);
        for (size_t p = 0; p < pixels.size(); ++p) tiles[p / picture.width / Runs::kTileSize * across + p % picture.width / Runs::kTileSize] += static_cast<double>(pixels[p]);
        brightest.push_back(*std::ranges::max_element(tiles) / (Runs::kTileSize * Runs::kTileSize));
    }
};

class ReconstructionSwitch : public TruthTest, public ::testing::WithParamInterface<Lit> {};

// The frame in which the light is switched is frame 1, and each is judged by itself: no means over frames. One-sided 99 % bounds of ratios to
// the lit room's mean, run by run; how bright the brightest tile stays is told for information.
TEST_P(ReconstructionSwitch, frames_forget_a_light_that_goes_out_and_show_one_that_comes_on) {
    const char* name = kNames[static_cast<int>(GetParam())];
    if (small_truth() && GetParam() != Lit::Lamp) GTEST_SKIP() << "not in the small truth";
    Switched room = make_switched(GetParam());
    const std::function<SceneEdit(bool)> set = room.set;
    TruthStage on = set_up(std::move(room.loaded), switched_room_camera());
    RealtimeOptions options = truth_options(on, true);
    options.reconstruction = ReconstructionOptions();
    const uint32_t size = by_size(256u, 32u), runs = by_size(8u, 5u) * truth_effort(), lit = by_size(128u, 32u), settled = 8;
    Seen steady, off4, off12, on4, on16;
    for (uint32_t i = 0; i < runs; ++i) {
        TruthRun run(on, size, 1 + i, options);
        const auto switch_to = [&](bool now) {
            run.script = [&, now, first = true](uint32_t) mutable { return std::exchange(first, false) ? set(now) : SceneEdit(); };
        };
        const auto look = [&](Seen& seen, uint32_t frames) {
            run.skip(frames - 1);
            seen.add(run.average(1));
        };
        run.skip(lit - settled);
        steady.add(run.average(settled));
        switch_to(false);
        look(off4, 4);
        look(off12, 8);
        run.skip(by_size(32u, 4u));
        switch_to(true);
        look(on4, 4);
        look(on16, 12);
    }
    constexpr double kAny = std::numeric_limits<double>::infinity();
    const auto row = [&](const char* what, const std::vector<double>& found, double least, double most) {
        const Ratio ratio = paired_ratio(found, steady.mean);
        report({.test = "re-switch", .scene = name, .what = what, .value = ratio.value, .low = least > 0 ? ratio.lower() : ratio.value, .high = most < kAny ? ratio.upper() : ratio.value,
                .least = least, .most = most, .runs = runs, .frames = 1});
    };
    // The cache of a small picture has few paths: runs differ by 8 % in frame 16.
    row("off: residual at frame 4", off4.mean, 0, by_size(0.10, 0.20));
    row("off: residual at frame 12", off12.mean, 0, by_size(0.01, 0.02));
    row("off: brightest tile, 12", off12.brightest, 0, kAny);
    row("on: at frame 4", on4.mean, by_size(0.90, 0.60), kAny);
    row("on: at frame 16", on16.mean, by_size(0.99, 0.75), kAny);
}
INSTANTIATE_TEST_SUITE_P(Of, ReconstructionSwitch, ::testing::Values(Lit::Sun, Lit::Lamp, Lit::Mesh), [](const auto& entry) { return std::string(kNames[static_cast<int>(entry.param)]); });

}  // namespace
}  // namespace parhelion::testing::reconstruction_change_test
