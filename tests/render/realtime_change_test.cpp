// Lights and things that come and go, through the whole realtime renderer with its cache: what is left of the light that was, in the
// mean of several runs. Two runs that differ only in what happened draw the same random numbers, so what is left stands out of the noise.
#include <array>
#include <cmath>
#include <functional>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/realtime_player.h"
#include "support/statistics.h"

namespace parhelion::testing {
namespace {

// A room of 4 x 3 x 4 metres with a door, into which the sun shines. Everything is dark until something is switched on.
struct Room {
    Scene scene;
    Handle<Light> lamp, sun;
    Handle<Material> panel;
    Handle<Node> ball, screen;

    Room() {
        SceneEdit edit;
        const Handle<Material> white = edit.add(builtin::lambert("white", glm::vec3(0.7f)));
        Primitive walls;
        add_quad(walls, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4});
        add_quad(walls, {-2, 3, -2}, {4, 0, 0}, {0, 0, 4});
        add_quad(walls, {-2, 0, -2}, {4, 0, 0}, {0, 3, 0});
        add_quad(walls, {2, 0, 2}, {-4, 0, 0}, {0, 3, 0});
        add_quad(walls, {-2, 0, 2}, {0, 0, -4}, {0, 3, 0});
        // The door is one metre wide and two high.
        add_quad(walls, {2, 0, -2}, {0, 0, 1.5f}, {0, 3, 0});
        add_quad(walls, {2, 0, 0.5f}, {0, 0, 1.5f}, {0, 3, 0});
        add_quad(walls, {2, 2, -0.5f}, {0, 0, 1}, {0, 1, 0});
        builtin::add_object(edit, "walls", std::move(walls), white);
        Primitive square, slab;
        add_quad(square, {-0.4f, 2.99f, -0.4f}, {0.8f, 0, 0}, {0, 0, 0.8f});
        panel = edit.add(builtin::lambert("panel", glm::vec3(0.5f)));
        builtin::add_object(edit, "panel", std::move(square), panel);
        ball = builtin::place_object(edit, "ball", make_sphere(0.2f, 8, true), edit.add(builtin::lambert("ball", glm::vec3(0.5f), glm::vec3(20.0f))), kAway);
        add_box(slab, {-0.8f, -0.02f, -0.8f}, {0.8f, 0.02f, 0.8f});
        screen = builtin::place_object(edit, "screen", std::move(slab), white, kAway);
        lamp = edit.add(lamp_of(0.0f));
        sun = edit.add(sun_of(0.0f));
        builtin::add_camera(edit, "inside", {-1.7f, 1.6f, 1.7f}, {0.5f, 0.9f, -1.0f}, 1.0f);
        const ChangeSet changes = scene.apply(std::move(edit));
        lamp = changes.resolve(lamp), sun = changes.resolve(sun), panel = changes.resolve(panel), ball = changes.resolve(ball), screen = changes.resolve(screen);
    }
    static Light lamp_of(float candela, glm::vec3 at = {0.3f, 2.6f, 0.2f}) {
        return {.kind = LightKind::Point, .intensity = candela, .place = {.node_from_object = glm::translate(glm::mat4(1.0f), at)}};
    }
    static Light sun_of(float lux) {
        return {.kind = LightKind::Directional, .intensity = lux, .angular_radius = 0.005f, .place = {.node_from_object = builtin::place_looking({1, 0.6f, 0.1f}, glm::vec3(0.0f))}};
    }
    static inline const Transform kAway{.translation = {0.0f, 500.0f, 0.0f}};
};

// Something that is so or otherwise: `so` is the state with more light.
struct Change {
    const char* name;
    std::function<void(const Room&, SceneEdit&, bool so)> put;
};
const Change kChanges[] = {
    {"a lamp", [](const Room& room, SceneEdit& edit, bool so) { edit.set_light(room.lamp, Room::lamp_of(so ? 10.0f : 0.0f)); }},
    {"the sun", [](const Room& room, SceneEdit& edit, bool so) { edit.set_light(room.sun, Room::sun_of(so ? 50.0f : 0.0f)); }},
    {"a mesh that glows",
     [](const Room& room, SceneEdit& edit, bool so) { edit.set_material(room.panel, builtin::lambert("panel", glm::vec3(0.5f), glm::vec3(so ? 10.0f : 0.0f))); }},
    {"a ball that glows", [](const Room& room, SceneEdit& edit, bool so) { edit.set_transform(room.ball, so ? Transform{.translation = {0.8f, 1.2f, -0.8f}} : Room::kAway); }},
    {"a screen below the lamp",
     [](const Room& room, SceneEdit& edit, bool so) {
         edit.set_light(room.lamp, Room::lamp_of(10.0f));
         edit.set_transform(room.screen, so ? Room::kAway : Transform{.translation = {0.3f, 2.2f, 0.2f}});
     }},
};

constexpr uint32_t kWarm = 24, kRuns = 6;
constexpr uint32_t kLook[] = {8, 24};  // frames after the change

class RealtimeChange : public GpuTest, public ::testing::WithParamInterface<size_t> {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    }
    static RealtimeOptions small() { return {.cache_options = {.cells = 1u << 13}}; }
    static Shot shot(uint32_t seed) { return {.view = {.width = 16, .height = 16, .seed = seed, .filter = PixelFilter::Point}}; }
    static SceneEdit edit_of(const Change& change, const Room& room, bool so) {
        SceneEdit edit;
        change.put(room, edit, so);
        return edit;
    }
};

TEST_P(RealtimeChange, is_in_the_picture_in_a_few_frames) {
    const Change& change = kChanges[GetParam()];
    Room room;
    Stage stage(room.scene);
    // The means at kLook of a run that begins so and ends otherwise.
    const auto play = [&](uint32_t seed, bool first, bool then) {
        Player player(stage, shot(seed), small());
        player.next(edit_of(change, room, first));
        player.skip(kWarm - 1);
        std::array<double, std::size(kLook)> means{};
        for (uint32_t i = 0, frame = 0; i < std::size(kLook); ++i) {
            if (frame == 0 && kLook[i] > 1) player.next(edit_of(change, room, then)), ++frame;
            player.skip(kLook[i] - 1 - frame);
            means[i] = mean_luminance(player.next());
            frame = kLook[i];
        }
        return means;
    };
    std::vector<double> all[std::size(kLook)], left[2][std::size(kLook)];
    for (uint32_t run = 0; run < kRuns; ++run) {
        const auto so = play(run, true, true), otherwise = play(run, false, false), off = play(run, true, false), on = play(run, false, true);
        for (size_t i = 0; i < std::size(kLook); ++i) {
            all[i].push_back(so[i] - otherwise[i]);
            left[0][i].push_back(off[i] - otherwise[i]);
            left[1][i].push_back(so[i] - on[i]);
        }
    }
    for (size_t i = 0; i < std::size(kLook); ++i)
        for (const bool on : {false, true}) {
            const Moments whole = moments(all[i]), rest = moments(left[on][i]);
            fmt::print("{}: {} {}: {:.4f} +- {:.4f} ({})\n", change.name, on ? "on" : "off", kLook[i], rest.mean / whole.mean, rest.standard_error() / whole.mean, whole.mean);
        }
}

INSTANTIATE_TEST_SUITE_P(Of, RealtimeChange, ::testing::Range(size_t{0}, std::size(kChanges)));

}  // namespace
}  // namespace parhelion::testing
