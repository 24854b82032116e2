// Reconstruction of light that is known: pixels are given their signals, so that what comes out can be held against what went in. The last
// tests go through the whole realtime renderer. No test here depends on chance: seeds are fixed, and the limits hold by wide margins.
#include <bit>
#include <cmath>
#include <functional>

#include "image/metrics.h"
#include "renderers/slice.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/film_state.h"
#include "support/realtime_player.h"

namespace parhelion::testing::reconstruction_test {
namespace {

constexpr uint32_t kSize = 48;

// A pixel's signals, and what is known of the surface that they are asked for.
struct Light {
    glm::vec3 diffuse{0.0f}, specular{0.0f}, emission{0.0f};
    float hit = 1.0f;  // metres, of both lobes
};
struct Asked {
    uint32_t frame, x, y, instance;
    float random;  // uniform in (0, 1), of the pixel and frame
    float noise() const { return -std::log(random); }  // with mean and deviation 1
};
using Signal = std::function<Light(const Asked&)>;

uint32_t pack_21(float x) { return (std::bit_cast<uint32_t>(std::max(x, 0.0f)) + (1u << 9)) >> 10; }
shared::PackedLight pack_light(glm::vec3 x) {
    const uint32_t r = pack_21(x.r), g = pack_21(x.g), b = pack_21(x.b);
    return {.low = r | g << 21, .high = g >> 11 | b << 10};
}
float random_of(uint32_t pixel, uint32_t frame) {
    uint32_t h = (pixel * 9781u + frame * 6271u + 1u) * 747796405u + 2891336453u;
    h = ((h >> ((h >> 28) + 4u)) ^ h) * 277803737u;
    return (static_cast<float>((h >> 22 ^ h) >> 9) + 0.5f) / 8388608.0f;
}

// Frames of a scene whose light is given.
class Given {
public:
    Given(Stage& stage, const CameraView& camera, const ReconstructionOptions& options)
        : stage_(stage),
          view(stage.make_view({.view = {.width = kSize, .height = kSize, .filter = PixelFilter::Point}, .camera = camera})),
          gbuffer_(passes::make_gbuffer(stage.frame.device(), {kSize, kSize})),
          signals_(passes::make_signals(stage.frame.device(), kSize * kSize)),
          reconstruction_(stage.frame.device(), {kSize, kSize}, {kSize, kSize}, options) {}

    image::ImageF next(const Signal& signal, bool cut = false) {
        Frame& frame = stage_.frame;
        stage_.step({});
        stage_.scene_gpu.finish(frame);
        view.clear_film();
        view.set_jitter(reconstruction_.jitter_px(index));
        view.prepare(frame);
        passes::trace_identity(frame, stage_.scene_gpu, gpu::TraceWay::Compute, view.film(), gbuffer_, index);
        passes::summarise_surfaces(frame, stage_.scene_gpu, view.film(), gbuffer_, index, exposure);
        const gpu::Buffer ids = frame.read_back(gbuffer_.identity);
        frame.run();
        fill(ids.mapped_as<uint32_t>(), signal);
        reconstruction_.record(frame, {.film = view.film(), .jitter_px = view.jitter(), .gbuffer = gbuffer_, .signals = signals_, .exposure = exposure, .cut = cut}, index);
        end_slice(frame, view, {.first_row = 0, .row_count = kSize, .first_sample = 0, .sample_count = 1}, true);
        frame.run();
        view.end_frame();
        ++index;
        return image::resolve_film(make_film_sums(view.read_film(frame), {kSize, kSize}, {0, 1}, {}));
    }
    image::ImageF play(uint32_t frames, const Signal& signal) {
        image::ImageF last;
        for (uint32_t i = 0; i < frames; ++i) last = next(signal);
        return last;
    }
    void look(const CameraView& camera) { view.set_camera(shader_camera(camera, 1.0f)); }
    std::vector<uint32_t> instances;  // that the last frame's pixels show

private:
    Stage& stage_;

public:
    View view;
    float exposure = 1.0f;
    uint32_t index = 0;

private:
    void fill(std::span<const uint32_t> identity, const Signal& signal) {
        std::vector<shared::PackedLight> diffuse(kSize * kSize), specular(diffuse), emission(diffuse);
        std::vector<uint32_t> hits(kSize * kSize);
        instances.resize(kSize * kSize);
        for (uint32_t p = 0; p < kSize * kSize; ++p) {
            instances[p] = identity[4 * p];
            const Light light = signal({.frame = index, .x = p % kSize, .y = p / kSize, .instance = identity[4 * p], .random = random_of(p, index)});
            diffuse[p] = pack_light(light.diffuse * exposure), specular[p] = pack_light(light.specular * exposure), emission[p] = pack_light(light.emission * exposure);
            hits[p] = glm::packHalf2x16(glm::vec2(light.hit));
        }
        Frame& frame = stage_.frame;
        frame.upload(signals_.diffuse, 0, std::as_bytes(std::span(diffuse)));
        frame.upload(signals_.specular, 0, std::as_bytes(std::span(specular)));
        frame.upload(signals_.emission, 0, std::as_bytes(std::span(emission)));
        frame.upload(signals_.distances, 0, std::as_bytes(std::span(hits)));
    }

    passes::GBuffer gbuffer_;
    passes::Signals signals_;
    Reconstruction reconstruction_;
};

CameraView straight(float x = 0.0f) { return look_at({x, 0.0f, 4.0f}, {x, 0.0f, 0.0f}, glm::radians(40.0f)); }

// A wall that fills the picture, and a board in front of it. Their own colour is white, so that light is what is seen.
Stage make_stage(bool board, bool mirror = false) {
    SceneEdit edit;
    const Handle<Material> white = edit.add(mirror ? builtin::glossy("mirror", glm::vec3(1.0f), 1.0f, 0.05f) : builtin::lambert("white", glm::vec3(1.0f)));
    Primitive wall, front;
    add_quad(wall, {-6, -6, 0}, {12, 0, 0}, {0, 12, 0});
    builtin::add_object(edit, "wall", std::move(wall), white);
    add_quad(front, {-0.4f, -0.5f, 1.0f}, {0.8f, 0, 0}, {0, 1.0f, 0});
    if (board) builtin::add_object(edit, "board", std::move(front), white);
    return Stage(make_scene(std::move(edit)));
}

// The spatial filter and anti-aliasing off: histories are seen as they are.
ReconstructionOptions only_history() {
    ReconstructionOptions options;
    options.steps = 0;
    options.antialias = false;
    return options;
}

double worst_error(const image::ImageF& picture, double expected) {
    double worst = 0;
    for (size_t p = 0; p < picture.pixel_count(); ++p) worst = std::max(worst, std::abs(luminance_of(picture, p) / expected - 1));
    return worst;
}
double rms_error(const image::ImageF& picture, double expected) {
    double sum = 0;
    for (size_t p = 0; p < picture.pixel_count(); ++p) sum += std::pow(luminance_of(picture, p) / expected - 1, 2);
    return std::sqrt(sum / static_cast<double>(picture.pixel_count()));
}

using ReconstructionTest = GpuTest;

TEST_F(ReconstructionTest, even_light_stays_what_it_is_while_the_camera_moves) {
    Stage stage = make_stage(true);
    Given given(stage, straight(), {});
    for (uint32_t i = 0; i < 12; ++i) {
        given.look(straight(0.1f * static_cast<float>(i)));
        const image::ImageF picture = given.next([](const Asked&) { return Light{.diffuse = glm::vec3(3.3f), .emission = glm::vec3(0.37f)}; });
        expect_sane(picture);
        ASSERT_LE(worst_error(picture, 3.67), 0.002) << i;
    }
}

// Without anti-aliasing, which would see a pattern of pixels from elsewhere in every frame.
TEST_F(ReconstructionTest, a_pattern_without_noise_stays_sharp) {
    Stage stage = make_stage(false);
    ReconstructionOptions options;
    options.antialias = false;
    Given given(stage, straight(), options);
    const auto pattern = [](uint32_t x, uint32_t y) { return (x + y) % 2 == 0 ? 1.0f : 0.2f; };
    const image::ImageF picture = given.play(12, [&](const Asked& a) { return Light{.diffuse = glm::vec3(pattern(a.x, a.y))}; });
    std::vector<float> expected(kSize * kSize);
    for (uint32_t p = 0; p < expected.size(); ++p) expected[p] = pattern(p % kSize, p / kSize);
    EXPECT_NEAR(mean_luminance(picture) / 0.6, 1.0, 0.002);
    EXPECT_GE(image::ssim(picture.plane(0), expected, kSize, kSize), 0.99);
}

TEST_F(ReconstructionTest, a_firefly_is_shared_out_and_not_lost) {
    Stage stage = make_stage(false);
    Given given(stage, straight(), only_history());
    const image::ImageF picture = given.next([](const Asked& a) { return Light{.diffuse = glm::vec3(a.x == 20 && a.y == 17 ? 1000.0f : 1.0f)}; });
    double sum = 0, most = 0;
    for (size_t p = 0; p < picture.pixel_count(); ++p) sum += luminance_of(picture, p), most = std::max(most, luminance_of(picture, p));
    EXPECT_NEAR(sum, kSize * kSize + 999.0, 2.0);
    EXPECT_LE(most, 1000.0 / 8);
}

TEST_F(ReconstructionTest, noise_falls_with_frames_and_rises_never_again) {
    Stage stage = make_stage(true);
    Given given(stage, straight(), {});
    const Signal noise = [](const Asked& a) { return Light{.diffuse = glm::vec3(a.noise())}; };
    const double first = rms_error(given.play(1, noise), 1), after_16 = rms_error(given.play(15, noise), 1), after_64 = rms_error(given.play(48, noise), 1);
    EXPECT_LE(first, 0.35);  // the deviation of what comes in is 1
    EXPECT_LE(after_16, 0.1);
    EXPECT_LE(after_64, after_16);
    const image::ImageF last = given.next(noise);
    EXPECT_NEAR(mean_luminance(last), 1.0, 0.03);
}

// Of histories alone, without what the spatial filter adds: tests of change must not take noise for it.
TEST_F(ReconstructionTest, noise_alone_leaves_histories_as_long_as_they_are) {
    Stage stage = make_stage(false);
    ReconstructionOptions with = only_history(), without = only_history();
    without.antilag = without.clamp_width = 0.0f;
    Given one(stage, straight(), with), other(stage, straight(), without);
    const Signal noise = [](const Asked& a) { return Light{.diffuse = glm::vec3(a.noise())}; };
    one.play(39, noise), other.play(39, noise);
    EXPECT_LE(rms_error(one.next(noise), 1), 1.1 * rms_error(other.next(noise), 1));
}

// As that of lights that a tile's pixels choose among together.
TEST_F(ReconstructionTest, noise_that_a_tiles_pixels_share_is_no_change_of_light) {
    Stage stage = make_stage(false);
    ReconstructionOptions with = only_history(), without = only_history();
    without.antilag = with.clamp_width = without.clamp_width = 0.0f;
    Given one(stage, straight(), with), other(stage, straight(), without);
    const Signal noise = [](const Asked& a) { return Light{.diffuse = glm::vec3(Asked{.random = random_of(a.y / 8 * kSize + a.x / 8, a.frame)}.noise())}; };
    one.play(64, noise), other.play(64, noise);
    double error_with = 0, error_without = 0;
    for (uint32_t i = 0; i < 16; ++i) error_with += rms_error(one.next(noise), 1), error_without += rms_error(other.next(noise), 1);
    EXPECT_LE(error_with, 1.1 * error_without);
}

// Light that grows by a twentieth of what it began with in every frame, so that no frame stands out of the noise: by how much of it the mean is behind.
double behind_a_drift(Stage& stage, const ReconstructionOptions& options) {
    Given given(stage, straight(), options);
    const auto light = [](uint32_t frame) { return 1.0f + 0.05f * static_cast<float>(frame); };
    const Signal drifts = [&](const Asked& a) { return Light{.diffuse = glm::vec3(light(a.frame) * a.noise())}; };
    given.play(64, drifts);
    double behind = 0;
    for (uint32_t frame = 64; frame < 80; ++frame) behind += (1 - mean_luminance(given.next(drifts)) / light(frame)) / 16;
    return behind;
}

TEST_F(ReconstructionTest, a_light_that_drifts_is_followed) {
    Stage stage = make_stage(false);
    const double behind = behind_a_drift(stage, {.clamp_width = 0.0f});
    EXPECT_LE(behind, 0.05);
    EXPECT_GE(behind, 0.0);
}

// The picture's history by itself, without the clip that would draw it to the frame: it must not be much further behind.
TEST_F(ReconstructionTest, the_picture_follows_a_light_that_drifts) {
    Stage stage = make_stage(false);
    EXPECT_LE(behind_a_drift(stage, {.clamp_width = 0.0f, .deviations = 1000.0f}), 0.08);
}

// One pixel in sixteen has all the light: no less of it is left after the filter.
TEST_F(ReconstructionTest, uneven_noise_keeps_its_mean_in_the_filter) {
    Stage stage = make_stage(false);
    Given given(stage, straight(), {.history = 1, .fast_history = 1, .firefly = 0.0f, .clamp_width = 0.0f, .antialias = false});
    double light = 0, filtered = 0;
    const Signal rare = [&](const Asked& a) {
        const float of_pixel = a.random < 0.0625f ? 16.0f : 0.0f;
        light += of_pixel / (kSize * kSize);
        return Light{.diffuse = glm::vec3(of_pixel)};
    };
    for (int i = 0; i < 8; ++i) filtered += mean_luminance(given.next(rare));
    EXPECT_NEAR(filtered / light, 1.0, 0.02);
}

// Light that grows along a surface: the filter's neighbours of its darkest column are all brighter. What is left of that is noise not known well enough.
TEST_F(ReconstructionTest, light_that_falls_off_towards_an_edge_is_as_dark_there) {
    Stage stage = make_stage(true);
    Given given(stage, straight(), {.antialias = false});
    uint32_t board = 0, first = kSize, last = 0;
    const auto light = [](uint32_t x) { return 0.2f + 0.1f * static_cast<float>(x); };
    const Signal ramp = [&](const Asked& a) { return Light{.diffuse = glm::vec3(a.instance == board ? light(a.x) * a.noise() : 1.0f)}; };
    given.next(ramp);
    board = given.instances[(kSize / 2) * kSize + kSize / 2];
    for (uint32_t p = 0; p < kSize * kSize; ++p)
        if (given.instances[p] == board) first = std::min(first, p % kSize), last = std::max(last, p % kSize);
    ASSERT_GE(last, first + 12);
    for (int i = 0; i < 64; ++i) given.next(ramp);
    double seen = 0, there = 0;
    for (int i = 0; i < 16; ++i) {
        const image::ImageF picture = given.next(ramp);
        for (uint32_t y = kSize / 2 - 8; y < kSize / 2 + 8; ++y) seen += luminance_of(picture, y * kSize + first), there += static_cast<double>(light(first));
    }
    EXPECT_NEAR(seen / there, 1.0, 0.06);
}

// After 48 frames of one light, of another; what is left of the first in the mean of the picture.
double left_after(Stage& stage, const ReconstructionOptions& options, float before, float after, uint32_t frames) {
    Given given(stage, straight(), options);
    given.play(48, [&](const Asked& a) { return Light{.diffuse = glm::vec3(before * a.noise()), .specular = glm::vec3(before * a.noise())}; });
    const Signal signal = [&](const Asked& a) { return Light{.diffuse = glm::vec3(after * a.noise()), .specular = glm::vec3(after * a.noise())}; };
    const double wanted = after * 1.01;  // a hundredth by the specular signal: the wall has no other lobe
    return (mean_luminance(given.play(frames, signal)) - wanted) / (before * 1.01 - wanted);
}

TEST_F(ReconstructionTest, a_light_that_goes_off_is_gone_after_four_frames_but_for_a_tenth) {
    Stage stage = make_stage(true);
    EXPECT_LE(std::abs(left_after(stage, {}, 1.0f, 0.0f, 4)), 0.1);
    EXPECT_LE(std::abs(left_after(stage, {}, 1.0f, 0.0f, 12)), 0.01);
}
TEST_F(ReconstructionTest, a_light_that_comes_on_is_there_after_four_frames_but_for_a_tenth) {
    Stage stage = make_stage(true);
    EXPECT_LE(std::abs(left_after(stage, {}, 0.1f, 1.0f, 4)), 0.1);
    EXPECT_LE(std::abs(left_after(stage, {}, 0.1f, 1.0f, 16)), 0.03);  // of which the noise of so few frames is most
}
TEST_F(ReconstructionTest, half_a_light_less_is_seen_as_fast) {
    Stage stage = make_stage(true);
    EXPECT_LE(std::abs(left_after(stage, {}, 1.0f, 0.5f, 8)), 0.15);
}

// The board shines, the wall behind it hardly does: of the board's light nothing stays on the wall that it uncovers, in no frame.
TEST_F(ReconstructionTest, what_a_moving_camera_uncovers_has_nothing_of_what_was_in_front) {
    Stage stage = make_stage(true);
    ReconstructionOptions options;
    options.antialias = false;
    Given given(stage, straight(), options);
    uint32_t board = 0;
    for (uint32_t i = 0; i < 24; ++i) {
        given.look(straight(i < 8 ? 0.0f : 0.12f * static_cast<float>(i - 8)));
        if (i == 0) given.next([](const Asked&) { return Light{}; }), board = given.instances[kSize / 2 * kSize + kSize / 2];
        const image::ImageF picture = given.next([&](const Asked& a) { return Light{.diffuse = glm::vec3(a.instance == board ? 100.0f : 1.0f)}; }, i == 0);
        for (size_t p = 0; p < picture.pixel_count(); ++p) ASSERT_NEAR(luminance_of(picture, p) / (given.instances[p] == board ? 100.0 : 1.0), 1.0, 0.005) << "frame " << i << ", pixel " << p;
    }
}

TEST_F(ReconstructionTest, after_a_cut_a_frame_is_the_first_one) {
    Stage stage = make_stage(true);
    Given old(stage, straight(), {}), fresh(stage, straight(0.3f), {});
    old.play(5, [](const Asked& a) { return Light{.diffuse = glm::vec3(50.0f * a.noise())}; });
    old.look(straight(0.3f));
    fresh.index = old.index;
    const Signal signal = [](const Asked& a) { return Light{.diffuse = glm::vec3(a.noise()), .specular = glm::vec3(0.5f)}; };
    EXPECT_EQ(share_bit_equal(old.next(signal, true), fresh.next(signal)), 1.0);
}

TEST_F(ReconstructionTest, a_new_exposure_changes_nothing_in_nits) {
    Stage stage = make_stage(true);
    Given given(stage, straight(), {});
    for (uint32_t i = 0; i < 12; ++i) {
        if (i == 6) given.exposure = 32.0f;
        const image::ImageF picture = given.next([](const Asked&) { return Light{.diffuse = glm::vec3(0.7f), .specular = glm::vec3(10.0f), .emission = glm::vec3(0.2f)}; });
        ASSERT_LE(worst_error(picture, 1.0), 0.002) << i;
    }
}

TEST_F(ReconstructionTest, a_new_exposure_is_no_change_of_light) {
    Stage stage = make_stage(false);
    ReconstructionOptions with = only_history(), without = only_history();
    without.antilag = with.clamp_width = without.clamp_width = 0.0f;
    Given one(stage, straight(), with), other(stage, straight(), without);
    const Signal noise = [](const Asked& a) { return Light{.diffuse = glm::vec3(a.noise())}; };
    one.play(39, noise), other.play(39, noise);
    one.exposure = other.exposure = 32.0f;
    one.play(3, noise), other.play(3, noise);
    EXPECT_LE(rms_error(one.next(noise), 1), 1.1 * rms_error(other.next(noise), 1));
}

// A mirror in front of stripes that lie three metres behind its plane: they go by another way than the wall does.
TEST_F(ReconstructionTest, a_reflection_moves_as_what_it_shows) {
    Stage stage = make_stage(false, true);
    const float hit = 3.0f, half = std::tan(glm::radians(20.0f));
    const auto error = [&](bool virtual_motion) {
        ReconstructionOptions options = only_history();
        options.virtual_motion = virtual_motion;
        options.clamp_width = options.firefly = 0.0f;
        Given given(stage, straight(), options);
        double sum = 0;
        for (uint32_t i = 0; i < 16; ++i) {
            const float x = 0.15f * static_cast<float>(i);
            const auto stripes = [&](uint32_t column) { return 1.0f + 0.5f * std::sin(2.0f * (x + (2.0f * (static_cast<float>(column) + 0.5f) / kSize - 1.0f) * half * (4.0f + hit))); };
            given.look(straight(x));
            const image::ImageF picture = given.next([&](const Asked& a) { return Light{.specular = glm::vec3(stripes(a.x)), .hit = hit}; });
            for (size_t p = 0; i >= 8 && p < picture.pixel_count(); ++p) sum += std::pow(luminance_of(picture, p) - static_cast<double>(stripes(p % kSize)), 2);
        }
        return std::sqrt(sum / (8.0 * kSize * kSize));
    };
    const double by_surface = error(false), by_reflection = error(true);
    EXPECT_LE(by_reflection, 0.08);
    EXPECT_LE(by_reflection, 0.4 * by_surface);
}

// The whole renderer: the same picture with less noise, and the same bits again.
TEST_F(ReconstructionTest, frames_of_the_realtime_renderer_come_out_clean_and_as_bright) {
    if (!LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    Stage& stage = builtin_stage("builtin:cornell");
    const Shot shot{.view = {.width = 48, .height = 48, .seed = 3, .filter = PixelFilter::Point}, .sample_count = 256};
    Shot box = shot;
    box.view.filter = PixelFilter::Box;
    const image::ImageF truth = stage.picture(box);
    const auto frame_16 = [&](std::optional<ReconstructionOptions> reconstruction) {
        Player player(stage, shot, {.exposure = 0.5f, .reconstruction = reconstruction});
        player.skip(15);
        return player.next();
    };
    const image::ImageF clean = frame_16(ReconstructionOptions()), noisy = frame_16({});
    expect_sane(clean);
    const auto error = [&](const image::ImageF& picture) { return image::squared_errors(image::rgb_planes(picture), image::rgb_planes(truth)).relmse; };
    EXPECT_LE(error(clean), 0.1 * error(noisy));
    EXPECT_NEAR(mean_luminance(clean) / mean_luminance(truth), 1.0, 0.05);
}

}  // namespace
}  // namespace parhelion::testing::reconstruction_test
