// Light tiles: what they say of their samples is what these are, so that the choice among them is a good one; who reads which.
#include <cmath>

#include <glm/gtc/matrix_transform.hpp>

#include "passes/lights/lights.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"
#include "support/statistics.h"

namespace parhelion::testing::light_tiles_test {
namespace {

struct Told {
    float light, light_is, pdf, pdf_is, cosine;
    uint32_t kind;
};
constexpr uint32_t kWidth = 64;

struct TileLook {
    std::vector<Told> told;       // of the samples of the first square's tile
    std::vector<uint32_t> read;   // the tile of each pixel of a square picture
};

// Tiles of a picture of few pixels, as a frame draws and reads them.
TileLook look(Stage& stage, uint32_t frame_index, uint32_t seed, glm::vec3 from) {
    struct Push {
        uint64_t tiles, told, read;
        glm::vec3 position_ws;
        uint32_t frame_index, seed, count, width;
    };
    Frame& frame = stage.frame;
    stage.scene_gpu.finish(frame);
    const gpu::Buffer tiles = passes::make_light_tiles(frame.device());
    const gpu::Buffer told(frame.device(), "test/told", shared::kTileSamples * sizeof(Told)), read(frame.device(), "test/read", kWidth * kWidth * sizeof(uint32_t));
    passes::draw_light_tiles(frame, stage.scene_gpu, tiles, frame_index, seed, {8, 8});
    frame.compute("device/light_tiles")
        .scene(stage.scene_gpu.binding())
        .read("tiles", tiles)
        .write("told", told)
        .write("read", read)
        .push(Push{.position_ws = from, .frame_index = frame_index, .seed = seed, .count = shared::kTileSamples, .width = kWidth})
        .over(kWidth * kWidth);
    const gpu::Buffer told_copy = frame.read_back(told), read_copy = frame.read_back(read);
    frame.run();
    const auto a = told_copy.mapped_as<Told>();
    const auto b = read_copy.mapped_as<uint32_t>();
    return {{a.begin(), a.end()}, {b.begin(), b.end()}};
}

class LightTileTest : public GpuTest {};

// Nine bits of a logarithm are within 6 %, a triangle's normal is within a thousandth; triangles that are seen more from the side than
// that are judged as if they were not. What is not nothing is never said to be nothing.
TEST_F(LightTileTest, say_of_each_sample_what_it_brings_how_likely_it_is_and_from_where) {
    for (const char* name : {"builtin:many-lights", "builtin:diorama", "builtin:leak-box", "builtin:furnace"}) {
        SCOPED_TRACE(name);
        for (const glm::vec3 from : {glm::vec3(0.3f, 1.1f, -0.2f), glm::vec3(-0.7f, 0.4f, 0.6f)}) {
            size_t wrong = 0, lost = 0;
            for (const Told& t : look(builtin_stage(name), 7, 3, from).told) {
                if (t.kind == shared::kTileNone || t.light_is <= 0) continue;
                lost += !(t.light > 0);
                const bool delta = t.kind == shared::kTilePoint || t.kind == shared::kTileDeltaInfinite;
                wrong += !(t.cosine > 0.9999f) || !(std::abs(t.light / t.light_is - 1) < 0.07f) || (!delta && !(std::abs(t.pdf / t.pdf_is - 1) < 0.01f));
            }
            EXPECT_EQ(lost, 0u);
            EXPECT_LE(wrong, 4u);
        }
    }
}

// In the frame in which a ball moves far away.
TEST_F(LightTileTest, say_where_a_lamp_is_now) {
    SceneEdit edit;
    const Handle<Node> pending = builtin::place_object(edit, "ball", make_sphere(0.2f, 6, true), edit.add(builtin::lambert("ball", glm::vec3(0.5f), glm::vec3(20.0f))));
    Scene scene;
    const Handle<Node> ball = scene.apply(std::move(edit)).resolve(pending);
    Stage stage(std::move(scene));
    for (int frame = 0; frame < 3; ++frame) {
        SceneEdit step;
        step.set_transform(ball, {.translation = {3.0f * float(frame), 1.0f, 0.0f}});
        stage.step(std::move(step));
        size_t wrong = 0, seen = 0;
        for (const Told& t : look(stage, 2, 1, {0.0f, 0.0f, 4.0f}).told)
            if (t.light_is > 0) ++seen, wrong += !(t.cosine > 0.9999f);
        EXPECT_GT(seen, 100u);
        EXPECT_EQ(wrong, 0u) << frame;
    }
}

// Ten thousand lamps, enumerated: what the samples say of how likely their light was adds up to one over all lights, is in proportion to
// what each emits, and is how often it comes. A hundred groups of lights come within 2 % (of 42,000 and more samples each: 4 standard
// errors), each light by itself as a chi-square test of all together sees it (false alarms: 1e-4), and none never.
TEST_F(LightTileTest, draw_each_of_ten_thousand_lights_as_often_as_they_say) {
    constexpr uint32_t kLights = 10000, kFrames = 32, kGroups = 100;
    SceneEdit edit;
    std::vector<double> share;
    double total = 0;
    for (uint32_t i = 0; i < kLights; ++i) {
        share.push_back(1.0 + double(i * 7 % 9));
        total += share.back();
        edit.add(Light{.kind = LightKind::Point, .intensity = float(share.back()), .place = {.node_from_object = glm::translate(glm::mat4(1.0f), glm::vec3(i % 100, 2.0f, i / 100))}});
    }
    for (double& s : share) s /= total;
    Stage stage(make_scene(std::move(edit)), {.hardware = false});
    stage.scene_gpu.finish(stage.frame);
    const gpu::Buffer tiles = passes::make_light_tiles(stage.frame.device());
    std::vector<double> counts(kLights), expected(kLights), told(kLights), group_counts(kGroups), group_expected(kGroups);
    double samples = 0;
    for (uint32_t index = 0; index < kFrames; ++index) {
        passes::draw_light_tiles(stage.frame, stage.scene_gpu, tiles, index, 9, {640, 480});
        const gpu::Buffer copy = stage.frame.read_back(tiles);
        stage.frame.run();
        for (const shared::TileSample& sample : copy.mapped_as<shared::TileSample>()) {
            ASSERT_LT(sample.emitter, kLights);
            counts[sample.emitter] += 1;
            told[sample.emitter] = 1.0 / double(sample.inverse_pdf);
            samples += 1;
        }
    }
    EXPECT_EQ(samples, double(kFrames) * shared::kTileCount * shared::kTileSamples);
    double sum = 0;
    for (uint32_t i = 0; i < kLights; ++i) {
        ASSERT_GT(counts[i], 0.0) << "light " << i << " is never drawn";
        ASSERT_NEAR(told[i], share[i], 1e-4 * share[i]);
        sum += told[i];
        expected[i] = samples * told[i];
        group_counts[i / (kLights / kGroups)] += counts[i];
        group_expected[i / (kLights / kGroups)] += expected[i];
    }
    EXPECT_NEAR(sum, 1.0, 1e-4);
    for (uint32_t g = 0; g < kGroups; ++g) EXPECT_NEAR(group_counts[g] / group_expected[g], 1.0, 0.02) << g;
    EXPECT_GT(chi_square_test(counts, expected).p, 1e-4);
}

// 64 squares of a frame, in 64 frames: each of the 128 tiles as often as any (false alarms: 1e-4), and not the same from frame to frame.
TEST_F(LightTileTest, are_read_by_whole_squares_of_pixels_another_one_in_each_frame) {
    Stage& stage = builtin_stage("builtin:furnace");
    std::vector<double> counts(shared::kTileCount), expected(shared::kTileCount);
    std::vector<uint32_t> before;
    size_t same = 0, all = 0;
    for (uint32_t frame = 0; frame < 64; ++frame) {
        const std::vector<uint32_t> read = look(stage, frame, 5, glm::vec3(0.0f)).read;
        for (uint32_t p = 0; p < read.size(); ++p) {
            const uint32_t x = p % kWidth, y = p / kWidth;
            ASSERT_EQ(read[p], read[(y / 8 * 8) * kWidth + x / 8 * 8]);
            ASSERT_LT(read[p], shared::kTileCount);
            if (x % 8 != 0 || y % 8 != 0) continue;
            counts[read[p]] += 1;
            ++all;
            if (!before.empty()) same += before[p] == read[p];
        }
        before = read;
    }
    for (double& e : expected) e = double(all) / shared::kTileCount;
    EXPECT_GT(chi_square_test(counts, expected).p, 1e-4);
    EXPECT_LE(same, binomial_quantile(0.9999, all, 1.0 / shared::kTileCount));
}

}  // namespace
}  // namespace parhelion::testing::light_tiles_test
