// A large scene: 2,000,000 triangles (PARHELION_SOAK_TRIANGLES) in meshes of several sizes and 1,000 textures of 256 x 256 texels.
// Loads in slices, within a stated multiple of its size, and draws.
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "base/platform.h"
#include "scene/builtin/scenes.h"
#include "support/render_fixture.h"

namespace parhelion::testing::large_scene_test {
namespace {

constexpr uint32_t kTextures = 1000, kTextureSide = 256;

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

// A wavy square of 2 side^2 triangles in [0, 1]^2 at `corner`.
Primitive make_grid(uint32_t side, glm::vec3 corner) {
    Primitive p;
    p.positions.reserve(size_t(side + 1) * (side + 1));
    p.uv0.reserve(p.positions.capacity());
    p.normals.reserve(p.positions.capacity());
    for (uint32_t z = 0; z <= side; ++z)
        for (uint32_t x = 0; x <= side; ++x) {
            const glm::vec2 uv = glm::vec2(x, z) / float(side);
            p.positions.push_back(corner + glm::vec3(uv.x, 0.02f * std::sin(40 * uv.x) * std::sin(40 * uv.y), uv.y));
            p.normals.emplace_back(0.0f, 1.0f, 0.0f);
            p.uv0.push_back(uv);
        }
    for (uint32_t z = 0; z < side; ++z)
        for (uint32_t x = 0; x < side; ++x) {
            const uint32_t a = z * (side + 1) + x, b = a + 1, c = a + side + 1, d = c + 1;
            p.triangles.insert(p.triangles.end(), {{a, c, b}, {b, c, d}});
        }
    return p;
}

// One mesh of half the triangles, the others in 1,000 meshes, each with a texture of its own.
Scene make_large(uint64_t triangles) {
    SceneEdit edit;
    const auto side_of = [](double count) { return std::max(1u, static_cast<uint32_t>(std::sqrt(count / 2))); };
    for (uint32_t i = 0; i <= kTextures; ++i) {
        const bool large = i == kTextures;
        Image image{.name = "noise", .width = kTextureSide, .height = kTextureSide};
        image.texels.resize(size_t(kTextureSide) * kTextureSide * 4, 255);
        for (size_t t = 0; t < image.texels.size(); t += 4) image.texels[t + i % 3] = static_cast<uint8_t>(t * 2654435761u >> 24);
        Material material{.name = "cell", .roughness = 1.0f};
        material.metallic = 0.0f;
        if (!large) material.base_color_texture.texture = edit.add(Texture{.name = "noise", .image = edit.add(std::move(image))});
        builtin::add_object(edit, "cell", make_grid(side_of(double(triangles) / 2 / (large ? 1 : kTextures)), {large ? -1.0f : float(i % 32), 0.0f, float(i / 32)}), edit.add(std::move(material)));
    }
    edit.set_environment({.scale = glm::vec3(1.0f)});
    builtin::add_camera(edit, "above", {16.0f, 12.0f, 45.0f}, {16.0f, 0.0f, 16.0f}, 0.8f);
    return make_scene(std::move(edit));
}

uint64_t scene_bytes(const Scene& scene) {
    uint64_t bytes = 0;
    for (const auto& [handle, mesh] : scene.meshes())
        for (const Primitive& p : mesh.primitives)
            bytes += p.positions.size() * (2 * sizeof(glm::vec3) + sizeof(glm::vec2)) + p.triangles.size() * sizeof(glm::uvec3);
    for (const auto& [handle, image] : scene.images()) bytes += image.texels.size();
    return bytes;
}

class LargeScene : public GpuTest {};

TEST_F(LargeScene, loads_in_slices_and_bounded_memory) {
    const char* wanted = std::getenv("PARHELION_SOAK_TRIANGLES");
    const uint64_t triangles = wanted ? std::strtoull(wanted, nullptr, 10) : 2'000'000;
    for (const gpu::TraceWay way : kWays) {
        if (!device()->caps().supports(way) || (way == gpu::TraceWay::Pipeline && device()->caps().ray_query)) continue;
        // Without the layers: they would be what is measured.
        const gpu::DevicePtr plain = gpu::Device::open({});
        const bool hardware = way != gpu::TraceWay::Compute;
        Stage stage(make_large(triangles), {.hardware = hardware, .own_bvh = !hardware}, {}, plain);
        const uint64_t host_before = platform::peak_resident_bytes(), size = scene_bytes(stage.scene);
        const double begin = seconds();
        double longest = 0;
        uint32_t slices = 0;
        for (;; ++slices) {
            const double slice_begin = seconds();
            const bool complete = stage.scene_gpu.update(stage.frame).complete;
            stage.frame.run();
            longest = std::max(longest, seconds() - slice_begin);
            if (complete) break;
        }
        const SceneGpuStats& stats = stage.scene_gpu.stats();
        uint64_t device_bytes = 0;
        for (const gpu::MemoryUse& use : plain->memory_use()) device_bytes += use.bytes;
        std::printf("%s: %llu triangles, %u textures: %.2f s in %u slices, the longest %.2f s (own bottom levels %.2f s); scene %.0f MB, host peak %.0f MB (%.0f MB before), device %.0f MB, peak %.0f MB; "
                    "bottom levels %.0f MB built, %.0f MB kept\n",
                    std::string(gpu::trace_way_name(way)).c_str(), static_cast<unsigned long long>(stats.triangles), stats.textures, seconds() - begin, slices + 1, longest, stats.own_build_seconds, double(size) / 1e6,
                    double(platform::peak_resident_bytes()) / 1e6, double(host_before) / 1e6, double(device_bytes) / 1e6, double(plain->peak_memory_bytes()) / 1e6, double(stats.bottom_bytes_built) / 1e6, double(stats.bottom_bytes) / 1e6);
        EXPECT_EQ(stats.textures, kTextures);
        EXPECT_GT(stats.triangles, triangles * 9 / 10);
        EXPECT_GE(slices, 4u);
        // Device memory: arrays, texture levels and bottom levels; staging and scratch memory come to a few slices.
        EXPECT_LT(plain->peak_memory_bytes(), 3 * size + 400 * stats.triangles + (1ull << 30));
        expect_sane(stage.picture({.way = way, .sample_count = 1}));
    }
}

}  // namespace
}  // namespace parhelion::testing::large_scene_test
