// What it costs to make the top level anew when ten thousand instances have moved: ours on the host, the driver's on the device, and
// the whole of an update. Prints a table, which docs/performance.md quotes; `PARHELION_SOAK_INSTANCES` sets another number.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

#include "bvh/moving_top.h"
#include "bvh/top_tree.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/bvh_scene.h"
#include "support/render_fixture.h"

namespace parhelion::testing::top_level_test {
namespace {

constexpr uint32_t kFrames = 21;

class TopLevelSpeed : public GpuTest {
protected:
    static uint32_t instance_count() {
        const char* wanted = std::getenv("PARHELION_SOAK_INSTANCES");
        return wanted ? static_cast<uint32_t>(std::strtoul(wanted, nullptr, 10)) : 10'000;
    }
    template <class Body>
    static double milliseconds(Body&& body) {
        const auto begin = std::chrono::steady_clock::now();
        body();
        return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    }
    // "median (best)".
    static std::string times(std::vector<double> values) {
        std::ranges::sort(values);
        return fmt::format("{:.2f} ({:.2f}) ms", values[values.size() / 2], values.front());
    }
    // Where instance i stands in frame f: in a square of 200 m, turned about.
    static glm::mat4 place(uint32_t i, uint32_t frame) {
        bvh::testing::Random random(i + 1);
        const glm::vec3 at(random.range(-100, 100), random.range(0, 3), random.range(-100, 100));
        const float angle = 6.2831853f * random.unit() + 0.1f * static_cast<float>(frame), size = random.range(0.5f, 1.5f);
        glm::mat4 m(1.0f);
        m[0] = size * glm::vec4(std::cos(angle), 0, -std::sin(angle), 0);
        m[1] *= size;
        m[2] = size * glm::vec4(std::sin(angle), 0, std::cos(angle), 0);
        m[3] = glm::vec4(at + glm::vec3(std::sin(angle), 0, std::cos(angle)), 1);
        return m;
    }
};

TEST_F(TopLevelSpeed, the_tree_alone) {
    bvh::Bottoms bottoms;
    const bvh::testing::TestGeometry sphere = bvh::testing::make_icosphere(2, 1.0f);
    const bvh::BottomGeometry geometry{sphere.positions, sphere.triangles};
    bvh::add_bottom(bottoms, {&geometry, 1});
    const bvh::RootBoxes root(bottoms.nodes.read(bottoms.roots.front()));
    const uint32_t count = instance_count();
    std::vector<bvh::TopItem> items(count);
    std::vector<bvh::Box> boxes(count);
    std::vector<double> item_times, full_times, fast_times, top_times, kept_times[3];
    uint32_t rebuilds = 0;
    std::vector<bvh::MovingTop> kept(std::begin(bvh::kLayouts), std::end(bvh::kLayouts));
    for (uint32_t frame = 0; frame < kFrames; ++frame) {
        std::vector<glm::mat4> places;
        std::vector<glm::mat3> inverses;  // rows as columns
        for (uint32_t i = 0; i < count; ++i) places.push_back(place(i, frame)), inverses.push_back(glm::transpose(glm::inverse(glm::mat3(places.back()))));
        item_times.push_back(milliseconds([&] {
            for (uint32_t i = 0; i < count; ++i) items[i] = bvh::make_top_item(root, 0, places[i], {inverses[i][0], inverses[i][1], inverses[i][2]}, i, 0xFFu, 0);
        }));
        for (uint32_t i = 0; i < count; ++i) boxes[i] = items[i].box_ws;
        full_times.push_back(milliseconds([&] { bvh::build_wide_tree(boxes, 4, 1, 12); }));
        fast_times.push_back(milliseconds([&] { bvh::build_top_tree(boxes, 4, 12); }));
        top_times.push_back(milliseconds([&] { bvh::build_top(items, bvh::Layout::Four); }));
        for (size_t k = 0; k < kept.size(); ++k) {
            const double time = milliseconds([&] {
                kept[k].begin(count);
                for (uint32_t i = 0; i < count; ++i) kept[k].set(i, items[i]);
                kept[k].finish();
            });
            if (kept[k].refits() > 0) kept_times[k].push_back(time);
            else if (k == 0) ++rebuilds;
        }
    }
    std::string text = fmt::format("{} instances, median (best) of {}: items {} on one thread; tree {}, as for triangles {}; tree and nodes {}; kept, {} built", count, kFrames, times(item_times),
                                   times(fast_times), times(full_times), times(top_times), rebuilds);
    for (size_t k = 0; k < kept.size(); ++k) text += fmt::format(", {} {}", bvh::layout_name(bvh::kLayouts[k]), times(kept_times[k]));
    std::printf("%s\n", text.c_str());
}

TEST_F(TopLevelSpeed, of_a_scene_that_moves) {
    // Without the layers: they would be what is measured.
    const gpu::DevicePtr plain = gpu::Device::open({});
    const bool hardware = plain->caps().ray_pipeline || plain->caps().ray_query;
    SceneEdit edit;
    std::vector<Handle<Instance>> pending;
    const Handle<Material> grey = edit.add(builtin::lambert("grey", glm::vec3(0.5f)));
    std::vector<Handle<Mesh>> meshes;
    for (uint32_t m = 0; m < 8; ++m) {
        Primitive ball = make_sphere(1.0f, 4 + m, false);
        ball.material = grey;
        meshes.push_back(edit.add(Mesh{.name = "ball", .primitives = {std::move(ball)}}));
    }
    for (uint32_t i = 0; i < instance_count(); ++i) {
        Instance instance{.mesh = meshes[i % meshes.size()]};
        instance.place.node_from_object = place(i, 0);
        pending.push_back(edit.add(std::move(instance)));
    }
    builtin::add_camera(edit, "above", {0.0f, 50.0f, 120.0f}, {0.0f, 0.0f, 0.0f}, 0.8f);
    Scene scene;
    const ChangeSet made = scene.apply(std::move(edit));
    struct Way {
        const char* name;
        std::unique_ptr<SceneGpu> scene_gpu;
        std::unique_ptr<Frame> frame;
        std::vector<double> update, run, build;
        uint32_t rebuilds = 0;  // frames in which ours got a new tree
    };
    std::vector<Way> ways;
    for (const bool own : {true, false}) {
        if (!own && !hardware) continue;
        ways.push_back({own ? "ours" : "the driver's", std::make_unique<SceneGpu>(plain, SceneGpuOptions{.hardware = !own, .own_bvh = own}), std::make_unique<Frame>(plain), {}, {}, {}, 0});
        ways.back().scene_gpu->sync(scene);
        ways.back().scene_gpu->finish(*ways.back().frame);
        ways.back().frame->run();
    }
    std::vector<double> edits;
    for (uint32_t frame = 1; frame <= kFrames; ++frame) {
        ChangeSet changes;
        std::vector<glm::mat4> places;
        for (uint32_t i = 0; i < pending.size(); ++i) places.push_back(place(i, frame));
        edits.push_back(milliseconds([&] {
            changes = scene.begin_frame();
            SceneEdit moved;
            for (uint32_t i = 0; i < pending.size(); ++i) moved.set_transform(made.resolve(pending[i]), places[i]);
            changes.append(scene.apply(std::move(moved)));
        }));
        for (Way& way : ways) {
            way.scene_gpu->sync(scene, changes);
            way.update.push_back(milliseconds([&] { ASSERT_TRUE(way.scene_gpu->update(*way.frame).complete); }));
            way.run.push_back(milliseconds([&] { way.frame->run(); }));
            double build = 1e3 * way.scene_gpu->stats().own_top_seconds;
            for (const PassInfo& pass : way.frame->passes())
                if (pass.name == "build/top") build = pass.gpu_ms;
            way.build.push_back(build);
            way.rebuilds += way.scene_gpu->stats().own_top_refits == 0;
        }
    }
    std::string text = fmt::format("{} moving instances on {}, median (best) of {}: edit {}", instance_count(), plain->caps().name, kFrames, times(edits));
    for (const Way& way : ways)
        text += fmt::format("\n  {}: top level {}{}, update() {}, frame {}", way.name, times(way.build), way.scene_gpu->stats().own_top_bytes > 0 ? fmt::format(", {} new trees", way.rebuilds) : "", times(way.update), times(way.run));
    std::printf("%s\n", text.c_str());
}

}  // namespace
}  // namespace parhelion::testing::top_level_test
