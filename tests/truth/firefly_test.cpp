// Single pixels that are far too bright: what caustics and small lamps make of one path a pixel, after reconstruction; and whether that gets rid of them
// by taking their light away.
#include <algorithm>
#include <numeric>

#include "truth/truth.h"

namespace parhelion::testing::firefly_test {
namespace {

constexpr double kBright = 10;                 // times what the reference has there, or beside it
constexpr double kMost = 1e-5, kBias = 0.01;   // of all pixels of all frames; of the mean
constexpr double kDark = 0.01;                 // of the reference's mean: what is darker counts as that

uint32_t picture_size() { return by_size(256u, 48u); }

// Of 3x3 pixels the brightest.
std::vector<float> brightest_around(const std::vector<float>& of, uint32_t size) {
    std::vector<float> out(of.size());
    const auto pixels = static_cast<int>(size);
    for (int y = 0; y < pixels; ++y)
        for (int x = 0; x < pixels; ++x) {
            float most = 0;
            for (int v = std::max(y - 1, 0); v <= std::min(y + 1, pixels - 1); ++v)
                for (int u = std::max(x - 1, 0); u <= std::min(x + 1, pixels - 1); ++u) most = std::max(most, of[static_cast<size_t>(v * pixels + u)]);
            out[static_cast<size_t>(y * pixels + x)] = most;
        }
    return out;
}

double mean_of(const std::vector<float>& values) { return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()); }

class RealtimeFireflies : public TruthTest, public ::testing::WithParamInterface<TruthScene> {};

TEST_P(RealtimeFireflies, no_pixel_is_ten_times_too_bright_and_no_light_is_lost_for_that) {
    const TruthScene& scene = GetParam();
    if (const std::string why = why_skipped(scene); !why.empty()) return report_skip("fireflies", scene.name, why);
    TruthStage& on = truth_stage(scene);
    const uint32_t frames = by_size(256u, 32u), warm_up = by_size(32u, 8u);
    RealtimeOptions reconstructed = truth_options(on, true), unbounded = reconstructed;
    reconstructed.reconstruction = ReconstructionOptions();
    unbounded.reconstruction = ReconstructionOptions{.firefly = 0.0f, .clamp_width = 0.0f};
    CameraView pinhole = on.camera;
    pinhole.lens_radius = 0.0f;
    ViewDesc whole_pixels = truth_view(on, picture_size(), 5, false);
    whole_pixels.filter = PixelFilter::Box;  // as anti-aliasing shows them: lamps smaller than a pixel lie between the centres
    const std::vector<float> reference = luminance(draw_paths(on, whole_pixels, pinhole, by_size(4096u, 256u)));
    const std::vector<float> around = brightest_around(reference, picture_size());
    const double mean = mean_of(reference);
    TruthRun run(on, picture_size(), 1, reconstructed), beside(on, picture_size(), 1, unbounded);
    run.skip(warm_up), beside.skip(warm_up);
    uint64_t bright = 0;
    double sum = 0;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        const std::vector<float> shown = luminance(run.average(1));
        for (size_t p = 0; p < shown.size(); ++p) bright += static_cast<double>(shown[p]) > kBright * std::max(static_cast<double>(around[p]), kDark * mean);
        sum += mean_of(shown) / frames;
    }
    const double share = static_cast<double>(bright) / static_cast<double>(reference.size() * frames), kept = sum / mean_of(luminance(beside.average(frames)));
    report({.test = "fireflies", .scene = scene.name, .what = "pixels ten times too bright", .value = share, .low = share, .high = share, .least = 0, .most = by_size(kMost, 1e-3), .runs = 1, .frames = frames});
    report({.test = "fireflies", .scene = scene.name, .what = "mean over that without any bound", .value = kept, .low = kept, .high = kept, .least = 1 - by_size(kBias, 0.05), .most = 1 + by_size(kBias, 0.05), .runs = 1, .frames = frames});
}

std::vector<TruthScene> built_in_scenes() {
    std::vector<TruthScene> out;
    std::ranges::copy_if(truth_scenes(), std::back_inserter(out), [](const TruthScene& scene) { return std::string_view(scene.source).starts_with("builtin:"); });
    return out;
}
INSTANTIATE_TEST_SUITE_P(Scenes, RealtimeFireflies, ::testing::ValuesIn(built_in_scenes()), scene_name);

}  // namespace
}  // namespace parhelion::testing::firefly_test
