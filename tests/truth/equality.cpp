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

// How many frames (and samples of the reference) each run takes so that the 99.9 % interval has half the margin's width on either side:
// equal means then pass but for one case in thousands. From pilot runs with seeds of their own, which tell of variances alone.
uint32_t frames_needed(const TruthScene& scene, const ClassRuns& test, const ClassRuns& reference, uint32_t pilot_frames) {
    constexpr double kErrorsInMargin = 7.2, kDoubt = 1.25;  // of a variance from eight runs
    const double light = mean_of(reference.at("picture"));
    double most = 1;
    for (const auto& [name, runs] : reference) {
        const Moments r = moments(runs.means()), t = moments(test.at(name).means());
        if (!(r.mean > 0)) continue;
        const double wanted = margin_of(scene, name, r.mean / light) * r.mean / kErrorsInMargin;
        most = std::max(most, kDoubt * (t.variance + r.variance) * pilot_frames / (kRuns * wanted * wanted));
    }
    const uint32_t cap = by_size(192u, 64u) * truth_effort();
    return static_cast<uint32_t>(std::min<double>(cap, 8 * std::ceil(most / 8)));
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
    TruthStage& on = truth_stage(scene);
    const uint32_t size = by_size(256u, 32u);
    ClassRuns pilot_test, pilot_reference, test, reference;
    const auto draw = [&](ClassRuns& of_test, ClassRuns& of_reference, uint32_t runs, uint32_t first_seed, uint32_t frames) {
        for (uint32_t i = 0; i < runs; ++i) {
            RealtimeOptions options = of.options;
            options.exposure = on.exposure;
            TruthRun run(on, size, first_seed + i, options, true);
            run.skip(of.warm_up);
            add_run(of_test, run.average(frames));
            add_run(of_reference, draw_reference(on, size, first_seed + 10000 + i, frames, true));
        }
    };
    draw(pilot_test, pilot_reference, kPilotRuns, 100000, of.pilot_frames);
    const uint32_t frames = frames_needed(scene, pilot_test, pilot_reference, of.pilot_frames);
    draw(test, reference, kRuns, 1, frames);
    const double light = mean_of(reference.at("picture"));
    ASSERT_GT(light, 0.0);
    for (const auto& [name, runs] : reference) report_class(scene, of, name, test.at(name), runs, light, frames);
}

}  // namespace parhelion::testing
