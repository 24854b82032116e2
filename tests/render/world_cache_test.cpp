// What the world cache says of real light, against closed forms and against paths without it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "passes/cache/cache.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/scene_setup.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::world_cache_test {
namespace {

constexpr double kPi = std::numbers::pi;

// A view that looks at cells: a frame of the cache, then every pixel asks once (tests/device/shaders/cache_probe.trace).
class Watcher {
public:
    Watcher(Stage& stage, gpu::TraceWay way, const CacheOptions& options, float footprint, uint32_t size = 16, const std::string& camera = {})
        : cache(stage.frame.device(), options), stage_(stage), way_(way), footprint_(footprint), size_(size), view_(make_view(camera)) {}

    // Irradiance at what each pixel sees; w: whether anything is known.
    std::vector<glm::vec4> step() {
        next.view = view_.film().view;
        view_.prepare(stage_.frame);
        stage_.scene_gpu.finish(stage_.frame);
        passes::update_cache(stage_.frame, stage_.scene_gpu, way_, cache, next);
        ++next.frame_index;
        return look(cache.options().life, 0);
    }
    // Only looks, from another camera at the same cells.
    std::vector<glm::vec4> look_from(const std::string& camera, uint32_t life) {
        View own = make_view(camera);
        std::swap(own, view_);
        view_.prepare(stage_.frame);
        std::vector<glm::vec4> found = look(life, 0);
        std::swap(own, view_);
        return found;
    }
    std::vector<glm::vec4> brute_force(uint32_t samples) {
        view_.prepare(stage_.frame);
        stage_.scene_gpu.finish(stage_.frame);
        return look(0, samples);
    }
    // The mean of what `frames` further frames say, pixel by pixel; w: the share of them that knew something.
    std::vector<glm::vec4> average(uint32_t frames) {
        std::vector<glm::vec4> sum = step();
        for (uint32_t i = 1; i < frames; ++i) {
            const std::vector<glm::vec4> found = step();
            for (size_t p = 0; p < sum.size(); ++p) sum[p] += found[p];
        }
        for (glm::vec4& p : sum) p = glm::vec4(glm::vec3(p) / std::max(p.w, 1.0f), p.w / float(frames));
        return sum;
    }

    LightCache cache;
    passes::CacheFrame next{.frame_index = 1, .exposure = 0.25f};

private:
    View make_view(const std::string& name) {
        ViewDesc desc{.width = size_, .height = size_, .filter = PixelFilter::Point, .roulette_start = 4};
        const Camera* chosen = nullptr;
        for (const auto& entry : stage_.scene.cameras())
            if (!chosen || entry.value.name == name) chosen = &entry.value;
        desc.camera = shader_camera(view_of(*chosen, 1.0f), 1.0f);
        return {stage_.frame.device(), desc};
    }
    std::vector<glm::vec4> look(uint32_t life, uint32_t samples) {
        struct Push {
            uint64_t view, found, cache;
            uint32_t frame_index, life, samples;
            float footprint;
        };
        const gpu::Buffer found(stage_.frame.device(), "test/found", uint64_t{size_} * size_ * sizeof(glm::vec4));
        stage_.frame.trace("device/cache_probe", way_)
            .scene(stage_.scene_gpu.binding())
            .read("view", view_.film().view)
            .write("found", found)
            .read_write("cache", cache.buffer())
            .push(Push{.frame_index = next.frame_index, .life = life, .samples = samples, .footprint = footprint_})
            .over(size_, size_);
        const gpu::Buffer copy = stage_.frame.read_back(found);
        stage_.frame.run();
        const auto all = copy.mapped_as<glm::vec4>();
        return {all.begin(), all.end()};
    }

    Stage& stage_;
    gpu::TraceWay way_;
    float footprint_;
    uint32_t size_;
    View view_;
};

class WorldCache : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    }
    static double luminance(glm::vec4 v) { return 0.2126 * v.x + 0.7152 * v.y + 0.0722 * v.z; }
    // Mean over pixels that know something.
    static double mean(const std::vector<glm::vec4>& found) {
        double sum = 0;
        size_t count = 0;
        for (const glm::vec4& p : found)
            if (p.w > 0) sum += luminance(p), ++count;
        return count ? sum / double(count) : 0;
    }
    // The mean over what is seen, after `frames` frames, in each of so many runs with seeds of their own: pixels of one run share cells.
    static std::vector<double> run_means(Stage& stage, gpu::TraceWay way, float footprint, int runs, int frames, uint32_t size = 16) {
        std::vector<double> out;
        for (int run = 0; run < runs; ++run) {
            Watcher watcher(stage, way, small(), footprint, size);
            watcher.next.seed = uint32_t(run) * 1000u + 1u;
            for (int frame = 0; frame < frames; ++frame) watcher.step();
            out.push_back(mean(watcher.average(8)));
        }
        return out;
    }
    static CacheOptions small() { return {.cells = 1u << 15}; }
};

// A convex body in constant light of 0.5 nits: pi / 2 everywhere, whatever it reflects.
TEST_F(WorldCache, a_sphere_in_constant_light_has_the_irradiance_that_it_must) {
    for (const gpu::TraceWay way : kWays)
        if (device()->caps().supports(way)) expect_mean(run_means(builtin_stage("builtin:furnace"), way, 1.0f, 6, 16), kPi / 2, 0.02, std::string(gpu::trace_way_name(way)));
}

// A closed room of albedo a whose walls emit e: pi e / (1 - a), by way of the cache alone beyond the first bounces.
TEST_F(WorldCache, a_closed_room_that_glows_comes_to_the_sum_of_all_bounces) {
    expect_mean(run_means(builtin_stage("builtin:diffuse-box"), gpu::TraceWay::Compute, 1.0f, 6, 40), kPi, 0.02, "a = 0.5, e = 0.5");
}

// Budget of the cache: 3 % in the mean, judged on the upper 99 % bound; the truth's own error is stated by runs of it.
TEST_F(WorldCache, the_cornell_box_agrees_with_paths_that_do_not_use_it) {
    Stage& stage = builtin_stage("builtin:cornell");
    Watcher teller(stage, gpu::TraceWay::Compute, small(), 0.5f);
    std::vector<double> truths;
    for (int run = 0; run < 12; ++run, ++teller.next.frame_index) truths.push_back(mean(teller.brute_force(64)));
    const Moments truth = moments(truths), found = moments(run_means(stage, gpu::TraceWay::Compute, 0.5f, 8, 40));
    EXPECT_LE(truth.standard_error() / truth.mean, 0.0075) << "a quarter of the margin";
    const double ratio = found.mean / truth.mean, error = std::hypot(found.standard_error(), truth.standard_error()) / truth.mean;
    EXPECT_LE(std::abs(ratio - 1.0) + t_quantile(0.99, 7.0) * error, 0.03) << ratio;
}

TEST_F(WorldCache, cells_at_rest_know_what_is_asked_and_cost_two_to_three_rays_an_update) {
    Stage& stage = builtin_stage("builtin:diffuse-box");
    Watcher watcher(stage, gpu::TraceWay::Compute, small(), 1.0f);
    for (int frame = 0; frame < 40; ++frame) watcher.step();
    double known = 0;
    const std::vector<glm::vec4> found = watcher.average(8);
    for (const glm::vec4& p : found) known += p.w / double(found.size());
    EXPECT_GE(known, 0.99) << "look-ups vary, so some meet a cell that is only now born";
    const CacheStats stats = watcher.cache.read_stats(stage.frame);
    EXPECT_EQ(stats.refused, 0u);
    EXPECT_LE(double(stats.path_rays + stats.shadow_rays) / stats.updated, 3.0);
}

// The inside of the dark boxes while the room around them is lit and looked at: brighter than a thousandth of it nowhere, in no frame.
TEST_F(WorldCache, nothing_leaks_into_a_box_with_walls_of_a_centimetre) {
    Stage& stage = builtin_stage("builtin:leak-box");
    for (const float footprint : {0.5f, 2.0f}) {
        Watcher watcher(stage, gpu::TraceWay::Compute, {.cells = 1u << 15}, footprint, 16, "outside");
        double outside = 0, inside = 0;
        for (int frame = 0; frame < 48; ++frame) {
            outside = std::max(outside, mean(watcher.step()));
            for (const char* camera : {"inside 1 cm", "inside 5 cm"})
                for (const glm::vec4& p : watcher.look_from(camera, watcher.cache.options().life)) inside = std::max(inside, luminance(p));
        }
        EXPECT_GT(outside, 10.0);
        EXPECT_LE(inside, 1e-3 * outside) << footprint;
    }
}

// Cells that know a room with one lamp for 24 frames.
struct LampWatcher {
    LampWatcher() {
        for (int frame = 0; frame < 24; ++frame) watcher.step();
    }
    void turn(bool on) { stage.step(loaded.scripted_edits[0].apply(stage.scene, on ? 0.0 : 1.5)); }
    LoadedScene loaded = make_builtin("builtin:leak-box");
    Stage stage{std::move(loaded.scene)};
    Watcher watcher{stage, gpu::TraceWay::Compute, {.cells = 1u << 15}, 1.0f, 16, "outside"};
};

// A lamp goes out: what is left of its light in the mean.
TEST_F(WorldCache, a_lamp_that_goes_out_is_forgotten_in_a_few_frames) {
    LampWatcher lamp;
    Watcher& watcher = lamp.watcher;
    const double before = mean(watcher.step());
    lamp.turn(false);
    watcher.next.lights_changed = true;
    std::vector<double> left;
    for (int frame = 0; frame < 24; ++frame) {
        left.push_back(mean(watcher.step()) / before);
        watcher.next.lights_changed = false;
    }
    EXPECT_LE(left[7], 0.10);
    EXPECT_LE(left[23], 0.01);
    // And comes on again.
    lamp.turn(true);
    watcher.next.lights_changed = true;
    double now = 0;
    for (int frame = 0; frame < 16; ++frame) {
        now = mean(watcher.step());
        watcher.next.lights_changed = false;
    }
    EXPECT_NEAR(now / before, 1.0, 0.1);
}

// Told that it was switched, cells begin anew: with the frame itself nothing is left, and when it comes on again nearly all is there.
TEST_F(WorldCache, a_lamp_that_is_switched_is_gone_or_there_in_the_same_frame) {
    LampWatcher lamp;
    Watcher& watcher = lamp.watcher;
    const double before = mean(watcher.step());
    lamp.turn(false);
    watcher.next.lights_changed = watcher.next.lights_switched = true;
    EXPECT_LE(mean(watcher.step()) / before, 0.01);
    watcher.next.lights_changed = watcher.next.lights_switched = false;
    for (uint32_t frame = 0; frame < watcher.cache.options().change_frames; ++frame) watcher.step();  // it happens no more often
    lamp.turn(true);
    watcher.next.lights_changed = watcher.next.lights_switched = true;
    EXPECT_NEAR(mean(watcher.step()) / before, 1.0, 0.15);
}

// Light that comes by way of a mirror: a ground beside a silver wall under a plain sky has what an open ground has, but for what silver swallows.
TEST_F(WorldCache, what_metals_send_on_is_neither_lost_nor_made_diffuse) {
    const auto make = [](bool wall) {
        SceneEdit edit;
        Primitive ground;
        add_quad(ground, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
        builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(0.3f))));
        if (wall) {
            Material silver = builtin::lambert("silver", glm::vec3(1.0f));
            silver.metallic = 1.0f;
            silver.specular = 1.0f;
            silver.roughness = 0.0f;
            silver.double_sided = true;
            Primitive mirror;
            add_quad(mirror, {-20.0f, 0.0f, -0.5f}, {40.0f, 0.0f, 0.0f}, {0.0f, 20.0f, 0.0f});
            builtin::add_object(edit, "mirror", std::move(mirror), edit.add(silver));
        }
        edit.set_environment(Environment{.scale = glm::vec3(1.0f)});
        builtin::add_camera(edit, "above", {0.0f, 0.6f, 0.6f}, {0.0f, 0.0f, 0.1f}, glm::radians(40.0f));
        return make_scene(std::move(edit));
    };
    for (const bool wall : {false, true}) {
        Stage stage(make(wall));
        const std::vector<double> means = run_means(stage, gpu::TraceWay::Compute, 0.5f, 16, 24);
        expect_mean(means, kPi, 0.03, wall ? "beside a mirror" : "alone");
    }
}

TEST_F(WorldCache, the_same_frames_give_the_same_bits_with_and_without_full_barriers) {
    std::vector<std::vector<glm::vec4>> runs;
    for (const bool full_barriers : {false, false, true}) {
        Stage stage(make_builtin("builtin:cornell").scene, {}, {.full_barriers = full_barriers});
        Watcher watcher(stage, gpu::TraceWay::Compute, {.cells = 1u << 11}, 0.25f);
        for (int frame = 0; frame < 7; ++frame) watcher.step();
        runs.push_back(watcher.step());
        EXPECT_TRUE(stage.frame.complaints().empty());
    }
    EXPECT_EQ(runs[0], runs[1]);
    EXPECT_EQ(runs[0], runs[2]);
}

}  // namespace
}  // namespace parhelion::testing::world_cache_test
