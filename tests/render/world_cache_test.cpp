// What the world cache says of real light, against closed forms and against paths without it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "passes/cache/cache.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/scene_setup.h"
#include "support/render_fixture.h"

namespace parhelion::testing {
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
    static std::vector<double> known_values(const std::vector<glm::vec4>& found) {
        std::vector<double> out;
        for (const glm::vec4& p : found)
            if (p.w > 0.5f) out.push_back(luminance(p));
        return out;
    }
    static CacheOptions small() { return {.cells = 1u << 15}; }
};

// A convex body in constant light of 0.5 nits: pi / 2 everywhere, whatever it reflects. False alarms: five standard errors.
TEST_F(WorldCache, a_sphere_in_constant_light_has_the_irradiance_that_it_must) {
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        Watcher watcher(builtin_stage("builtin:furnace"), way, small(), 0.5f);
        for (int frame = 0; frame < 24; ++frame) watcher.step();
        expect_mean(known_values(watcher.average(8)), kPi / 2, 0.03, std::string(gpu::trace_way_name(way)));
    }
}

// A closed room of albedo a whose walls emit e: pi e / (1 - a), by way of the cache alone beyond the first bounces.
TEST_F(WorldCache, a_closed_room_that_glows_comes_to_the_sum_of_all_bounces) {
    Watcher watcher(builtin_stage("builtin:diffuse-box"), gpu::TraceWay::Compute, small(), 1.0f);
    for (int frame = 0; frame < 56; ++frame) watcher.step();
    expect_mean(known_values(watcher.average(8)), kPi, 0.03, "a = 0.5, e = 0.5");
}

// A lamp goes out: what is left of its light in the mean.
TEST_F(WorldCache, a_lamp_that_goes_out_is_forgotten_in_a_few_frames) {
    LoadedScene loaded = make_builtin("builtin:leak-box");
    Stage stage(std::move(loaded.scene));
    Watcher watcher(stage, gpu::TraceWay::Compute, {.cells = 1u << 15}, 1.0f, 16, "outside");
    for (int frame = 0; frame < 24; ++frame) watcher.step();
    const double before = mean(watcher.step());
    stage.step(loaded.scripted_edits[0].apply(stage.scene, 1.5));
    watcher.next.lights_changed = true;
    std::vector<double> left;
    for (int frame = 0; frame < 24; ++frame) {
        left.push_back(mean(watcher.step()) / before);
        watcher.next.lights_changed = false;
    }
    EXPECT_LE(left[7], 0.10);
    EXPECT_LE(left[23], 0.01);
    // And comes on again.
    stage.step(loaded.scripted_edits[0].apply(stage.scene, 0.0));
    watcher.next.lights_changed = true;
    double now = 0;
    for (int frame = 0; frame < 16; ++frame) {
        now = mean(watcher.step());
        watcher.next.lights_changed = false;
    }
    EXPECT_NEAR(now / before, 1.0, 0.1);
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
}  // namespace parhelion::testing
