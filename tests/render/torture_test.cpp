// No NaN, no infinity, no negative value, whatever materials, lights and geometry are at the ends of their ranges.
#include "scene/builtin/random.h"
#include "scene/builtin/scenes.h"
#include "scene/shapes.h"
#include "support/realtime_player.h"

namespace parhelion::testing::torture_test {
namespace {

class Torture : public GpuTest {
protected:
    // Materials at the corners of their ranges, in an order of their own.
    static std::vector<Material> materials() {
        std::vector<Material> out;
        for (const float roughness : {0.0f, 0.029f, 0.031f, 1.0f})
            for (const float metallic : {0.0f, 0.5f, 1.0f})
                for (const glm::vec3 color : {glm::vec3(0.0f), glm::vec3(1.0f), glm::vec3(1.0f, 0.0f, 0.5f)}) out.push_back(builtin::glossy("plain", color, metallic, roughness));
        for (const float ior : {0.0f, 1.0f, 1.0001f, 3.0f})
            for (const float roughness : {0.0f, 0.04f, 1.0f})
                for (const float thickness : {0.0f, 1.0f}) {
                    Material glass = builtin::glossy("glass", glm::vec3(1.0f, 0.9f, 0.0f), 0.0f, roughness);
                    glass.transmission = ior == 3.0f ? 0.5f : 1.0f;
                    glass.ior = ior;
                    glass.thickness = thickness;
                    glass.attenuation_color = {0.0f, 1.0f, 0.5f};
                    glass.attenuation_distance = 1e-3f;
                    glass.clearcoat = roughness;
                    out.push_back(glass);
                }
        for (const float a : {0.0f, 0.02f, 1.0f})
            for (const float b : {0.0f, 0.02f, 1.0f}) {
                Material layered = builtin::glossy("layered", glm::vec3(1.0f), a, b);
                layered.clearcoat = 1.0f;
                layered.clearcoat_roughness = a;
                layered.sheen_color = glm::vec3(1.0f, b, 0.0f);
                layered.sheen_roughness = b;
                layered.specular_color = glm::vec3(20.0f, 0.0f, 1.0f);
                out.push_back(layered);
            }
        return out;
    }
    // A quarter of the normals point below the surface, some are made of nothing.
    static Primitive odd_sphere(uint32_t key) {
        Primitive sphere = make_sphere(0.45f, 6, true);
        for (size_t i = 0; i < sphere.normals.size(); ++i) {
            if ((i * 2654435761u + key) % 4 == 0) sphere.normals[i] = -sphere.normals[i];
            if ((i * 2654435761u + key) % 17 == 0) sphere.positions[i] = sphere.positions[0];  // triangles without area, and slivers
        }
        return sphere;
    }
    static Scene scene() {
        SceneEdit edit;
        const std::vector<Material> all = materials();
        constexpr int kSide = 9;
        for (size_t i = 0; i < all.size(); ++i)
            builtin::add_object(edit, all[i].name, odd_sphere(static_cast<uint32_t>(i)), edit.add(all[i]), {.translation = {float(int(i) % kSide) - 4.0f, float(int(i) / kSide) - 3.5f, 0.0f}});
        Primitive lamp, tiny;
        add_quad(lamp, {-1.0f, -1.0f, 2.0f}, {0.3f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.3f});
        add_quad(tiny, {0.5f, 0.5f, 1.0f}, {1e-5f, 0.0f, 0.0f}, {0.0f, 1e-5f, 0.0f});
        Material bright = builtin::lambert("bright", glm::vec3(1.0f), glm::vec3(1e9f, 1.0f, 1e-9f));
        bright.double_sided = true;
        const Handle<Material> glow = edit.add(bright);
        builtin::add_object(edit, "lamp", std::move(lamp), glow);
        builtin::add_object(edit, "tiny", std::move(tiny), glow);
        // One light lies on a surface, one shines backwards into it.
        edit.add(Light{.kind = LightKind::Point, .intensity = 1e6f, .place = {.node_from_object = glm::translate(glm::mat4(1.0f), {0.0f, 0.5f, 0.45f})}});
        edit.add(Light{.kind = LightKind::Spot, .inner_cone = 0.0f, .outer_cone = 1e-3f, .place = {.node_from_object = glm::translate(glm::mat4(1.0f), {0.0f, 0.0f, 9.0f})}});
        edit.add(Light{.kind = LightKind::Directional, .intensity = 1e5f, .angular_radius = 1e-3f});
        Environment sky{.width = 3, .height = 2, .radiance = std::vector<glm::vec3>(6, glm::vec3(0.0f)), .scale = glm::vec3(1.0f)};
        sky.radiance[1] = glm::vec3(6e4f, 0.0f, 1.0f);
        edit.set_environment(std::move(sky));
        builtin::add_camera(edit, "front", {0.0f, 0.0f, 12.0f}, glm::vec3(0.0f), 0.75f);
        builtin::add_camera(edit, "inside", {-4.0f, -3.5f, 0.1f}, {1.0f, 0.3f, 0.0f}, 1.5f);
        return make_scene(std::move(edit));
    }
};

// A CPU device compiles each way's shaders for minutes: one of them there. What else differs between the ways pictures of glass show (glass_test.cpp).
std::vector<gpu::TraceWay> ways(const gpu::Device& device) {
    std::vector<gpu::TraceWay> out;
    for (const gpu::TraceWay way : kWays)
        if (device.caps().supports(way) && (device.caps().type != gpu::DeviceType::Cpu || way == gpu::TraceWay::Compute)) out.push_back(way);
    return out;
}

}  // namespace

TEST_F(Torture, every_value_of_every_picture_is_finite_and_not_negative) {
    Stage stage(scene());
    for (const gpu::TraceWay way : ways(*device())) {
        for (const bool compensated : {true, false}) {
            SCOPED_TRACE(fmt::format("{}, compensation {}", gpu::trace_way_name(way), compensated));
            expect_sane(stage.picture({.way = way, .view = {.width = 72, .height = 64, .energy_compensation = compensated, .normal_correction = compensated}, .sample_count = 16}));
        }
    }
    std::optional<CameraView> inside;
    for (const auto& [handle, camera] : stage.scene.cameras())
        if (camera.name == "inside") inside = view_of(camera, 1.0f);
    expect_sane(stage.picture({.view = {.width = 32, .height = 32, .max_bounces = 0xFFFFFFFFu}, .camera = inside, .sample_count = 32}));
}

TEST_F(Torture, the_wavefront_draws_the_same_finite_values) {
    Stage stage(scene());
    for (const gpu::TraceWay way : ways(*device())) {
        Shot shot{.way = way, .view = {.width = 72, .height = 64, .aovs = {"path.*", "variance"}}, .sample_count = 2};
        const image::FilmSums expected = stage.render(shot);
        for (const ConnectWhen connect : {ConnectWhen::EachBounce, ConnectWhen::Once}) {
            SCOPED_TRACE(fmt::format("{}, {}", gpu::trace_way_name(way), int(connect)));
            shot.wavefront = WavefrontOptions{.connect = connect, .classes = connect == ConnectWhen::EachBounce};
            const image::FilmSums found = stage.render(shot);
            expect_sane(image::resolve_film(found));
            if (device()->caps().type == gpu::DeviceType::Cpu) {
                EXPECT_EQ(differing_words(found, expected), 0u);
            }
        }
    }
}

// Young cells and old ones, and a cut to where no cell is yet.
TEST_F(Torture, every_frame_in_realtime_is_finite_and_not_negative) {
    Stage stage(scene(), {.raster = true});
    std::optional<CameraView> inside;
    for (const auto& [handle, camera] : stage.scene.cameras())
        if (camera.name == "inside") inside = view_of(camera, 1.0f);
    for (const gpu::TraceWay way : ways(*device())) {
        for (const auto& [cache, reuse] : {std::pair(true, RealtimeReuse::None), {false, RealtimeReuse::None}, {true, RealtimeReuse::Full}, {false, RealtimeReuse::Unbiased}}) {
            if (way != gpu::TraceWay::Compute && (cache || reuse != RealtimeReuse::None)) continue;
            if (cache && !LightCache::supported(device()->caps())) continue;
            SCOPED_TRACE(fmt::format("{}, cache {}, reuse {}", gpu::trace_way_name(way), cache, int(reuse)));
            const GBufferMode gbuffer = !cache && device()->caps().raster ? GBufferMode::Raster : GBufferMode::Trace;
            Player player(stage, {.way = way, .view = {.width = 36, .height = 32, .aovs = {"path.*"}}},
                          {.reuse = reuse, .reuse_options = {.adapt_confidence = false}, .gbuffer = gbuffer, .cache = cache, .cache_options = {.cells = 1u << 13}});
            for (int frame = 0; frame < (cache ? 12 : 4); ++frame) {
                if (frame == (cache ? 8 : 2)) player.set_camera(*inside);
                expect_sane(player.next());
            }
        }
    }
}

}  // namespace parhelion::testing::torture_test
