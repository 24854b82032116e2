// Ray masks, opacity and the previous frame of many instances are the same in every way to trace.
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/render_fixture.h"
#include "support/trace_rays.h"

namespace parhelion::testing::instance_mask_test {
namespace {

class InstanceMasks : public GpuTest {
protected:
    static constexpr float kDown = 10.0f;
    static TestRay ray_down(float x, float z) { return {{x, kDown, z}, {0.0f, -1.0f, 0.0f}}; }

    // A square of 1 m about the origin, facing up.
    static Primitive square() {
        Primitive quad;
        add_textured_quad(quad, {-0.5f, 0.0f, 0.5f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}, glm::vec2(1.0f), 1);
        return quad;
    }
    static glm::mat4 at(float x, float z) {
        glm::mat4 m(1.0f);
        m[3] = glm::vec4(x, 0.0f, z, 1.0f);
        return m;
    }
    // Through which a ray passes: wholly transparent, as a mask has it.
    static Material hole() {
        Material material = builtin::lambert("hole", glm::vec3(0.5f));
        material.alpha_mode = AlphaMode::Mask;
        material.base_color.a = 0.0f;
        return material;
    }
};

TEST_F(InstanceMasks, a_ray_sees_the_instances_whose_mask_shares_a_bit) {
    constexpr uint32_t masks[] = {0x00, 0x01, 0x02, 0x03, 0x80, 0xFF};
    SceneEdit edit;
    Primitive quad = square();
    quad.material = edit.add(builtin::lambert("grey", glm::vec3(0.5f)));
    const Handle<Mesh> mesh = edit.add(Mesh{.name = "square", .primitives = {std::move(quad)}});
    std::vector<TestRay> rays;
    for (uint32_t i = 0; i < std::size(masks); ++i) {
        const float x = 2.0f * static_cast<float>(i);
        Instance instance{.mesh = mesh, .ray_mask = masks[i]};
        instance.place.node_from_object = at(x, 0.0f);
        edit.add(std::move(instance));
        rays.push_back(ray_down(x, 0.1f));
    }
    Stage stage(make_scene(std::move(edit)));
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way)) continue;
        for (const uint32_t mask : {0x00u, 0x01u, 0x02u, 0x7Fu, 0x80u, 0xFFu}) {
            const std::vector<TestFound> found = trace_rays(stage, way, rays, mask);
            for (uint32_t i = 0; i < rays.size(); ++i) {
                const bool seen = (masks[i] & mask) != 0;
                EXPECT_EQ(found[i].hit(), seen) << gpu::trace_way_name(way) << ", instance " << masks[i] << ", ray " << mask;
                EXPECT_EQ(found[i].visible_now != 0, !seen) << gpu::trace_way_name(way) << ", instance " << masks[i] << ", ray " << mask;
                EXPECT_EQ(found[i].visible_before != 0, !seen) << gpu::trace_way_name(way) << ", instance " << masks[i] << ", ray " << mask;
            }
        }
    }
    SceneEdit wide;
    wide.add(Instance{.mesh = (*stage.scene.meshes().begin()).handle, .ray_mask = 0x100});
    EXPECT_THROW(stage.scene.apply(std::move(wide)), Error);
}

// A mesh with holes in some of its 40 geometries, more than a top level has bits for; the same with an instance that is opaque all over and
// one that asks about every hit.
TEST_F(InstanceMasks, opacity_is_by_geometry_unless_the_instance_has_its_own) {
    constexpr uint32_t kGeometries = 40;
    for (const bool late_holes : {false, true}) {
        const auto is_hole = [&](uint32_t g) { return g < 30 ? g % 3 == 1 : late_holes && g % 4 == 1; };
        SceneEdit edit;
        const Handle<Material> solid = edit.add(builtin::lambert("grey", glm::vec3(0.5f))), open = edit.add(hole());
        Mesh mesh{.name = "squares"};
        for (uint32_t g = 0; g < kGeometries; ++g) {
            Primitive quad = square();
            for (glm::vec3& p : quad.positions) p.x += 2.0f * static_cast<float>(g);
            quad.material = is_hole(g) ? open : solid;
            mesh.primitives.push_back(std::move(quad));
        }
        const Handle<Mesh> squares = edit.add(std::move(mesh));
        std::vector<TestRay> rays;
        for (const InstanceOpacity opacity : {InstanceOpacity::ByMaterial, InstanceOpacity::Opaque, InstanceOpacity::Asked}) {
            const float z = 2.0f * static_cast<float>(opacity);
            Instance instance{.mesh = squares, .opacity = opacity};
            instance.place.node_from_object = at(0.0f, z);
            edit.add(std::move(instance));
            for (uint32_t g = 0; g < kGeometries; ++g) rays.push_back(ray_down(2.0f * static_cast<float>(g), z + 0.1f));
            // From below nothing is there: every geometry is single-sided.
            for (uint32_t g = 0; g < kGeometries; ++g) rays.push_back({{2.0f * static_cast<float>(g), -kDown, z + 0.1f}, {0.0f, 1.0f, 0.0f}});
        }
        Stage stage(make_scene(std::move(edit)));
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            const std::vector<TestFound> found = trace_rays(stage, way, rays);
            for (uint32_t i = 0; i < rays.size(); ++i) {
                const auto opacity = static_cast<InstanceOpacity>(i / (2 * kGeometries));
                const uint32_t g = i % kGeometries;
                const bool below = i / kGeometries % 2 == 1, there = !below && (opacity == InstanceOpacity::Opaque || !is_hole(g));
                ASSERT_EQ(found[i].hit(), there) << gpu::trace_way_name(way) << ", geometry " << g << ", opacity " << int(opacity) << (below ? ", from below" : "");
                ASSERT_EQ(found[i].visible_now != 0, !there) << gpu::trace_way_name(way) << ", geometry " << g << ", opacity " << int(opacity) << (below ? ", from below" : "");
            }
        }
    }
}

// A material that loses its holes, and gets them back, is seen at once: flags follow the materials.
TEST_F(InstanceMasks, opacity_follows_an_edit_of_the_material) {
    SceneEdit edit;
    Primitive quad = square();
    quad.material = edit.add(hole());
    const Handle<Mesh> mesh = edit.add(Mesh{.name = "square", .primitives = {std::move(quad)}});
    edit.add(Instance{.mesh = mesh});
    Stage stage(make_scene(std::move(edit)));
    const Handle<Material> material = (*stage.scene.materials().begin()).handle;
    for (const bool open : {true, false, true}) {
        SceneEdit changed;
        changed.set_material(material, open ? hole() : builtin::lambert("grey", glm::vec3(0.5f)));
        stage.step(std::move(changed));
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            EXPECT_EQ(trace_rays(stage, way, {ray_down(0.0f, 0.1f)})[0].hit(), !open) << gpu::trace_way_name(way);
        }
    }
}

TEST_F(InstanceMasks, a_thousand_moved_instances_are_where_they_were_in_the_previous_frame) {
    constexpr uint32_t kCount = 1000, kSide = 32;
    // Frame 0, 1 and 2 have them on squares of their own; neighbours come from anywhere, so that the tree is another one.
    const auto place = [](uint32_t i, uint32_t frame) {
        const uint32_t cell = frame == 1 ? i * 617 % kCount : i;
        return glm::vec2(4.0f * static_cast<float>(cell % kSide) + 1.3f * static_cast<float>(frame), 4.0f * static_cast<float>(cell / kSide));
    };
    SceneEdit edit;
    Primitive quad = square();
    quad.material = edit.add(builtin::lambert("grey", glm::vec3(0.5f)));
    const Handle<Mesh> mesh = edit.add(Mesh{.name = "square", .primitives = {std::move(quad)}});
    std::vector<Handle<Instance>> instances;
    for (uint32_t i = 0; i < kCount; ++i) {
        Instance instance{.mesh = mesh};
        instance.place.node_from_object = at(place(i, 0).x, place(i, 0).y);
        instances.push_back(edit.add(std::move(instance)));
    }
    Scene scene;
    const ChangeSet made = scene.apply(std::move(edit));
    Stage stage(std::move(scene));
    std::vector<TestRay> rays;
    for (uint32_t frame = 0; frame < 3; ++frame)
        for (uint32_t i = 0; i < kCount; ++i) rays.push_back(ray_down(place(i, frame).x, place(i, frame).y + 0.1f));
    const auto expect_at = [&](uint32_t now, uint32_t before) {
        for (const gpu::TraceWay way : kWays) {
            if (!device()->caps().supports(way)) continue;
            const std::vector<TestFound> found = trace_rays(stage, way, rays);
            uint32_t wrong_now = 0, wrong_before = 0;
            for (uint32_t r = 0; r < rays.size(); ++r) {
                wrong_now += found[r].hit() != (r / kCount == now) || (found[r].visible_now == 0) != (r / kCount == now);
                wrong_before += (found[r].visible_before == 0) != (r / kCount == before);
            }
            EXPECT_EQ(wrong_now, 0u) << gpu::trace_way_name(way) << ", frame " << now;
            EXPECT_EQ(wrong_before, 0u) << gpu::trace_way_name(way) << ", frame " << now;
        }
    };
    expect_at(0, 0);
    for (uint32_t frame = 1; frame < 3; ++frame) {
        SceneEdit moved;
        for (uint32_t i = 0; i < kCount; ++i) moved.set_transform(made.resolve(instances[i]), at(place(i, frame).x, place(i, frame).y));
        stage.step(std::move(moved));
        expect_at(frame, frame - 1);
    }
    stage.step({});
    expect_at(2, 2);
}

}  // namespace
}  // namespace parhelion::testing::instance_mask_test
