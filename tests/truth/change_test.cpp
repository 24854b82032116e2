// Light that changes: how long the realtime renderer shows what is no longer so. Undenoised, the mean of 64 runs.
#include <array>
#include <cmath>
#include <limits>
#include <ostream>
#include <random>
#include <stdexcept>
#include <utility>

#include "truth/switched_room.h"

namespace parhelion::testing::change_test {
namespace {

struct SwitchCase {
    const char* name;
    Lit lit;
    bool small;
};
std::ostream& operator<<(std::ostream& out, const SwitchCase& entry) { return out << entry.name; }
constexpr SwitchCase kSwitches[] = {{"sun", Lit::Sun, true}, {"lamp", Lit::Lamp, true}, {"emissive_mesh", Lit::Mesh, false}};

class RealtimeSwitch : public TruthTest, public ::testing::WithParamInterface<SwitchCase> {};

// Means of runs at one stage: of the picture, and of what comes by way of other surfaces, which alone can lag.
struct Means {
    std::vector<double> picture, indirect;
    void add(const image::ImageF& seen) {
        picture.push_back(mean_luminance(seen));
        double sum = 0;
        for (const float v : luminance(seen, *seen.find_channel("path.indirect_diffuse.R"))) sum += static_cast<double>(v);
        indirect.push_back(sum / static_cast<double>(seen.pixel_count()));
    }
};

// The frame in which the light is switched is frame 1. One-sided 99 % bounds of ratios to the lit room's mean, run by run. How fast the
// indirect part comes back is told for information.
TEST_P(RealtimeSwitch, a_light_that_goes_out_is_forgotten_and_one_that_comes_on_is_seen) {
    const SwitchCase& param = GetParam();
    if (small_truth() && !param.small) GTEST_SKIP() << "not in the small truth";
    Switched room = make_switched(param.lit);
    const std::function<SceneEdit(bool)> set = room.set;
    TruthStage on = set_up(std::move(room.loaded), switched_room_camera());
    const uint32_t size = by_size(128u, 16u), runs = by_size(64u, 16u) * truth_effort(), lit = by_size(64u, 24u), settled = 8;
    Means steady, off8, off24, on8, on24;
    for (uint32_t i = 0; i < runs; ++i) {
        TruthRun run(on, size, 1 + i, truth_options(on, true), true);
        const auto switch_to = [&](bool now) {
            run.script = [&, now, first = true](uint32_t) mutable { return std::exchange(first, false) ? set(now) : SceneEdit(); };
        };
        run.skip(lit - settled);
        steady.add(run.average(settled));
        switch_to(false);
        run.skip(7);
        off8.add(run.average(1));
        run.skip(15);
        off24.add(run.average(1));
        run.skip(by_size(16u, 0u));
        switch_to(true);
        run.skip(7);
        on8.add(run.average(1));
        run.skip(15);
        on24.add(run.average(settled));
    }
    constexpr double kAny = std::numeric_limits<double>::infinity();
    const auto row = [&](const char* what, const std::vector<double>& found, const std::vector<double>& before, double least, double most, uint32_t frames) {
        const Ratio ratio = paired_ratio(found, before);
        report({.test = "switch", .scene = param.name, .what = what, .value = ratio.value, .low = least > 0 ? ratio.lower() : ratio.value, .high = most < kAny ? ratio.upper() : ratio.value,
                .least = least, .most = most, .runs = runs, .frames = frames});
    };
    row("off: residual at frame 8", off8.picture, steady.picture, 0, 0.10, 1);
    row("off: residual at frame 24", off24.picture, steady.picture, 0, 0.01, 1);
    row("off: indirect at frame 8", off8.indirect, steady.indirect, 0, 0.10, 1);
    row("off: indirect at frame 24", off24.indirect, steady.indirect, 0, 0.01, 1);
    row("on: at frame 8", on8.picture, steady.picture, by_size(0.90, 0.80), kAny, 1);
    row("on: frames 24 to 31", on24.picture, steady.picture, by_size(0.99, 0.90), kAny, settled);
    row("on: indirect at frame 8", on8.indirect, steady.indirect, 0, kAny, 1);
    row("on: indirect, 24 to 31", on24.indirect, steady.indirect, 0, kAny, settled);
}

INSTANTIATE_TEST_SUITE_P(Lights, RealtimeSwitch, ::testing::ValuesIn(kSwitches), [](const auto& entry) { return std::string(entry.param.name); });

// Mean over pixels of the squared difference over the squared truth; dark pixels (of a tenth of the mean) count as such a tenth.
double relative_square_error(const std::vector<float>& picture, const std::vector<float>& truth) {
    double mean = 0, sum = 0;
    for (const float v : truth) mean += static_cast<double>(v) / static_cast<double>(truth.size());
    for (size_t p = 0; p < truth.size(); ++p) {
        const double a = static_cast<double>(picture[p]), b = static_cast<double>(truth[p]);
        sum += (a - b) * (a - b) / (b * b + 0.01 * mean * mean);
    }
    return sum / static_cast<double>(truth.size());
}

// The means of tiles of 8x8 pixels, row by row; the size is a multiple of 8.
std::vector<float> tiles_of(const std::vector<float>& picture, uint32_t size) {
    const uint32_t across = size / Runs::kTileSize;
    std::vector<float> out(size_t{across} * across);
    for (uint32_t y = 0; y < size; ++y)
        for (uint32_t x = 0; x < size; ++x) out[size_t{y / Runs::kTileSize} * across + x / Runs::kTileSize] += picture[size_t{y} * size + x] / float(Runs::kTileSize * Runs::kTileSize);
    return out;
}

// Pictures of runs, of which any choice has a mean.
using Pictures = std::vector<std::vector<float>>;
double error_of_mean(const Pictures& pictures, std::span<const uint32_t> chosen, const std::vector<float>& truth) {
    std::vector<float> mean(truth.size());
    for (const uint32_t run : chosen)
        for (size_t p = 0; p < mean.size(); ++p) mean[p] += pictures[run][p] / static_cast<float>(chosen.size());
    return relative_square_error(mean, truth);
}

// Of a light that moves and of one that stands: sums over moments, and over the same with other choices of runs (bootstrap).
struct Errors {
    double moving = 0, still = 0;
    std::vector<double> moving_again = std::vector<double>(100), still_again = std::vector<double>(100);

    void add(const Pictures& of_moving, const Pictures& of_still, const std::vector<float>& truth) {
        std::mt19937_64 rng(41);
        const size_t runs = of_moving.size();
        std::vector<uint32_t> all(runs), a(runs), b(runs);
        for (uint32_t i = 0; i < runs; ++i) all[i] = i;
        moving += error_of_mean(of_moving, all, truth);
        still += error_of_mean(of_still, all, truth);
        for (size_t again = 0; again < moving_again.size(); ++again) {
            for (size_t i = 0; i < runs; ++i) a[i] = static_cast<uint32_t>(rng() % runs), b[i] = static_cast<uint32_t>(rng() % runs);
            moving_again[again] += error_of_mean(of_moving, a, truth);
            still_again[again] += error_of_mean(of_still, b, truth);
        }
    }
    Ratio ratio(size_t runs) const {
        std::vector<double> ratios;
        for (size_t again = 0; again < moving_again.size(); ++again) ratios.push_back(moving_again[again] / still_again[again]);
        return {.value = moving / still, .error = std::sqrt(moments(ratios).variance), .degrees_of_freedom = static_cast<double>(runs - 1)};
    }
};

// The box with its lamp off and the ball that glows in it, at a moment.
struct TorchLitBox {
    TruthStage on;
    ScriptedEdit torch;
};
TorchLitBox make_torch_lit_box() {
    LoadedScene loaded = make_builtin("builtin:cornell");
    const auto named = [&](std::string_view name) {
        for (const ScriptedEdit& edit : loaded.scripted_edits)
            if (edit.name == name) return edit;
        throw std::logic_error("cornell has lost a scripted edit");
    };
    const ScriptedEdit torch = named("torch"), lamp = named("lamp");
    const CameraView camera = view_of((*loaded.scene.cameras().begin()).value, 1.0f);
    loaded.scene.apply(lamp.apply(loaded.scene, 1.5));  // off
    loaded.scene.apply(torch.apply(loaded.scene, 0.0));
    return {set_up(std::move(loaded), camera), torch};
}

using RealtimeMovingLight = TruthTest;

// relMSE of the runs' mean against the reference of that very frame, over that of a light that has stood there all the time: of the picture,
// and of what comes by way of other surfaces, which alone can lag. The last row tells of the lag under the noise: no limit is set for it.
TEST_F(RealtimeMovingLight, a_light_at_two_metres_a_second_is_at_most_twice_as_wrong_as_one_that_stands) {
    constexpr double kFramesPerSecond = 60.0;
    constexpr const char* kParts[] = {"picture", "indirect_diffuse", "indirect_diffuse, tiles"};
    TorchLitBox box = make_torch_lit_box();
    TruthStage& on = box.on;
    const uint32_t size = by_size(128u, 16u), runs = by_size(64u, 12u), warm_up = by_size(64u, 16u);
    const auto parts_of = [&](const image::ImageF& picture) {
        const std::vector<float> indirect = luminance(picture, *picture.find_channel("path.indirect_diffuse.R"));
        return std::array{luminance(picture), indirect, tiles_of(indirect, size)};
    };
    std::array<Errors, 3> errors;
    for (const uint32_t frame : {warm_up, warm_up + 24}) {
        const auto play = [&](bool moves) {
            std::array<Pictures, 3> out;
            for (uint32_t i = 0; i < runs; ++i) {
                TruthRun run(on, size, 1 + i + (moves ? 1000 : 0), truth_options(on, true), true);
                run.script = [&](uint32_t now) { return box.torch.apply(on.stage->scene, (moves ? now : frame) / kFramesPerSecond); };
                run.skip(moves ? frame : warm_up);
                auto parts = parts_of(run.average(1));
                for (size_t k = 0; k < out.size(); ++k) out[k].push_back(std::move(parts[k]));
            }
            return out;
        };
        const auto moving = play(true), still = play(false);
        const auto truth = parts_of(draw_reference(on, size, 9, by_size(8192u, 1024u), true));  // where the light stood last
        for (size_t k = 0; k < errors.size(); ++k) errors[k].add(moving[k], still[k], truth[k]);
    }
    for (size_t k = 0; k < errors.size(); ++k) {
        const Ratio ratio = errors[k].ratio(runs);
        report({.test = "moving", .scene = "cornell, torch", .what = fmt::format("relMSE, {}", kParts[k]), .value = ratio.value, .low = ratio.value, .high = ratio.upper(), .least = 0,
                .most = k == 2 ? std::numeric_limits<double>::infinity() : by_size(2.0, 3.0), .runs = runs, .frames = 1,
                .note = fmt::format("over the static light's; relMSE {:.3g} and {:.3g}", errors[k].moving / 2, errors[k].still / 2)});
    }
}

}  // namespace
}  // namespace parhelion::testing::change_test
