// What moves, as reconstructed frames show it: what things leave behind, what comes into sight, the first frames after a cut, and stillness.
// FLIP is that of the whole picture, averaged over the pixels that a row is about.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "image/flip.h"
#include "scene/builtin/scenes.h"
#include "scene/builtin/textures.h"
#include "scene/shapes.h"
#include "truth/sequence.h"

namespace parhelion::testing::reconstruction_motion_test {
namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();

uint32_t reference_samples(bool noisy) { return truth_effort() * by_size(noisy ? 4096u : 2048u, 512u); }

RealtimeOptions builtin_options(const TruthStage& on) {
    RealtimeOptions options = truth_options(on, true);
    options.reconstruction = ReconstructionOptions();
    return options;
}

const TruthScene& scene_named(std::string_view name) {
    return *std::ranges::find_if(truth_scenes(), [&](const TruthScene& scene) { return scene.name == name; });
}

std::vector<float> flip_map(const image::ImageF& picture, const image::ImageF& truth) {
    return image::flip_hdr(image::rgb_planes(truth), image::rgb_planes(picture), picture.width, picture.height).map;
}

// The mean over chosen pixels of several pictures.
struct MaskedMean {
    double sum = 0;
    size_t count = 0;

    template <class Chosen>
    void add(const std::vector<float>& map, const Chosen& chosen) {
        for (size_t p = 0; p < map.size(); ++p)
            if (chosen(p)) sum += static_cast<double>(map[p]), ++count;
    }
    double value() const { return sum / static_cast<double>(count); }  // NaN, which fails, if there are none
};

void tell(const char* test, const char* scene, const std::string& what, double value, double least, double most, uint32_t frames, const std::string& note) {
    report({.test = test, .scene = scene, .what = what, .value = value, .low = value, .high = value, .least = least, .most = most, .runs = 1, .frames = frames, .note = note});
}

// ---- what a thing leaves behind ----

constexpr float kBallRadius = 0.25f;
constexpr glm::vec3 kBallPath(0.0f, 1.45f, 0.3f);  // above the boxes

// The box with a chequered ball, which moves along x.
struct BallInBox {
    TruthStage on;
    Handle<Node> ball;

    std::function<ChangeSet(Scene&, uint32_t)> moving(const std::function<float(uint32_t frame)>& x) const {
        return [node = ball, x](Scene& scene, uint32_t frame) {
            SceneEdit step;
            step.set_transform(node, {.translation = kBallPath + glm::vec3(x(frame), 0.0f, 0.0f)});
            return scene.apply(std::move(step));
        };
    }
    // Whether the ray through a pixel's middle comes as near to the ball, at `x`, as `radius` metres from its middle.
    bool covers(float x, size_t pixel, uint32_t size, float radius = kBallRadius) const {
        const glm::vec2 extents = on.camera.image_half_extents(1.0f), film(static_cast<float>(pixel % size) + 0.5f, static_cast<float>(pixel / size) + 0.5f);
        const glm::vec2 at = (2.0f * film / static_cast<float>(size) - 1.0f) * extents;
        const glm::vec3 ray = glm::normalize(on.camera.forward + at.x * on.camera.right - at.y * on.camera.up), to = kBallPath + glm::vec3(x, 0.0f, 0.0f) - on.camera.position;
        return glm::length(to - glm::dot(to, ray) * ray) < radius;
    }
};

// The picture with these pixels of another.
template <class Chosen>
image::ImageF with_pixels_of(image::ImageF picture, const image::ImageF& other, const Chosen& chosen) {
    for (size_t c = 0; c < 3; ++c)
        for (size_t p = 0; p < picture.pixel_count(); ++p)
            if (chosen(p)) picture.plane(c)[p] = other.plane(c)[p];
    return picture;
}

BallInBox make_ball_in_box() {
    LoadedScene loaded = make_builtin("builtin:cornell");
    const CameraView camera = view_of((*loaded.scene.cameras().begin()).value, 1.0f);
    SceneEdit edit;
    Material material = builtin::lambert("chequered", glm::vec3(1.0f));
    material.base_color_texture = builtin::add_texture(edit, builtin::make_image("chequers", 64, 32, [](float u, float v) {
        return static_cast<int>(u * 16.0f + 1.0f) % 2 == static_cast<int>(v * 8.0f) % 2 ? glm::vec4(0.9f, 0.8f, 0.2f, 1.0f) : glm::vec4(0.1f, 0.15f, 0.5f, 1.0f);
    }), ColorSpace::Srgb);
    const Handle<Node> ball = builtin::place_object(edit, "ball", make_sphere(kBallRadius, 24, true), edit.add(std::move(material)), {.translation = kBallPath});
    const ChangeSet changes = loaded.scene.apply(std::move(edit));
    return {set_up(std::move(loaded), camera), changes.resolve(ball)};
}

using ReconstructionMotion = TruthTest;

// Two frames behind: what the ball covered two frames ago, and neither in the last frame nor now. The same pixels where the ball has stood at
// its place all the time are what that is compared with, so one reference serves both; the ball itself is the reference's, lest its own
// error reach over (FLIP looks some pixels around). The other row tells how much is due to the pixels being new: beside a run that forgot
// everything when the ball left them.
TEST_F(ReconstructionMotion, what_a_ball_has_just_left_looks_as_if_it_had_not_been_there) {
    BallInBox box = make_ball_in_box();
    TruthStage& on = box.on;
    const uint32_t size = picture_size(), last = by_size(40u, 20u);
    const float metres_a_pixel = 2.0f * (on.camera.position.z - kBallPath.z) * on.camera.image_half_extents(1.0f).y / static_cast<float>(size);
    std::map<float, MaskedMean> moving, still, young;
    const std::vector<float> places = small_truth() ? std::vector{0.5f} : std::vector{0.3f, 0.5f, 0.7f};
    const std::vector<float> speeds = small_truth() ? std::vector{2.0f, 4.0f, 12.0f} : std::vector{8.0f, 32.0f, 96.0f};
    for (const float place : places) {
        const auto ball = [&](size_t p) { return box.covers(place, p, size, kBallRadius + 1.5f * metres_a_pixel); };
        const auto map_of = [&](const image::ImageF& picture, const image::ImageF& truth) { return flip_map(with_pixels_of(picture, truth, ball), truth); };
        const std::string name = fmt::format("cornell.ball{}", place);
        std::vector<SequenceRun> stands{{"still", builtin_options(on)}};
        std::vector<float> still_map;
        image::ImageF truth;
        const std::vector<uint32_t> looks{last};
        play(on, {.name = name, .change = box.moving([&](uint32_t) { return place; }), .looks = looks, .references = looks, .samples = reference_samples(false)}, size, stands,
             [&](const SequenceFrame& frame) {
            truth = frame.reference;
            still_map = map_of(stands[0].picture, truth);
        });
        for (const float speed : speeds) {
            const auto x = [&](uint32_t frame) { return std::max(place - speed * metres_a_pixel * static_cast<float>(last - frame), -3.0f); };
            const auto left = [&](size_t p) { return box.covers(x(last - 2), p, size) && !box.covers(x(last - 1), p, size) && !ball(p); };
            std::vector<SequenceRun> moves{{"moving", builtin_options(on)}, {.name = "young", .options = builtin_options(on), .cut_at = last - 1}};
            play(on, {.name = fmt::format("{}.{}px", name, speed), .change = box.moving(x), .looks = looks}, size, moves, [&](const SequenceFrame&) {
                moving[speed].add(map_of(moves[0].picture, truth), left);
                young[speed].add(map_of(moves[1].picture, truth), left);
                still[speed].add(still_map, left);
            });
        }
    }
    for (const float speed : speeds) {
        const std::string note = fmt::format("{} pixels; FLIP {:.4f}, still {:.4f}, without history {:.4f}", moving[speed].count, moving[speed].value(), still[speed].value(), young[speed].value());
        tell("ghost", "cornell, ball", fmt::format("{} px: FLIP over still's", speed), moving[speed].value() / still[speed].value(), 0, by_size(1.15, 1.5), 1, note);
        tell("ghost", "cornell, ball", fmt::format("{} px: without history's", speed), moving[speed].value() / young[speed].value(), 0, kAny, 1, note);
    }
}

// ---- what comes into sight ----

class ReconstructionStrafe : public TruthTest, public ::testing::WithParamInterface<const char*> {};

// The camera goes to one side by 8 pixels a frame. `rest` is what has been in sight since it last turned round; the sky, which has no
// noise, is nowhere part of it.
TEST_P(ReconstructionStrafe, what_comes_into_sight_is_soon_as_good_as_the_rest) {
    const TruthScene& scene = scene_named(GetParam());
    if (const std::string why = why_skipped(scene); !why.empty()) {
        report_skip("newly_seen", scene.name, why);
        GTEST_SKIP() << why;
    }
    TruthStage& on = truth_stage(scene);
    const uint32_t size = picture_size();
    SequenceScript script{.name = fmt::format("{}.strafe", scene.name), .looks = std::vector<uint32_t>(by_size(30u, 14u)), .references = {22}, .samples = reference_samples(scene.noisy)};
    std::iota(script.looks.begin(), script.looks.end(), 9);  // it turns round at 8, 24 and 40
    if (!small_truth()) script.references.push_back(38);
    script.camera = [&](uint32_t frame) { return strafing_camera(on, size, by_size(8.0f, 4.0f), frame); };
    std::vector<SequenceRun> runs{{"raw", truth_options(on, true), {"depth", "motion"}}, {"builtin", builtin_options(on)}};
    MaskedMean behind[2], edge[2], rest;  // frames 1 and 6
    image::ImageF before;
    std::vector<InSight> seen;
    play(on, script, size, runs, [&](const SequenceFrame& frame) {
        if (before.width != 0) seen = in_sight(seen, {before, runs[0].picture});
        before = runs[0].picture;
        if (frame.reference.width == 0) return;
        const std::vector<float> map = flip_map(runs[1].picture, frame.reference);
        const auto since = [&](uint32_t frames, bool over_edge) { return [&seen, frames, over_edge](size_t p) { return seen[p].frames == frames && seen[p].over_edge == over_edge; }; };
        for (int i = 0; i < 2; ++i) behind[i].add(map, since(i == 0 ? 1 : 6, false)), edge[i].add(map, since(i == 0 ? 1 : 6, true));
        rest.add(map, [&](size_t p) { return seen[p].frames > 12; });
    });
    const auto row = [&](const char* what, const MaskedMean& part, double most) {
        tell("newly_seen", scene.name, what, part.value() / rest.value(), 0, most, static_cast<uint32_t>(script.references.size()),
             fmt::format("FLIP {:.4f} of {} pixels, the rest {:.4f} of {}", part.value(), part.count, rest.value(), rest.count));
    };
    // A small picture has a dozen such pixels, as noisy as the rest.
    row("behind things, frame 1", behind[0], by_size(2.0, 1.6));
    row("behind things, frame 6", behind[1], by_size(1.2, 1.3));
    if (edge[0].count == 0) return;  // of cornell nothing is beyond the picture
    row("at the edge, frame 1", edge[0], by_size(2.0, 1.6));
    row("at the edge, frame 6", edge[1], by_size(1.2, 1.3));
}
INSTANTIATE_TEST_SUITE_P(Of, ReconstructionStrafe, ::testing::Values("cornell", "diorama", "reflections", "sponza_1000_lights"), [](const auto& entry) { return std::string(entry.param); });

// ---- a cut, and then stillness ----

struct StillCase {
    const char* scene;
    glm::vec3 from, at;  // of the camera before the cut
};
constexpr StillCase kStill[] = {
    {"cornell", {0.7f, 1.5f, 0.8f}, {-0.5f, 0.4f, -0.4f}}, {"spheres", {5.0f, 2.0f, 6.0f}, {0.0f, 0.0f, 0.0f}},         {"diorama", {-0.35f, 0.88f, 0.55f}, {-1.0f, 0.56f, -0.4f}},
    {"reflections", {-4.6f, 1.9f, 4.0f}, {0.2f, 0.5f, -0.4f}}, {"flight_helmet", {0.8f, 0.5f, 0.8f}, {0.0f, 0.3f, 0.0f}}, {"sponza_1000_lights", {6.0f, 3.0f, -0.4f}, {-9.5f, 2.0f, -0.4f}},
};

class ReconstructionStill : public TruthTest, public ::testing::WithParamInterface<StillCase> {};

// The frame with the new camera is frame 1; nobody says that it is a cut. Frames after 16 change by so little as the temporal PSNR says: of
// each against the one before, as displayed.
TEST_P(ReconstructionStill, after_a_cut_frames_are_soon_clean_and_then_stand_still) {
    const TruthScene& scene = scene_named(GetParam().scene);
    if (const std::string why = why_skipped(scene); !why.empty()) {
        report_skip("re-cut", scene.name, why);
        GTEST_SKIP() << why;
    }
    TruthStage& on = truth_stage(scene);
    const uint32_t size = picture_size(), warm_up = by_size(32u, 12u), early = by_size(16u, 8u), frames = by_size(64u, 32u);
    const CameraView elsewhere = look_at(GetParam().from, GetParam().at, on.camera.yfov);
    SequenceScript script{.name = fmt::format("{}.cut", scene.name), .looks = std::vector<uint32_t>(frames), .references = {warm_up}, .samples = reference_samples(scene.noisy)};
    std::iota(script.looks.begin(), script.looks.end(), warm_up);
    script.camera = [&](uint32_t frame) { return frame < warm_up ? elsewhere : on.camera; };
    std::vector<SequenceRun> runs{{"builtin", builtin_options(on)}};
    image::ImageF truth;
    std::vector<float> before;
    std::map<uint32_t, double> flip;  // by frame
    double square_sum = 0;
    play(on, script, size, runs, [&](const SequenceFrame& shown) {
        if (shown.reference.width != 0) truth = shown.reference;
        const uint32_t frame = shown.index - warm_up + 1;
        const image::ImageF& picture = runs[0].picture;
        if (frame == 1 || frame == 8 || frame == early || frame == frames) flip[frame] = flip_of(picture, truth);
        const std::vector<float> now = displayed(picture, on.exposure);
        for (size_t p = 0; p < now.size() && frame > early; ++p) square_sum += static_cast<double>((now[p] - before[p]) * (now[p] - before[p]));
        before = now;
    });
    const double mean_square = square_sum / (static_cast<double>(frames - early) * size * size);
    const auto row = [&](const char* test, const std::string& what, double value, double least, double most, const std::string& note = {}) {
        tell(test, scene.name, what, value, least, most, 1, note);
    };
    row("re-cut", "FLIP of frame 1", flip[1], 0, by_size(0.20, 0.40));
    row("re-cut", "FLIP of frame 8", flip[8], 0, by_size(0.12, 0.30));
    row("still", "temporal PSNR, dB", -10.0 * std::log10(mean_square), by_size(40.0, 30.0), kAny);
    row("still", fmt::format("FLIP of frame {} over {}'s", frames, early), flip[frames] / flip[early], 0, by_size(1.0, 1.1), fmt::format("FLIP {:.4f}, then {:.4f}", flip[early], flip[frames]));
}
INSTANTIATE_TEST_SUITE_P(Of, ReconstructionStill, ::testing::ValuesIn(kStill), [](const auto& entry) { return std::string(entry.param.scene); });

}  // namespace
}  // namespace parhelion::testing::reconstruction_motion_test
