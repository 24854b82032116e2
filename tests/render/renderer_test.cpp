// The renderer for host programs: records into a host's command buffer, one film a view, started anew by edits and camera moves.
#include "renderers/renderer.h"

#include "gpu/internal.h"
#include "session/scene_setup.h"
#include "support/render_fixture.h"

namespace parhelion::testing::renderer_test {
namespace {

constexpr uint32_t kSize = 16;

class HostRenderer : public GpuTest {
protected:
    HostRenderer() : loaded_(make_builtin("builtin:cornell")) {}

    View make_view(uint32_t seed) {
        const CameraView camera = view_of((*loaded_.scene.cameras().begin()).value, 1.0f);
        return View(device(), {.width = kSize, .height = kSize, .camera = shader_camera(camera, 1.0f), .seed = seed});
    }
    // One frame as a host does it: its command buffer, its submission.
    void draw(Renderer& renderer, View& view, const gpu::Image& ldr) {
        gpu::CommandList host(device());
        const uint64_t serial = renderer.record(host.impl().buffer, view, ldr);
        ASSERT_TRUE(gpu::wait(device(), gpu::submit(device(), std::move(host))));
        renderer.retire(serial);
    }
    std::vector<uint32_t> film(View& view) {
        Frame frame(device());
        return view.read_film(frame).limbs;
    }

    LoadedScene loaded_;
};

}  // namespace

TEST_F(HostRenderer, views_accumulate_apart_and_start_anew_when_something_changes) {
    Renderer renderer(device(), {.samples_per_frame = 64});
    const gpu::Image ldr(device(), "test/ldr", {.format = gpu::Format::Rgba8Unorm, .extent = {kSize, kSize}});
    View a = make_view(1), b = make_view(2);
    renderer.sync(loaded_.scene, {});
    draw(renderer, a, ldr);
    const std::vector<uint32_t> a_once = film(a);
    draw(renderer, b, ldr);
    const std::vector<uint32_t> b_once = film(b);
    EXPECT_NE(a_once, b_once);
    EXPECT_EQ(film(a), a_once);  // the other view's frame leaves it alone
    draw(renderer, a, ldr);
    EXPECT_EQ(a.accumulation().samples, 128u);
    EXPECT_EQ(b.accumulation().samples, 64u);
    EXPECT_NE(film(a), a_once);

    a.set_camera(a.desc().camera);  // the same place: the same first block again
    draw(renderer, a, ldr);
    EXPECT_EQ(film(a), a_once);

    renderer.sync(loaded_.scene, loaded_.scene.apply(loaded_.scripted_edits.at(0).apply(loaded_.scene, 0.5)));
    draw(renderer, a, ldr);
    draw(renderer, b, ldr);
    EXPECT_EQ(a.accumulation().samples, 64u);
    EXPECT_EQ(b.accumulation().samples, 64u);
    EXPECT_NE(film(a), a_once);
    EXPECT_NE(film(b), b_once);
}

}  // namespace parhelion::testing::renderer_test
