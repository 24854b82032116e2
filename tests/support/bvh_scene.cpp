#include "support/bvh_scene.h"

#include <map>

#include <fmt/format.h>

namespace parhelion::bvh::testing {

TestGeometry make_icosphere(uint32_t levels, float radius, glm::vec3 middle) {
    const float g = 1.6180340f;
    TestGeometry s{{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0}, {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g}, {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}},
                   {{0, 11, 5}, {0, 5, 1}, {0, 1, 7}, {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4}, {3, 4, 2}, {3, 2, 6}, {3, 6, 8}, {3, 8, 9}, {4, 9, 5}, {2, 4, 11}, {6, 2, 10}, {8, 6, 7}, {9, 8, 1}}};
    for (uint32_t level = 0; level < levels; ++level) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        const auto halfway = [&](uint32_t a, uint32_t b) {
            const auto [at, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<uint32_t>(s.positions.size()));
            if (is_new) s.positions.push_back(0.5f * (s.positions[a] + s.positions[b]));
            return at->second;
        };
        std::vector<glm::uvec3> finer;
        for (const glm::uvec3 t : s.triangles) {
            const uint32_t ab = halfway(t.x, t.y), bc = halfway(t.y, t.z), ca = halfway(t.z, t.x);
            finer.insert(finer.end(), {{t.x, ab, ca}, {t.y, bc, ab}, {t.z, ca, bc}, {ab, bc, ca}});
        }
        s.triangles = std::move(finer);
    }
    for (glm::vec3& p : s.positions) p = glm::normalize(p) * radius + middle;
    return s;
}

TestGeometry make_box(glm::vec3 low, glm::vec3 high) {
    TestGeometry box;
    for (int corner = 0; corner < 8; ++corner) box.positions.push_back({(corner & 1) ? high.x : low.x, (corner & 2) ? high.y : low.y, (corner & 4) ? high.z : low.z});
    box.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    return box;
}

Layout TestScene::layout = Layout::Four;

void append(TestGeometry& to, const TestGeometry& from) {
    const auto first = static_cast<uint32_t>(to.positions.size());
    to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
    for (const glm::uvec3 t : from.triangles) to.triangles.push_back(t + first);
}

TestGeometry make_hall(Random& random) {
    TestGeometry hall = make_box(glm::vec3(-10.0f), glm::vec3(10.0f));
    for (int i = 0; i < 100; ++i) {
        TestGeometry beam = make_box(glm::vec3(0.0f), glm::vec3(1.0f));
        const glm::vec3 a = random.in_cube(9.0f), z = random.direction(), x = glm::normalize(glm::cross(z, random.direction())), y = glm::cross(z, x);
        const glm::mat3 sides(0.1f * x, 0.1f * y, random.range(3.0f, 10.0f) * z);
        for (glm::vec3& p : beam.positions) p = a + sides * p;
        append(hall, beam);
    }
    for (int i = 0; i < 60; ++i) append(hall, make_icosphere(2, random.range(0.1f, 0.5f), random.in_cube(9.0f)));
    return hall;
}

TestScene::TestScene(std::vector<TestMesh> all_meshes, std::vector<TestInstance> all_instances) : meshes(std::move(all_meshes)), instances(std::move(all_instances)) {
    bottoms.nodes.layout = layout;
    for (const TestMesh& mesh : meshes) {
        std::vector<BottomGeometry> geometries;
        for (const TestGeometry& geometry : mesh) geometries.push_back({geometry.positions, geometry.triangles});
        add_bottom(bottoms, geometries);
    }
    for (uint32_t i = 0; i < instances.size(); ++i)
        items.push_back(make_top_item(bottoms, instances[i].mesh, instances[i].world_from_object, i, instances[i].mask));
    top = build_top(items, layout);
}

bool trace_brute_force(const TestScene& scene, const shared::TraversalRay& ray, shared::TraversalHit& best, const AcceptHit& accept) {
    bool found = false;
    best.t = ray.t_max;
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const shared::BvhTopItem& item = scene.items[i].item;
        if ((item.mask & ray.mask) == 0) continue;
        const glm::vec3 p = ray.origin_ws - item.origin_ws, d = ray.direction_ws;
        const shared::ShearedRay sheared = shared::make_sheared_ray({glm::dot(item.row0, p), glm::dot(item.row1, p), glm::dot(item.row2, p)},
                                                                    {glm::dot(item.row0, d), glm::dot(item.row1, d), glm::dot(item.row2, d)});
        const TestMesh& mesh = scene.meshes[scene.instances[i].mesh];
        for (uint32_t g = 0; g < mesh.size(); ++g)
            for (uint32_t t = 0; t < mesh[g].triangles.size(); ++t) {
                const glm::uvec3 index = mesh[g].triangles[t];
                shared::TriangleHit hit;
                if (!shared::intersect_watertight(sheared, mesh[g].positions[index.x], mesh[g].positions[index.y], mesh[g].positions[index.z], false, hit)) continue;
                // In order of the ids, so an equal distance never replaces what is there.
                if (!(hit.t > ray.t_min && hit.t < best.t) || (accept && !accept(i, g, t, hit.barycentrics, hit.front_facing))) continue;
                best = {i, g, t, hit.barycentrics, hit.t};
                found = true;
            }
    }
    return found;
}

std::string compare_with_brute_force(const TestScene& scene, const shared::TraversalRay& ray, const AcceptHit& accept) {
    shared::TraversalHit hit{}, expected{};
    const bool found = trace_closest_host(scene.bottoms, scene.top, ray, hit, accept), expected_found = trace_brute_force(scene, ray, expected, accept);
    const auto text = [](bool any, const shared::TraversalHit& h) {
        return any ? fmt::format("({}, {}, {}) at {} with {} {}", h.instance, h.geometry, h.primitive, h.t, h.barycentrics.x, h.barycentrics.y) : std::string("nothing");
    };
    if (text(found, hit) != text(expected_found, expected)) return fmt::format("the traversal finds {}, brute force {}", text(found, hit), text(expected_found, expected));
    if (trace_any_host(scene.bottoms, scene.top, ray, accept) != expected_found) return "closest and any hit differ";
    return {};
}

}  // namespace parhelion::bvh::testing
