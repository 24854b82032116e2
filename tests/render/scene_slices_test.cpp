// The scene comes to the device in slices: what is there in the end, and what is drawn meanwhile, does not depend on how it is cut.
#include <algorithm>

#include "renderers/renderer.h"
#include "gpu/internal.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "session/scene_setup.h"
#include "support/trace_rays.h"

namespace parhelion::testing::scene_slices_test {
namespace {

constexpr SceneGpuOptions kCrumbs{.slice_bytes = 1024, .slice_triangles = 1, .geometry_buffer_bytes = 4096};

class SceneSlices : public GpuTest {
protected:
    static Shot shot(gpu::TraceWay way = gpu::TraceWay::Compute) { return {.way = way, .view = {.width = 16, .height = 16, .max_bounces = 3}, .sample_count = 2}; }

    // A sphere of its own material on a plane of its own.
    static Handle<Instance> add_ball(SceneEdit& edit, float x, Handle<Material> material) {
        Mesh mesh{.name = "ball"};
        mesh.primitives.push_back(make_sphere(0.4f, 12, true));
        mesh.primitives.back().material = material;
        return edit.add(Instance{.mesh = edit.add(std::move(mesh)), .place = {.node_from_object = glm::mat4(glm::vec4(1, 0, 0, 0), glm::vec4(0, 1, 0, 0), glm::vec4(0, 0, 1, 0), glm::vec4(x, 0.4f, 0, 1))}});
    }
    struct Balls {
        Scene scene;
        std::vector<Handle<Instance>> balls;
        Handle<Material> material;
    };
    static Balls make_balls(const std::vector<float>& places, glm::vec3 color = {0.8f, 0.2f, 0.1f}) {
        SceneEdit edit;
        Balls out;
        Primitive ground;
        add_quad(ground, {-2.0f, 0.0f, 2.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -4.0f});
        builtin::add_object(edit, "ground", std::move(ground), edit.add(builtin::lambert("ground", glm::vec3(0.6f))));
        out.material = edit.add(builtin::lambert("ball", color));
        for (const float x : places) out.balls.push_back(add_ball(edit, x, out.material));
        edit.set_environment({.scale = glm::vec3(1.0f)});
        builtin::add_camera(edit, "front", {0.0f, 1.2f, 4.0f}, {0.0f, 0.5f, 0.0f}, 0.8f);
        const ChangeSet changes = out.scene.apply(std::move(edit));
        out.material = changes.resolve(out.material);
        for (Handle<Instance>& ball : out.balls) ball = changes.resolve(ball);
        return out;
    }
    static uint32_t count(const Frame& frame, std::string_view pass, std::string_view written = {}) {
        return static_cast<uint32_t>(std::ranges::count_if(frame.passes(), [&](const PassInfo& info) {
            return info.name == pass && (written.empty() || std::ranges::find(info.writes, written) != info.writes.end());
        }));
    }
};

}  // namespace

TEST_F(SceneSlices, crumbs_make_the_same_scene_as_one_piece) {
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        SceneGpuOptions options = kCrumbs;
        options.hardware = way != gpu::TraceWay::Compute;
        options.own_bvh = !options.hardware;
        Stage crumbs(make_builtin("builtin:textured").scene, options);
        uint32_t slices = 0;
        SceneProgress progress = crumbs.scene_gpu.update(crumbs.frame);
        for (double before = 0; !progress.complete; progress = crumbs.scene_gpu.update(crumbs.frame), ++slices) {
            EXPECT_GE(progress.done, before);
            EXPECT_LE(progress.done, progress.total);
            before = progress.done;
            crumbs.frame.run();
            // Whole small tables share a slice.
            EXPECT_LE(count(crumbs.frame, "transfer/upload") + count(crumbs.frame, "transfer/upload_image"), 20u);
        }
        EXPECT_GT(slices, 100u);
        EXPECT_EQ(crumbs.render(shot(way)).limbs, builtin_film("builtin:textured", shot(way)).limbs) << gpu::trace_way_name(way);
    }
}

TEST_F(SceneSlices, edits_while_the_scene_comes_in_are_not_lost) {
    for (const gpu::TraceWay way : {gpu::TraceWay::Compute, gpu::TraceWay::Query}) {
        if (!device()->caps().supports(way)) continue;
        for (const int edited_after : {1, 6, 20}) {
            Balls start = make_balls({-1.0f, 0.0f});
            Stage stage(std::move(start.scene), kCrumbs);
            for (int i = 0; i < edited_after; ++i) {
                EXPECT_FALSE(stage.scene_gpu.update(stage.frame).drawable);
                stage.frame.run();
            }
            SceneEdit edit;
            const Handle<Mesh> gone = stage.scene.get(start.balls[0]).mesh;
            edit.remove(start.balls[0]);
            edit.remove(gone);
            edit.set_material(start.material, builtin::lambert("ball", {0.1f, 0.7f, 0.2f}));
            add_ball(edit, 1.0f, start.material);
            stage.step(std::move(edit));
            Stage scratch(make_balls({1.0f, 0.0f}, {0.1f, 0.7f, 0.2f}).scene);
            EXPECT_EQ(stage.render(shot(way)).limbs, scratch.render(shot(way)).limbs) << gpu::trace_way_name(way) << " after " << edited_after;
        }
    }
}

TEST_F(SceneSlices, the_scene_before_is_drawn_until_the_new_one_is_complete) {
    Balls start = make_balls({0.0f});
    Stage stage(std::move(start.scene), kCrumbs);
    const std::vector<TestRay> through = {{{0.0f, 0.4f, 3.0f}, {0.0f, 0.0f, -1.0f}}, {{1.0f, 0.4f, 3.0f}, {0.0f, 0.0f, -1.0f}}};
    EXPECT_TRUE(trace_rays(stage, gpu::TraceWay::Compute, through)[0].hit());
    const uint64_t version = stage.scene_gpu.version();
    SceneEdit edit;
    edit.remove(start.balls[0]);
    add_ball(edit, 1.0f, start.material);
    stage.step(std::move(edit));
    SceneProgress progress = stage.scene_gpu.update(stage.frame);
    const auto visible = [&] {
        struct Push {
            uint64_t rays = 0, found = 0;
            uint32_t count, mask = 0xFFu;
        };
        const gpu::Buffer input(device(), "test/rays", 2 * sizeof(TestRay)), output(device(), "test/found", 2 * sizeof(TestFound));
        stage.frame.upload(input, 0, std::as_bytes(std::span(through)));
        stage.frame.trace("device/visible", gpu::TraceWay::Compute).scene(stage.scene_gpu.binding()).read("rays", input).write("found", output).push(Push{.count = 2}).over(2);
        const gpu::Buffer copy = stage.frame.read_back(output);
        stage.frame.run();
        return std::pair(copy.mapped_as<TestFound>()[0].hit(), copy.mapped_as<TestFound>()[1].hit());
    };
    uint32_t waited = 0;
    for (; stage.scene_gpu.version() == version; progress = stage.scene_gpu.update(stage.frame), ++waited) {
        EXPECT_TRUE(progress.drawable);
        EXPECT_FALSE(progress.complete);
        ASSERT_EQ(visible(), std::pair(true, false));
    }
    EXPECT_GT(waited, 5u);
    EXPECT_EQ(visible(), std::pair(false, true));
}

TEST_F(SceneSlices, an_edit_of_a_material_leaves_the_geometry_alone) {
    Balls start = make_balls({0.0f});
    Stage stage(std::move(start.scene));
    stage.render(shot());
    const auto edited = [&](const Material& material) -> const Frame& {
        SceneEdit edit;
        edit.set_material(start.material, material);
        stage.step(std::move(edit));
        stage.scene_gpu.update(stage.frame);
        stage.frame.run();
        return stage.frame;
    };
    const Frame& colour = edited(builtin::lambert("ball", {0.1f, 0.1f, 0.9f}));
    EXPECT_EQ(count(colour, "transfer/upload", "scene/materials"), 1u);
    for (const char* table : {"scene/geometry", "scene/geometries", "scene/bottom_nodes", "scene/bottom_triangles", "scene/textures", "scene/triangle_alias"})
        EXPECT_EQ(count(colour, "transfer/upload", table), 0u) << table;
    EXPECT_EQ(count(colour, "build/bottom"), 0u);
    Material see_through = builtin::lambert("ball", {0.1f, 0.1f, 0.9f});
    see_through.alpha_mode = AlphaMode::Blend;
    see_through.base_color.a = 0.5f;
    const Frame& blend = edited(see_through);
    EXPECT_EQ(count(blend, "transfer/upload", "scene/geometry"), 0u);
    EXPECT_EQ(count(blend, "transfer/upload", "scene/geometries"), 1u);
    if (device()->caps().ray_query || device()->caps().ray_pipeline) {
        EXPECT_EQ(count(blend, "build/bottom"), 1u);
    }
}

TEST_F(SceneSlices, another_scene_takes_the_place_of_the_first) {
    Stage stage(make_balls({-1.0f, 0.5f}).scene), other(make_balls({0.2f, 1.0f}, {0.1f, 0.2f, 0.9f}).scene);
    const std::vector<uint32_t> first = stage.render(shot()).limbs;
    stage.scene = make_balls({0.2f, 1.0f}, {0.1f, 0.2f, 0.9f}).scene;
    stage.scene_gpu.sync(stage.scene);
    const std::vector<uint32_t> second = stage.render(shot()).limbs;
    EXPECT_NE(second, first);
    EXPECT_EQ(second, other.render(shot()).limbs);
}

TEST_F(SceneSlices, what_no_instance_draws_is_not_on_the_device) {
    Balls start = make_balls({-1.0f, 0.0f, 1.0f});
    Stage stage(std::move(start.scene));
    stage.scene_gpu.finish(stage.frame);
    const uint64_t all = stage.scene_gpu.stats().triangles;
    EXPECT_EQ(stage.scene_gpu.stats().meshes, 4u);
    SceneEdit edit;
    edit.remove(start.balls[1]);
    stage.step(std::move(edit));
    stage.scene_gpu.finish(stage.frame);
    EXPECT_EQ(stage.scene_gpu.stats().meshes, 3u);
    EXPECT_LT(stage.scene_gpu.stats().triangles, all);
}

// Meshes come and go for as long as a program runs: their room is used again.
TEST_F(SceneSlices, memory_does_not_grow_with_the_number_of_edits) {
    Balls start = make_balls({0.0f});
    Handle<Instance> ball = start.balls[0];
    Stage stage(std::move(start.scene));
    std::vector<uint64_t> bytes;
    for (int i = 0; i < 12; ++i) {
        SceneEdit edit;
        const Handle<Mesh> gone = stage.scene.get(ball).mesh;
        edit.remove(ball);
        edit.remove(gone);
        ball = add_ball(edit, 0.1f * float(i % 3), start.material);
        ball = stage.step(std::move(edit)).resolve(ball);
        stage.scene_gpu.finish(stage.frame);
        stage.frame.run();
        uint64_t sum = 0;
        for (const gpu::MemoryUse& use : device()->memory_use())
            if (use.group == "scene" || use.group == "accel") sum += use.bytes;
        bytes.push_back(sum);
    }
    EXPECT_LE(bytes.back(), bytes[5]);
}

TEST_F(SceneSlices, a_host_program_sees_black_and_then_the_picture) {
    const auto make = [&](const SceneGpuOptions& options) { return Renderer(device(), {.scene = options, .samples_per_frame = 64}); };
    const LoadedScene loaded = make_builtin("builtin:cornell");
    const gpu::Image ldr(device(), "test/ldr", {.format = gpu::Format::Rgba8Unorm, .extent = {16, 16}});
    const CameraView camera = view_of((*loaded.scene.cameras().begin()).value, 1.0f);
    const auto draw = [&](Renderer& renderer, View& view) {
        gpu::CommandList host(device());
        const uint64_t serial = renderer.record(host.impl().buffer, view, ldr);
        ASSERT_TRUE(gpu::wait(device(), gpu::submit(device(), std::move(host))));
        renderer.retire(serial);
    };
    const auto film = [&](View& view) {
        Frame frame(device());
        return view.read_film(frame).limbs;
    };
    const ViewDesc desc{.width = 16, .height = 16, .camera = shader_camera(camera, 1.0f)};
    Renderer whole = make({}), crumbs = make(kCrumbs);
    View expected(device(), desc), view(device(), desc);
    whole.sync(loaded.scene, {});
    crumbs.sync(loaded.scene, {});
    draw(whole, expected);
    ASSERT_TRUE(whole.progress().complete);
    uint32_t black = 0;
    for (draw(crumbs, view); !crumbs.progress().drawable; draw(crumbs, view), ++black) {
        const std::vector<uint32_t> limbs = film(view);
        ASSERT_TRUE(std::ranges::all_of(limbs, [](uint32_t limb) { return limb == 0; }));
    }
    EXPECT_GT(black, 10u);
    EXPECT_EQ(film(view), film(expected));
}

}  // namespace parhelion::testing::scene_slices_test
