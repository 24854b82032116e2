#pragma once
// Rays that leave random points of random triangles by both spawn offsets (tests/device/shaders/spawn.trace): which of them meet
// their own triangle, and how far from it they start.
#include <array>
#include <cmath>
#include <cstdio>

#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

#include "scene/builtin/scenes.h"
#include "support/bvh_scene.h"
#include "support/render_fixture.h"

namespace parhelion::testing {

// Sums by the decade of the point's largest coordinate, from 1e-7 to 1e7 metres.
struct SpawnCounts {
    static constexpr int kDecades = 14, kFirst = -7;
    struct Decade {
        uint64_t rays = 0;
        std::array<uint64_t, 2> met = {};   // its own triangle; by error bounds, by integers
        std::array<uint64_t, 2> leaks = {};  // started more than a hundredth of the triangle's longest edge away
    };
    std::array<Decade, kDecades> decades = {};
    std::string met;  // the rays by error bounds that met their own triangle, one a line

    Decade total() const {
        Decade sum;
        for (const Decade& d : decades) {
            sum.rays += d.rays;
            for (size_t way : {0, 1}) sum.met[way] += d.met[way], sum.leaks[way] += d.leaks[way];
        }
        return sum;
    }
    void print(const char* title) const {
        std::printf("%s\n  largest coordinate      rays  own triangle met: bounds, integers   started > 1%% of the triangle away: bounds, integers\n", title);
        for (int i = 0; i < kDecades; ++i)
            if (const Decade& d = decades[static_cast<size_t>(i)]; d.rays != 0)
                std::printf("  1e%+d to 1e%+d m  %11llu  %18llu %16.4f %%  %29.4f %% %12.4f %%\n", i + kFirst, i + kFirst + 1, static_cast<unsigned long long>(d.rays),
                            static_cast<unsigned long long>(d.met[0]), 100.0 * double(d.met[1]) / double(d.rays), 100.0 * double(d.leaks[0]) / double(d.rays), 100.0 * double(d.leaks[1]) / double(d.rays));
    }
};

// Triangles in the world about points |p| of 1e-6 to 1e6 metres, a quarter of them about a point of a coordinate plane (half of these
// in it, where positions are exact) and half of them up to a thousand times as large as that, and instances that are turned, stretched and moved as much.
class SpawnScene {
public:
    static constexpr uint32_t kWorldTriangles = 1500, kInstances = 20, kInstanceTriangles = 50;

    explicit SpawnScene(uint32_t seed) : random_(seed), seed_(seed), stage_(make()) {}

    void count(gpu::TraceWay way, uint32_t rays_per_triangle, SpawnCounts& counts) {
        struct Spawned {
            uint32_t found;
            float size, edge;
            glm::vec2 distances;
        };
        struct Push {
            uint64_t triangles = 0, spawned = 0;
            uint32_t count, seed;
        };
        std::vector<glm::uvec2> triangles;
        for (uint32_t ray = 0; ray < rays_per_triangle; ++ray) {
            for (uint32_t t = 0; t < kWorldTriangles; ++t) triangles.emplace_back(0, t);
            for (uint32_t i = 1; i <= kInstances; ++i)
                for (uint32_t t = 0; t < kInstanceTriangles; ++t) triangles.emplace_back(i, t);
        }
        Frame& frame = stage_.frame;
        const auto size = static_cast<uint32_t>(triangles.size());
        const gpu::Buffer input(frame.device(), "test/triangles", size * sizeof(glm::uvec2)), output(frame.device(), "test/spawned", size * sizeof(Spawned));
        frame.upload(input, 0, std::as_bytes(std::span(triangles)));
        stage_.scene_gpu.finish(frame);
        frame.trace("device/spawn", way).scene(stage_.scene_gpu.binding()).read("triangles", input).write("spawned", output).push(Push{.count = size, .seed = seed_}).over(size);
        const gpu::Buffer copy = frame.read_back(output);
        frame.run();
        size_t ray = 0;
        for (const Spawned& s : copy.mapped_as<Spawned>()) {
            const glm::uvec2 from = triangles[ray++];
            if ((s.found & 1u) != 0)
                counts.met += fmt::format("instance {}, triangle {}: largest coordinate {:g}, longest edge {:g}, started {:g} from its plane\n", from.x, from.y, s.size, s.edge, s.distances[0]);
            const int decade = std::clamp(static_cast<int>(std::floor(std::log10(std::max(s.size, 1e-30f)))) - SpawnCounts::kFirst, 0, SpawnCounts::kDecades - 1);
            SpawnCounts::Decade& sum = counts.decades[static_cast<size_t>(decade)];
            ++sum.rays;
            for (const uint32_t offset : {0u, 1u}) {
                sum.met[offset] += (s.found >> offset) & 1u;
                sum.leaks[offset] += s.distances[static_cast<int>(offset)] > 0.01f * s.edge;
            }
        }
    }

private:
    float power(float low, float high) { return std::pow(10.0f, random_.range(low, high)); }
    void add_triangle(Primitive& p, glm::vec3 center, float size) {
        const auto first = static_cast<uint32_t>(p.positions.size());
        for (int corner = 0; corner < 3; ++corner) p.positions.push_back(center + random_.in_cube(size));
        p.triangles.emplace_back(first, first + 1, first + 2);
    }
    Scene make() {
        SceneEdit edit;
        Material both = builtin::lambert("both sides", glm::vec3(0.5f));
        both.double_sided = true;
        const Handle<Material> material = edit.add(std::move(both));
        Primitive world, object;
        for (uint32_t i = 0; i < kWorldTriangles; ++i) {
            const float away = power(-6.0f, 6.0f);
            glm::vec3 center = away * random_.direction();
            if (i % 4 == 0) center[int(i / 4 % 3)] = 0.0f;
            add_triangle(world, center, away * power(-3.0f, i % 2 == 0 ? 0.5f : 3.0f));
            if (i % 8 == 0)
                for (size_t corner = 0; corner < 3; ++corner) world.positions[3 * i + corner][int(i / 4 % 3)] = 0.0f;
        }
        for (uint32_t i = 0; i < kInstanceTriangles; ++i) add_triangle(object, random_.direction(), power(-2.0f, 0.0f));
        builtin::add_object(edit, "world", std::move(world), material);
        for (uint32_t i = 0; i < kInstances; ++i) {
            const float away = power(-6.0f, 6.0f);
            const Handle<Instance> instance = builtin::add_object(edit, "object", object, material);
            const glm::quat turn = glm::angleAxis(random_.range(0.0f, 6.0f), random_.direction());
            const glm::vec3 scale = away * power(-2.0f, 0.5f) * glm::vec3(power(-1.0f, 1.0f), power(-1.0f, 1.0f), i % 2 == 0 ? 1.0f : -1.0f);
            glm::mat4 place = glm::scale(glm::mat4_cast(turn), scale);
            // Every third puts a corner of its own far from the origin near the world's: there coordinates are small and errors large.
            if (i % 3 == 0) place[3] -= glm::vec4(glm::mat3(place) * object.positions[3 * i], 0.0f);
            place[3] += glm::vec4((i % 3 == 0 ? 1e-4f : 1.0f) * away * random_.direction(), 0.0f);
            edit.set_transform(instance, place);
        }
        return make_scene(std::move(edit));
    }

    bvh::testing::Random random_;
    uint32_t seed_;
    Stage stage_;
};

}  // namespace parhelion::testing
