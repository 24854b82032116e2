// A13 on rendered pictures: how the error of a pixel falls with its samples, by kind of sampler. The integrands of
// tests/unit/sampler_convergence_test.cpp stand for these; here light transport itself spends the random numbers.
#include <cmath>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/film_state.h"
#include "session/scene_setup.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::convergence_test {
namespace {

constexpr uint32_t kSize = 16, kLast = 1024, kRuns = 3;

struct Scenery {
    const char* name;  // a built-in scene, or "lamp"
    uint32_t max_bounces;
    PixelFilter filter;
    bool smooth;
};

// A floor under one bright triangle, nothing between them: smooth in two dimensions.
Scene make_lamp() {
    SceneEdit edit;
    Primitive floor, lamp;
    add_quad(floor, {-4.0f, 0.0f, 4.0f}, {8.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -8.0f});
    builtin::add_object(edit, "floor", std::move(floor), edit.add(builtin::lambert("floor", glm::vec3(0.5f))));
    add_quad(lamp, {-1.0f, 2.0f, -1.0f}, {2.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 2.0f});
    lamp.triangles.resize(1);
    builtin::add_object(edit, "lamp", std::move(lamp), edit.add(builtin::lambert("lamp", glm::vec3(0.0f), glm::vec3(5.0f))));
    builtin::add_camera(edit, "above", {0.0f, 6.0f, 0.01f}, {0.0f, 0.0f, 0.0f}, 0.6f);
    return make_scene(std::move(edit));
}

Stage& stage_of(const Scenery& s) {
    if (s.name != std::string("lamp")) return builtin_stage(fmt::format("builtin:{}", s.name));
    shared_device();  // outlives the stage
    static Stage stage(make_lamp());
    return stage;
}

class Convergence : public GpuTest, public ::testing::WithParamInterface<Scenery> {
protected:
    // Green of every pixel after 16, 32, 64, ... `last` samples of one run.
    static std::vector<std::vector<double>> run(const Scenery& s, SamplerKind sampler, uint32_t seed, uint32_t last) {
        Stage& stage = stage_of(s);
        ViewDesc desc{.width = kSize, .height = kSize, .seed = seed, .max_bounces = s.max_bounces, .sampler = sampler, .filter = s.filter};
        desc.camera = shader_camera(view_of((*stage.scene.cameras().begin()).value, 1.0f), 1.0f);
        View view(stage.frame.device(), desc);
        stage.scene_gpu.finish(stage.frame);
        std::vector<std::vector<double>> pictures;
        for (uint32_t first = 0, end = 16; end <= last; first = end, end *= 2) {
            for (uint32_t sample = first; sample < end;) {
                const uint32_t count = std::min(end - sample, shared::kSamplesPerBlock);
                record_reference(stage.frame, stage.scene_gpu, gpu::TraceWay::Compute, view, {0, kSize, sample, count}, false);
                sample += count;
            }
            stage.frame.run();
            pictures.push_back(green(stage.frame, view, end));
        }
        return pictures;
    }

    // Errors of a typical pixel by count: geometric means over the pixels, for a root mean square over them would be that of a few.
    // A pixel's mean square error is the variance of an unbiased estimate, which independent runs tell: no other picture is needed.
    // Known to 4 %, its slope to 0.011 (standard deviations); seeds are fixed.
    static std::vector<double> errors(const Scenery& s, SamplerKind sampler, uint32_t last) {
        std::vector<std::vector<std::vector<double>>> runs;
        for (uint32_t seed = 0; seed < kRuns; ++seed) runs.push_back(run(s, sampler, seed, last));
        std::vector<double> out;
        for (size_t n = 0; n < runs[0].size(); ++n) {
            double logarithms = 0, count = 0;
            for (size_t p = 0; p < kSize * kSize; ++p) {
                std::vector<double> values;
                for (const auto& pictures : runs) values.push_back(pictures[n][p]);
                const double variance = moments(values).variance;
                if (variance > 0) logarithms += 0.5 * std::log(variance), ++count;  // pixels that see the lamp alone have none
            }
            out.push_back(std::exp(logarithms / count));
        }
        return out;
    }

    static double slope(const std::vector<double>& errors) {
        std::vector<double> counts;
        for (size_t i = 0; i < errors.size(); ++i) counts.push_back(std::ldexp(16.0, static_cast<int>(i)));
        return fit_log_slope(counts, errors).slope;
    }

private:
    // Exact sums and the block that has not ended.
    static std::vector<double> green(Frame& frame, const View& view, uint32_t samples) {
        const gpu::Buffer block = frame.read_back(view.film().block);
        const image::FilmSums film = make_film_sums(view.read_film(frame), {kSize, kSize}, {0, samples}, {});
        std::vector<double> out;
        for (size_t p = 0; p < film.pixel_count(); ++p)
            out.push_back(image::fixed_mean(film.sum(1, p), samples) + block.mapped_as<float>()[film.pixel_count() + p] / double(samples));
        return out;
    }
};

TEST_P(Convergence, is_as_fast_as_the_sampler_allows) {
    const Scenery& scenery = GetParam();
    const std::vector<double> random = errors(scenery, SamplerKind::Pcg, kLast / 4);
    EXPECT_NEAR(slope(random), -0.5, 0.05);
    for (const SamplerKind sampler : {SamplerKind::Owen, SamplerKind::Cranley}) {
        const std::vector<double> found = errors(scenery, sampler, kLast);
        EXPECT_LE(slope(found), scenery.smooth ? -0.65 : -0.48) << static_cast<int>(sampler);
        for (size_t i = 0; i < random.size(); ++i) EXPECT_LE(found[i], 1.05 * random[i]) << (16 << i) << " samples, kind " << static_cast<int>(sampler);
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Convergence,
                         ::testing::Values(Scenery{"cornell", 1, PixelFilter::Point, false}, Scenery{"cornell", 4, PixelFilter::Box, false}, Scenery{"diffuse-box", 1, PixelFilter::Point, true},
                                           Scenery{"lamp", 1, PixelFilter::Box, true}, Scenery{"spheres", 3, PixelFilter::Box, false}),
                         [](const auto& given) {
                             const Scenery& s = given.param;
                             return fmt::format("{}_{}_{}", s.name == std::string("diffuse-box") ? "box" : s.name, s.max_bounces, s.filter == PixelFilter::Box ? "filtered" : "point");
                         });

}  // namespace
}  // namespace parhelion::testing::convergence_test
