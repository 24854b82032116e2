// What it is worth to make a tree anew that no longer fits: rays against a mesh of 25,000 triangles that has been torn apart, by the tree that followed it, by
// the one that was made instead, and by one that was made of that shape from the start.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "scene/builtin/random.h"
#include "scene/pose.h"
#include "support/render_fixture.h"

namespace parhelion::testing::decay_test {
namespace {

constexpr uint32_t kSide = 112;  // 25,088 triangles
constexpr uint32_t kFormsBefore = 12, kMostForms = 120;
constexpr uint32_t kShots = 5;

// The corner of a tile of a wavy square.
glm::vec3 corner_of(uint32_t tile, uint32_t corner) {
    const glm::vec2 uv = glm::vec2(glm::uvec2(tile % kSide, tile / kSide) + glm::uvec2(corner & 1, corner >> 1)) / float(kSide);
    return {uv.x - 0.5f, 0.1f * std::sin(9 * uv.x) * std::cos(7 * uv.y), uv.y - 0.5f};
}

// Square tiles, each with corners of its own, which lie in order; a morph target takes each to the place that `order` says.
Mesh make_tiles(Handle<Material> material, const std::vector<uint32_t>& order) {
    Primitive p{.material = material};
    MorphTarget torn;
    for (uint32_t tile = 0; tile < order.size(); ++tile) {
        const auto first = static_cast<uint32_t>(p.positions.size());
        for (uint32_t corner = 0; corner < 4; ++corner) {
            p.positions.push_back(corner_of(tile, corner));
            torn.positions.push_back(corner_of(order[tile], corner) - p.positions.back());
        }
        p.triangles.insert(p.triangles.end(), {{first, first + 2, first + 1}, {first + 1, first + 2, first + 3}});
    }
    p.targets.push_back(std::move(torn));
    Mesh mesh{.name = "tiles"};
    mesh.primitives.push_back(std::move(p));
    return mesh;
}

// Tiles change places at random within squares of so many.
std::vector<uint32_t> shuffled_within(uint32_t block) {
    std::vector<uint32_t> order(kSide * kSide);
    std::iota(order.begin(), order.end(), 0u);
    builtin::Random random(1);
    const auto tile = [&](uint32_t square, uint32_t i) { return (square / (kSide / block) * block + i / block) * kSide + square % (kSide / block) * block + i % block; };
    for (uint32_t square = 0; square < (kSide / block) * (kSide / block); ++square)
        for (uint32_t i = block * block - 1; i > 0; --i) std::swap(order[tile(square, i)], order[tile(square, random.below(i + 1))]);
    return order;
}

class TreeDecay : public GpuTest {
protected:
    // The least of several: milliseconds of the pass that traces, by compute.
    static double trace_ms(Stage& stage) {
        const Shot shot{.view = {.width = 96, .height = 96, .max_bounces = 1, .filter = PixelFilter::Point}, .camera = camera_from_above(1.0f, 0.5f), .sample_count = 1};
        View view = stage.make_view(shot);
        view.prepare(stage.frame);
        stage.scene_gpu.finish(stage.frame);
        stage.frame.run();
        double least = 1e9;
        for (uint32_t i = 0; i < kShots; ++i) {
            record_reference(stage.frame, stage.scene_gpu, gpu::TraceWay::Compute, view, {0, shot.view.height, i, 1}, false);
            stage.frame.run();
            for (const PassInfo& pass : stage.frame.passes())
                if (pass.name == "reference/path_trace") least = std::min(least, pass.gpu_ms);
        }
        return least;
    }
    static Scene scene_of(Mesh mesh) {
        SceneEdit edit;
        mesh.primitives[0].material = edit.add(Material{.name = "tiles", .double_sided = true});
        const Handle<Node> node = edit.add(Node{});
        edit.add(Instance{.mesh = edit.add(std::move(mesh)), .place = {.node = node}});
        edit.add(Animation{.channels = {{.node = node, .path = AnimatedPath::Weights, .width = 1, .times = {0, 1, 1000}, .values = {0, 1, 1.001f}}}});
        return make_scene(std::move(edit));
    }
    // Another form of the mesh, at this second.
    static void tear(Stage& stage, double seconds) {
        stage.step(pose_at(stage.scene, seconds));
        stage.scene_gpu.finish(stage.frame);
        stage.frame.run();
    }
};

TEST_F(TreeDecay, rays_meet_a_torn_mesh_sooner_by_a_tree_that_was_made_anew) {
    for (const uint32_t block : {14u, kSide}) {
        const std::vector<uint32_t> torn = shuffled_within(block);
        Stage stage(scene_of(make_tiles({}, torn)), {.hardware = false});
        const double at_rest = trace_ms(stage);
        uint32_t forms = 0;
        while (forms < kFormsBefore) tear(stage, 1 + ++forms);
        ASSERT_EQ(stage.scene_gpu.stats().rebuilt_trees, 0u);
        const double refitted = trace_ms(stage);
        while (stage.scene_gpu.stats().rebuilt_trees == 0 && forms < kMostForms) tear(stage, 1 + ++forms);
        ASSERT_EQ(stage.scene_gpu.stats().rebuilt_trees, 1u) << "after " << forms << " forms, which fit by " << stage.scene_gpu.stats().tree_decay;
        const uint32_t rebuilt_after = forms;
        tear(stage, 1 + ++forms);
        const double rebuilt = trace_ms(stage);
        Mesh shape = make_tiles({}, torn);
        for (size_t i = 0; i < shape.primitives[0].positions.size(); ++i) shape.primitives[0].positions[i] += shape.primitives[0].targets[0].positions[i];
        Stage fresh(scene_of(std::move(shape)), {.hardware = false});
        const double made_so = trace_ms(fresh);
        std::printf("rays at %u triangles that change places within squares of %u x %u tiles, on %s, by compute: at rest %.2f ms; torn apart %.2f ms by the refitted tree, %.2f ms by the one made anew after %u forms (%.1f times as fast), %.2f ms by one made of it\n",
                    2 * kSide * kSide, block, block, device()->caps().name.c_str(), at_rest, refitted, rebuilt, rebuilt_after, refitted / rebuilt, made_so);
        EXPECT_LT(1.5 * rebuilt, refitted);
        EXPECT_LT(rebuilt, 1.5 * made_so);
    }
}

}  // namespace
}  // namespace parhelion::testing::decay_test
