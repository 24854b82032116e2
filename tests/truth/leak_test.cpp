// Light that goes where none is: through walls of 1, 5 and 20 cm, into closed boxes and out of them; the brightest pixel of the brightest
// frame. Where the truth is black there is no noise, so nothing here is statistical.
#include <algorithm>

#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "truth/truth.h"

namespace parhelion::testing::leak_test {
namespace {

constexpr double kLimit = 1e-3;  // of the bright side's mean
constexpr const char* kInsides[] = {"inside 1 cm", "inside 5 cm", "inside 20 cm"};

struct Way {
    const char* name;
    bool begins_bright, by_turns;
};
constexpr Way kWaysToLook[] = {{"alone", false, false}, {"after the bright", true, false}, {"by turns", true, true}};

uint32_t frame_count() { return by_size(256u, 24u); }
constexpr uint32_t kFullSize = 256;
uint32_t picture_size() { return by_size(kFullSize, 48u); }

// Cells are so many pixels wide: small pictures would have cells as large as the boxes, which nobody promises to be tight.
RealtimeOptions leak_options(const TruthStage& on) {
    RealtimeOptions options = truth_options(on, true);
    options.cache_options.cell_pixels *= static_cast<float>(picture_size()) / static_cast<float>(kFullSize);
    return options;
}

CameraView camera_of(const Scene& scene, const std::string& name) { return view_of(scene.get(find_camera(scene, name)), 1.0f); }

double brightest(const image::ImageF& picture) {
    const std::vector<float> all = luminance(picture);
    return static_cast<double>(*std::max_element(all.begin(), all.end()));
}

void report_leak(const char* scene, const std::string& what, double leaked, double bright) {
    const double share = leaked / bright;
    report({.test = "leak", .scene = scene, .what = what, .value = share, .low = share, .high = share, .least = 0, .most = kLimit, .runs = 1,
            .frames = frame_count(), .note = "brightest pixel of any frame over the bright side's mean"});
}

class RealtimeLeaks : public TruthTest {
protected:
    // The brightest pixel that the dark camera saw in any of its frames: from its first frame on; after 64 of the bright side; by turns with it.
    void look_at_the_dark(TruthStage& on, const char* scene, const std::string& dark_name, const CameraView& bright, const CameraView& dark) {
        on.camera = bright;
        const double light = mean_luminance(draw_reference(on, picture_size(), 7, by_size(256u, 32u)));
        ASSERT_GT(light, 0.0);
        for (const Way& way : kWaysToLook) {
            on.camera = way.begins_bright ? bright : dark;
            TruthRun run(on, picture_size(), 1, leak_options(on));
            if (way.begins_bright) run.skip(by_size(64u, 12u));
            double leaked = 0;
            for (uint32_t frame = 0; frame < frame_count(); ++frame) {
                if (way.by_turns || (way.begins_bright && frame == 0)) run.look(dark);
                leaked = std::max(leaked, brightest(run.average(1)));
                if (!way.by_turns) continue;
                run.look(bright);
                run.skip(1);
            }
            report_leak(scene, fmt::format("{}, {}", dark_name, way.name), leaked, light);
        }
    }
};

TEST_F(RealtimeLeaks, nothing_of_the_room_is_seen_inside_the_boxes) {
    LoadedScene loaded = make_builtin("builtin:leak-box");
    const CameraView outside = camera_of(loaded.scene, "outside");
    std::map<std::string, CameraView> insides;
    for (const char* name : kInsides) insides[name] = camera_of(loaded.scene, name);
    TruthStage on = set_up(std::move(loaded), outside);
    for (const auto& [name, inside] : insides)
        if (!small_truth() || name == kInsides[0]) look_at_the_dark(on, "leak_box", name, outside, inside);
}

// The room's lamp is off; in each box hangs a glowing ball.
TEST_F(RealtimeLeaks, nothing_of_what_glows_in_the_boxes_is_seen_in_the_room) {
    LoadedScene loaded = make_builtin("builtin:leak-box");
    loaded.scene.apply(loaded.scripted_edits.front().apply(loaded.scene, 1.5));
    SceneEdit edit;
    const Handle<Material> glow = edit.add(builtin::lambert("glow", glm::vec3(0.5f), glm::vec3(1000.0f)));
    for (const float x : {-1.8f, 0.0f, 1.8f}) builtin::add_object(edit, "lamp in the box", make_sphere(0.1f, 12, true), glow, {.translation = {x, 0.75f, -1.2f}});
    loaded.scene.apply(std::move(edit));
    const CameraView outside = camera_of(loaded.scene, "outside");
    std::map<std::string, CameraView> insides;
    for (const char* name : kInsides) insides[name] = camera_of(loaded.scene, name);
    TruthStage on = set_up(std::move(loaded), insides.begin()->second);
    for (const auto& [name, inside] : insides)
        if (!small_truth() || name == kInsides[0]) look_at_the_dark(on, "leak_box, lit inside", "room, " + name, inside, outside);
}

}  // namespace
}  // namespace parhelion::testing::leak_test
