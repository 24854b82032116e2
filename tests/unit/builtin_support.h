#pragma once
// What the tests of built-in scenes share.
#include <map>
#include <tuple>

#include "base/hash.h"
#include "scene/builtin.h"

namespace parhelion::testing {

template <class V>
void add(Hasher& hasher, const std::vector<V>& values) {
    hasher.add(values.size()).bytes(values.data(), values.size() * sizeof(V));
}

inline uint64_t hash_scene(const Scene& scene) {
    Hasher hasher;
    for (const auto& [handle, mesh] : scene.meshes())
        for (const Primitive& p : mesh.primitives) {
            add(hasher, p.positions);
            add(hasher, p.normals);
            add(hasher, p.tangents);
            add(hasher, p.uv0);
            add(hasher, p.triangles);
        }
    for (const auto& [handle, instance] : scene.instances()) hasher.bytes(&instance.place.world_from_object, sizeof(glm::mat4));
    for (const auto& [handle, image] : scene.images()) add(hasher, image.texels);
    for (const auto& [handle, m] : scene.materials())
        hasher.bytes(&m.base_color, sizeof(m.base_color)).bytes(&m.emission, sizeof(m.emission)).add(m.roughness);
    for (const auto& [handle, light] : scene.lights())
        hasher.bytes(&light.color, sizeof(light.color)).add(light.intensity).bytes(&light.place.world_from_object, sizeof(glm::mat4));
    add(hasher, scene.environment().radiance);
    return hasher.value();
}

inline double signed_volume(const Primitive& primitive) {
    double volume = 0.0;
    for (const glm::uvec3& t : primitive.triangles) {
        const glm::dvec3 a(primitive.positions[t.x]), b(primitive.positions[t.y]), c(primitive.positions[t.z]);
        volume += glm::dot(a, glm::cross(b, c)) / 6.0;
    }
    return volume;
}

// Closed: every directed edge, by position, has its opposite.
inline bool closed(const Primitive& primitive) {
    using Key = std::tuple<float, float, float, float, float, float>;
    std::map<Key, int> edges;
    for (const glm::uvec3& t : primitive.triangles)
        for (int i = 0; i < 3; ++i) {
            const glm::vec3 a = primitive.positions[t[i]] + 0.0f, b = primitive.positions[t[(i + 1) % 3]] + 0.0f;
            ++edges[{a.x, a.y, a.z, b.x, b.y, b.z}];
            --edges[{b.x, b.y, b.z, a.x, a.y, a.z}];
        }
    for (const auto& [edge, count] : edges)
        if (count != 0) return false;
    return true;
}

inline const Mesh& mesh_named(const Scene& scene, std::string_view name) {
    for (const auto& [handle, mesh] : scene.meshes())
        if (mesh.name == name) return mesh;
    throw Error(ErrorCode::Failed, "no such mesh");
}

// Made once in a process: a copy may be changed.
inline const LoadedScene& builtin_once(std::string_view name) {
    static std::map<std::string, LoadedScene, std::less<>> scenes;
    const auto found = scenes.find(name);
    return found != scenes.end() ? found->second : scenes.emplace(name, make_builtin(name)).first->second;
}

}  // namespace parhelion::testing
