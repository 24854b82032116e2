// How long a mesh of 100,000 triangles takes to follow a deformation: GPU time of the refits of our tree, in each layout of nodes, and
// of the driver's.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "support/render_fixture.h"

namespace parhelion::testing::refit_test {
namespace {

constexpr uint32_t kSide = 224;  // 100,352 triangles
constexpr int kFrames = 12, kWarmUp = 2;

// A wavy square; waves move with time.
Mesh make_cloth(Handle<Material> material, float time) {
    Primitive p{.material = material};
    for (uint32_t z = 0; z <= kSide; ++z)
        for (uint32_t x = 0; x <= kSide; ++x) {
            const glm::vec2 uv = glm::vec2(x, z) / float(kSide);
            p.positions.emplace_back(uv.x, 0.1f * std::sin(9 * uv.x + time) * std::cos(7 * uv.y - 2 * time), uv.y + 0.05f * std::sin(12 * uv.x + time));
        }
    for (uint32_t z = 0; z < kSide; ++z)
        for (uint32_t x = 0; x < kSide; ++x) {
            const uint32_t a = z * (kSide + 1) + x, b = a + 1, c = a + kSide + 1, d = c + 1;
            p.triangles.insert(p.triangles.end(), {{a, c, b}, {b, c, d}});
        }
    Mesh mesh{.name = "cloth"};
    mesh.primitives.push_back(std::move(p));
    return mesh;
}

double median(std::vector<double> values) {
    std::ranges::sort(values);
    return values.empty() ? 0.0 : values[values.size() / 2];
}

class RefitTimes : public GpuTest {};

TEST_F(RefitTimes, a_hundred_thousand_triangles_are_refitted_in_two_milliseconds) {
    for (const auto& [layout, name] : {std::pair(NodeLayout::Binary, "binary"), std::pair(NodeLayout::Four, "four"), std::pair(NodeLayout::Compact, "compact")}) {
        SceneEdit first;
        const Handle<Material> material = first.add(Material{.name = "cloth"});
        const Handle<Mesh> pending = first.add(make_cloth(material, 0.0f));
        const Handle<Instance> pending_instance = first.add(Instance{.mesh = pending});
        Scene scene;
        const ChangeSet changes = scene.apply(std::move(first));
        const Handle<Mesh> rest = changes.resolve(pending);
        const Handle<Instance> instance = changes.resolve(pending_instance);
        Stage stage(std::move(scene), {.node_layout = layout});
        stage.scene_gpu.finish(stage.frame);
        std::vector<double> triangles, nodes, driver;
        for (int frame = 0; frame < kFrames; ++frame) {
            SceneEdit edit;
            Mesh form = make_cloth(stage.scene.get(rest).primitives[0].material, 0.3f * float(frame + 1));
            form.rest = rest;
            if (const Handle<Mesh> old = stage.scene.get(instance).posed) edit.remove(old);
            edit.set_pose(instance, edit.add(std::move(form)), {});
            stage.step(std::move(edit));
            for (bool complete = false; !complete;) {
                complete = stage.scene_gpu.update(stage.frame).complete;
                stage.frame.run();
                if (frame < kWarmUp) continue;
                for (const PassInfo& pass : stage.frame.passes()) {
                    if (pass.name == "scene_gpu/refit_triangles") triangles.push_back(pass.gpu_ms);
                    if (pass.name == "scene_gpu/refit_nodes") nodes.push_back(pass.gpu_ms);
                    if (pass.name == "build/refit") driver.push_back(pass.gpu_ms);
                }
            }
        }
        EXPECT_EQ(nodes.size(), size_t(kFrames - kWarmUp));
        const double ours = median(triangles) + median(nodes);
        std::printf("refit of %u triangles on %s, %s: %.3f ms (triangles %.3f, nodes %.3f); the driver's %.3f ms; plan and first tree on the host %.0f ms\n", 2 * kSide * kSide,
                    device()->caps().name.c_str(), name, ours, median(triangles), median(nodes), median(driver), 1e3 * stage.scene_gpu.stats().own_build_seconds);
        if (device()->caps().type != gpu::DeviceType::Cpu) {
            EXPECT_LE(ours, 2.0);
        }
    }
}

}  // namespace
}  // namespace parhelion::testing::refit_test
