// What the tests of equal means share (equality.h).
#include "truth/equality.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace parhelion::testing {
namespace {

// A class that brings less than a hundredth of the light may be off by this share of a hundredth.
constexpr double kMargin = 0.005, kSmallClass = 0.01;
// What the CPU device resolves in a minute.
constexpr double kSmallMargin = 0.05;
constexpr double kSignalRounding = 0x1p-15;  // the picture is made of signals of 14 bits, classes are not
constexpr uint32_t kRuns = 32, kPilotRuns = 8;
constexpr float kSunRadius = 0.0465f;  // ten times the sun's
// Large pictures and few frames: small ones leave a GPU idle. Tiles are a thousandth of the picture.
constexpr uint32_t kSize = 512, kTile = 16, kMostFrames = 384, kMostSamples = 128;

// A few bright paths make much of these classes: what a GPU resolves in some seconds.
struct NoisyClass {
    std::string_view scene, name;
    double margin;
};
constexpr NoisyClass kNoisy[] = {
    {"diorama", "indirect_diffuse", 0.01},
    {"diorama", "indirect_specular", 0.02},
    {"many_lights", "indirect_diffuse", 0.02},
    {"many_lights", "indirect_specular", 0.02},
    {"sponza_1000_lights", "direct_specular", 0.01},
    {"sponza_1000_lights", "indirect_specular", 0.01},
};

// Relative to the class, which brings `share` of the light.
double margin_of(const TruthScene& scene, std::string_view name, double share) {
    double margin = kMargin;
    for (const NoisyClass& noisy : kNoisy)
        if (noisy.scene == scene.name && noisy.name == name) margin = noisy.margin;
    return by_size(margin, kSmallMargin) * std::max(1.0, kSmallClass / share);
}

double mean_of(const Runs& runs) { return moments(runs.means()).mean; }

// Of each run: frames of the test, samples of its reference.
struct Needed {
    uint32_t frames, samples;
};

// As many as make the 99.9 % interval half as wide as the margin, if both have the same part in it (equal means then pass but for one case in thousands), times the
// effort. From pilot runs with seeds of their own, which tell of variances alone; rare bright paths make these too small, so samples are no fewer than frames, up to their own bound.
Needed find_needed(const TruthScene& scene, const ClassRuns& test, const ClassRuns& reference, uint32_t pilot_frames) {
    constexpr double kErrorsInMargin = 7.2, kDoubt = 1.25;  // of a variance from eight runs
    const double light = mean_of(reference.at("picture"));
    double frames = 1, samples = 1;
    for (const auto& [name, runs] : reference) {
        const Moments r = moments(runs.means()), t = moments(test.at(name).means());
        if (!(r.mean > 0)) continue;
        const double wanted = margin_of(scene, name, r.mean / light) * r.mean / kErrorsInMargin, scale = kDoubt * pilot_frames / (kRuns * 0.5 * wanted * wanted);
        frames = std::max(frames, t.variance * scale), samples = std::max(samples, r.variance * scale);
    }
    const auto rounded = [](double count, uint32_t most) { return truth_effort() * static_cast<uint32_t>(std::min<double>(most, 8 * std::ceil(count / 8))); };
    return {rounded(frames, by_size(kMostFrames, 64u)), rounded(std::max(frames, samples), by_size(kMostSamples, 64u))};
}

void report_class(const TruthScene& scene, const EqualityCase& of, const std::string& name, const Runs& test, const Runs& reference, double light, uint32_t frames) {
    TruthRow row{.test = of.test, .scene = scene.name, .what = of.what.empty() ? name : of.what + ": " + name, .least = 1, .most = 1, .runs = test.count(), .frames = frames};
    const double share = mean_of(reference) / light;
    if (!(share > 0)) {
        row.value = row.low = row.high = 1 + mean_of(test) / light;
        row.note = "no light of this class in the reference";
        return report(row);
    }
    const double margin = margin_of(scene, name, share);
    const Equivalence found = equivalence_test(test, reference, margin, name == "picture" ? kSignalRounding : kRounding);
    row.value = found.ratio, row.low = found.low, row.high = found.high;
    row.least = 1 - margin, row.most = 1 + margin;
    row.also = found.tiles_passed && found.reference_error <= margin / 4;
    row.note = fmt::format("{:.2f} % of the light, tiles {}/{} of {}, reference +-{:.5f}", 100 * share, found.tiles_over, found.tiles_allowed, found.tiles, found.reference_error);
    report(row);
}

}  // namespace

void expect_equal_classes(const TruthScene& scene, const EqualityCase& of) {
    if (const std::string why = why_skipped(scene); !why.empty()) {
        report_skip(of.test, scene.name, why);
        GTEST_SKIP() << scene.name << ": " << why;
    }
    TruthStage& on = truth_stage(scene, kSunRadius);
    const uint32_t size = by_size(kSize, 32u), tile = by_size(kTile, Runs::kTileSize);
    ClassRuns pilot_test, pilot_reference, test, reference;
    const auto draw = [&](ClassRuns& of_test, ClassRuns& of_reference, uint32_t runs, uint32_t first_seed, Needed needed) {
        for (uint32_t i = 0; i < runs; ++i) {
            RealtimeOptions options = of.options;
            options.exposure = on.exposure;
            TruthRun run(on, size, first_seed + i, options, true);
            run.skip(of.warm_up);
            add_run(of_test, run.average(needed.frames), tile);
            add_run(of_reference, draw_reference(on, size, first_seed + 10000 + i, needed.samples, true), tile);
        }
    };
    draw(pilot_test, pilot_reference, kPilotRuns, 100000, {of.pilot_frames, of.pilot_frames});
    const Needed needed = find_needed(scene, pilot_test, pilot_reference, of.pilot_frames);
    draw(test, reference, kRuns, 1, needed);
    const double light = mean_of(reference.at("picture"));
    ASSERT_GT(light, 0.0);
    for (const auto& [name, runs] : reference) report_class(scene, of, name, test.at(name), runs, light, needed.frames);
}

}  // namespace parhelion::testing
