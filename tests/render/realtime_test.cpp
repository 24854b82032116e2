// The realtime renderer without its cache is the reference with another choice of lights: the same picture in the mean, and without
// light tiles the same samples.
#include "shared/scene.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::realtime_test {
namespace {

const std::vector<std::string> kClasses{"path.*"};
constexpr const char* kScenes[] = {"builtin:cornell", "builtin:diorama", "builtin:reflections", "builtin:glass"};

class RealtimePicture : public GpuTest {};

Shot pinhole_shot(gpu::TraceWay way, uint32_t samples) {
    return {.way = way, .view = {.width = 32, .height = 32, .filter = PixelFilter::Point, .aovs = kClasses}, .sample_count = samples};
}

TEST_F(RealtimePicture, without_tiles_a_frame_is_a_sample_of_the_reference) {
    for (const char* name : kScenes) {
        SCOPED_TRACE(name);
        Stage& stage = builtin_stage(name);
        const Shot shot = pinhole_shot(gpu::TraceWay::Compute, 2);
        const image::ImageF expected = image::resolve_film(stage.render(shot));
        const RayCounts rays = stage.rays;
        const image::ImageF found = image::resolve_film(stage.play(shot, {.tiles = false, .cache = false}));
        EXPECT_GT(mean_rgb(expected), 0.0);
        EXPECT_EQ(stage.rays.path + 2 * 32 * 32, rays.path);  // what pixels see is not traced here
        EXPECT_EQ(stage.rays.shadow, rays.shadow);
        for (size_t c = 0; c < expected.channels.size(); ++c) {
            double worst = 0.0;
            for (size_t p = 0; p < expected.pixel_count(); ++p) {
                const double a = expected.plane(c)[p], b = found.plane(c)[p];
                worst = std::max(worst, std::abs(a - b) / std::max(1e-6, std::abs(a)));
            }
            EXPECT_LE(worst, c < 3 ? 0x1p-12 : 1e-5) << expected.channels[c] << ": the picture's signals have 14 bits";
        }
    }
}

// Reconstruction that changes nothing: the signals put together again.
ReconstructionOptions no_reconstruction() {
    return {.history = 1, .fast_history = 1, .steps = 0, .firefly = 0.0f, .antilag = 0.0f, .clamp_width = 0.0f, .virtual_motion = false, .antialias = false};
}

// The signals are then those of what mirrors and panes show, in whose place it stands: the light is the same, and so are the path's classes.
TEST_F(RealtimePicture, following_mirrors_and_panes_moves_light_between_signals_and_no_more) {
    for (const char* name : {"builtin:reflections", "builtin:glass"}) {
        SCOPED_TRACE(name);
        Stage& stage = builtin_stage(name);
        const Shot shot = pinhole_shot(gpu::TraceWay::Compute, 1);
        RealtimeOptions options{.tiles = false, .cache = false, .exposure = 1e-3f};
        const image::ImageF expected = image::resolve_film(stage.play(shot, options));
        options.reconstruction = no_reconstruction();
        const image::ImageF found = image::resolve_film(stage.play(shot, options));
        for (size_t c = 0; c < expected.channels.size(); ++c) {
            double worst = 0.0;
            for (size_t p = 0; p < expected.pixel_count(); ++p) {
                const double a = expected.plane(c)[p], b = found.plane(c)[p];
                worst = std::max(worst, std::abs(a - b) / std::max(0.1, std::abs(a)));
            }
            EXPECT_LE(worst, c < 3 ? 0x1p-8 : 1e-5) << expected.channels[c] << ": histories have 11 bits, of two signals";
        }
    }
}

// Runs of one estimator, a Runs for the beauty and each class: luminance.
std::map<std::string, Runs> runs_of(uint32_t count, uint32_t first_seed, const std::function<image::ImageF(uint32_t seed)>& draw) {
    std::map<std::string, Runs> out;
    for (uint32_t i = 0; i < count; ++i) {
        const image::ImageF picture = draw(first_seed + i);
        for (size_t c = 0; c + 2 < picture.channels.size(); c += 3) {
            std::string name = picture.channels[c] == "R" ? "beauty" : picture.channels[c].substr(0, picture.channels[c].size() - 2);
            std::vector<float> luminance(picture.pixel_count());
            for (size_t p = 0; p < luminance.size(); ++p) luminance[p] = 0.2126f * picture.plane(c)[p] + 0.7152f * picture.plane(c + 1)[p] + 0.0722f * picture.plane(c + 2)[p];
            out.try_emplace(std::move(name), picture.width, picture.height).first->second.add_run(luminance);
        }
    }
    return out;
}

double mean_of(const Runs& runs) {
    double sum = 0.0;
    for (const double mean : runs.means()) sum += mean / runs.count();
    return sum;
}

// Every class that brings at least a hundredth of the light.
void expect_equivalent(const std::map<std::string, Runs>& test, const std::map<std::string, Runs>& reference, double margin) {
    const double beauty = mean_of(reference.at("beauty"));
    for (const auto& [name, runs] : reference) {
        if (mean_of(runs) < 0.01 * beauty) continue;
        const Equivalence found = equivalence_test(test.at(name), runs, margin);
        EXPECT_TRUE(found.passed) << name << ": " << found.text;
    }
}

TEST_F(RealtimePicture, with_tiles_every_class_has_the_mean_of_the_reference) {
    struct Case {
        const char* scene;
        double margin;  // what 32 runs of 32 frames resolve in the noisiest class: of spheres the indirect ones. ./dev truth has smaller ones
    };
    for (const auto& [scene, margin] : {Case{"builtin:cornell", 0.02}, Case{"builtin:leak-box", 0.02}, Case{"builtin:spheres", 0.05}}) {
        SCOPED_TRACE(scene);
        Stage& stage = builtin_stage(scene);
        const auto reference = runs_of(32, 1000, [&](uint32_t seed) {
            Shot shot = pinhole_shot(gpu::TraceWay::Compute, 64);
            shot.view.seed = seed;
            return image::resolve_film(stage.render(shot));
        });
        const auto test = runs_of(32, 1, [&](uint32_t seed) {
            Shot shot = pinhole_shot(gpu::TraceWay::Compute, 32);
            shot.view.seed = seed;
            return image::resolve_film(stage.play(shot, {.cache = false}));
        });
        expect_equivalent(test, reference, margin);
    }
}

}  // namespace
}  // namespace parhelion::testing::realtime_test
