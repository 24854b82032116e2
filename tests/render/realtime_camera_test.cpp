// What a camera brings with it when it goes to where the light is another: nothing.
#include <algorithm>

#include "scene/builtin/scenes.h"
#include "support/realtime_player.h"

namespace parhelion::testing::realtime_camera_test {
namespace {

class RealtimeCamera : public GpuTest {
protected:
    void SetUp() override {
        GpuTest::SetUp();
        if (!IsSkipped() && !LightCache::supported(device()->caps())) GTEST_SKIP() << "no 64-bit atomics on buffers";
    }
    static CameraView camera(const Stage& stage, const char* name) { return view_of(stage.scene.get(find_camera(stage.scene, name)), 1.0f); }
    static Shot shot(const Stage& stage, const char* name) { return {.view = {.width = 16, .height = 16, .filter = PixelFilter::Point}, .camera = camera(stage, name)}; }
    // Cells as large pictures have them: eight of so few pixels would span the box.
    static constexpr CacheOptions kCache{.cells = 1u << 14, .budget = 512, .cell_pixels = 0.125f};
    static double brightest(const image::ImageF& picture) {
        double most = 0;
        for (size_t p = 0; p < picture.pixel_count(); ++p) most = std::max(most, luminance_of(picture, p));
        return most;
    }
};

// The lit room around the closed boxes and what their insides show, from the first frame on: a thousandth of it at no pixel. The camera has
// always been inside; or it comes in every fourth frame from outside, where it has called for cells all around the box.
TEST_F(RealtimeCamera, sees_no_light_in_a_closed_box) {
    Stage& stage = builtin_stage("builtin:leak-box");
    double outside = 0;
    {
        Player player(stage, shot(stage, "outside"), {.cache_options = kCache});
        for (int frame = 0; frame < 4; ++frame) outside = mean_luminance(player.next());
        EXPECT_GT(outside, 10.0);
    }
    for (const char* name : {"inside 1 cm", "inside 5 cm"})
        for (const bool comes : {false, true}) {
            SCOPED_TRACE(fmt::format("{}, {}", name, comes ? "comes in" : "from the first frame on"));
            Player player(stage, shot(stage, name), {.cache_options = kCache});
            double inside = 0;
            for (int frame = 0; frame < 32; ++frame) {
                if (comes && frame % 4 == 0) player.set_camera(camera(stage, "outside"));
                if (comes && frame % 4 == 3) player.set_camera(camera(stage, name));
                const bool looks = !comes || frame % 4 == 3;
                if (looks) inside = std::max(inside, brightest(player.next()));
                else player.skip(1);
            }
            EXPECT_LE(inside, 1e-3 * outside);
        }
}

// A camera turns for two frames, then stands: in its second frame there nothing moves any more, neither on its walls nor in the depth that
// hides what is drawn.
TEST_F(RealtimeCamera, moves_nothing_in_the_second_frame_after_it_stopped) {
    Stage& stage = builtin_stage("builtin:cornell");
    const CameraView first = view_of((*stage.scene.cameras().begin()).value, 1.0f);
    CameraView turned = first;
    turned.position += 0.05f * first.right;
    Player player(stage, {.view = {.width = 16, .height = 16, .filter = PixelFilter::Point}}, {.cache = false});
    const auto moving = [&] {
        player.skip(1);
        const gpu::Buffer copy = stage.frame.read_back(player.realtime.gbuffer().motion);
        stage.frame.run();
        const auto motion = copy.mapped_as<glm::vec2>();
        return std::ranges::count_if(motion, [](glm::vec2 v) { return glm::length(v) > 1e-3f; });
    };
    EXPECT_EQ(moving(), 0) << "the first frame has no past";
    player.set_camera(turned);
    EXPECT_GT(moving(), 200);
    EXPECT_EQ(moving(), 0) << "it stands, untouched";
    player.set_camera(first);
    EXPECT_GT(moving(), 200);
    player.set_camera(first);
    EXPECT_EQ(moving(), 0) << "it is set to where it stands";
}

// After a cut the first frame is that of a renderer that begins there: what pixels see is of no other frame, and light that is sampled
// where they see it does not know of the past.
TEST_F(RealtimeCamera, has_no_past_after_a_cut) {
    Stage stage(make_builtin("builtin:leak-box").scene, {.hardware = false, .raster = true});
    for (const GBufferMode gbuffer : {GBufferMode::Trace, GBufferMode::Raster}) {
        if (gbuffer == GBufferMode::Raster && !device()->caps().raster) continue;
        SCOPED_TRACE(int(gbuffer));
        const RealtimeOptions options{.gbuffer = gbuffer, .cache_options = kCache};
        Shot before = shot(stage, "inside 5 cm"), after = shot(stage, "outside");
        for (Shot* each : {&before, &after}) each->view.aovs = {"path.direct_diffuse", "path.emission"};
        Player cut(stage, before, options), fresh(stage, after, options);
        cut.skip(12);
        cut.set_camera(camera(stage, "outside"));
        fresh.realtime.set_frame_index(12);
        const image::ImageF found = cut.next(), expected = fresh.next();
        ASSERT_EQ(found.channels.size(), 9u);
        EXPECT_GT(mean_luminance(expected), 10.0);
        for (size_t c = 3; c < 9; ++c)
            for (size_t p = 0; p < found.pixel_count(); ++p) ASSERT_EQ(found.plane(c)[p], expected.plane(c)[p]) << found.channels[c] << ' ' << p;
    }
}

// The lamp goes out while the camera looks elsewhere, and it looks back while the cells are still there that it asked for before.
TEST_F(RealtimeCamera, finds_no_light_that_went_out_behind_its_back) {
    for (const uint32_t away : {4u, 8u}) {
        LoadedScene loaded = make_builtin("builtin:leak-box");
        Stage stage(std::move(loaded.scene));
        Player player(stage, shot(stage, "outside"), {.cache_options = {.cells = 1u << 13}});
        player.skip(16);
        const double lit = mean_luminance(player.next());
        player.set_camera(camera(stage, "inside 20 cm"));
        player.next(loaded.scripted_edits[0].apply(stage.scene, 1.5));
        player.skip(away - 1);
        player.set_camera(camera(stage, "outside"));
        const double left = mean_luminance(player.next());
        EXPECT_LE(left / lit, 0.1);
    }
}

// Nobody looks at the room any more: its cells live on for as long as they were promised, and are gone.
TEST_F(RealtimeCamera, leaves_no_cell_behind) {
    Stage& stage = builtin_stage("builtin:cornell");
    Player player(stage, {.view = {.width = 16, .height = 16}}, {.cache_options = {.cells = 1u << 13}});
    const auto live = [&] { return player.realtime.cache()->read_stats(stage.frame).live; };
    player.skip(12);
    const uint32_t before = live();
    EXPECT_GT(before, 20u);
    player.set_camera(look_at({0.0f, 100.0f, 0.0f}, {0.0f, 200.0f, 1.0f}, 0.5f));
    player.skip(CacheOptions{}.life / 2);
    EXPECT_GE(live(), before / 2) << "it may be back at once";
    player.skip(CacheOptions{}.life / 2 + 2);
    EXPECT_EQ(live(), 0u);
}

}  // namespace
}  // namespace parhelion::testing::realtime_camera_test
