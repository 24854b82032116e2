#include "scene/tangents.h"

#include <bit>
#include <cmath>
#include <unordered_map>

#include "base/hash.h"

namespace parhelion {

namespace {

// `width` values belong to each vertex.
template <class V>
void gather(std::vector<V>& values, const std::vector<uint32_t>& sources, size_t width = 1) {
    if (values.empty()) return;
    std::vector<V> out;
    out.reserve(sources.size() * width);
    for (const uint32_t source : sources)
        for (size_t i = 0; i < width; ++i) out.push_back(values[source * width + i]);
    values = std::move(out);
}

// Vertex i of the result is vertex sources[i] of before.
void rearrange_vertices(Primitive& primitive, const std::vector<uint32_t>& sources) {
    gather(primitive.positions, sources);
    gather(primitive.normals, sources);
    gather(primitive.tangents, sources);
    gather(primitive.uv0, sources);
    gather(primitive.uv1, sources);
    gather(primitive.colors, sources);
    gather(primitive.joints, sources, primitive.influence_count);
    gather(primitive.joint_weights, sources, primitive.influence_count);
    for (MorphTarget& target : primitive.targets) {
        gather(target.positions, sources);
        gather(target.normals, sources);
        gather(target.tangents, sources);
    }
}

// Corners with the same key share one tangent.
struct CornerKey {
    uint32_t bits[9];  // position, normal, UV, handedness
    friend bool operator==(const CornerKey&, const CornerKey&) = default;
};
struct CornerHash {
    size_t operator()(const CornerKey& key) const { return hash_bytes(key.bits, sizeof(key.bits)); }
};

CornerKey make_key(glm::vec3 p, glm::vec3 n, glm::vec2 uv, bool mirrored) {
    const auto bits = [](float x) { return std::bit_cast<uint32_t>(x + 0.0f); };  // -0 counts as 0
    return {{bits(p.x), bits(p.y), bits(p.z), bits(n.x), bits(n.y), bits(n.z), bits(uv.x), bits(uv.y), mirrored ? 1u : 0u}};
}

glm::dvec3 unit_or_zero(glm::dvec3 v) {
    const double length = glm::length(v);
    return length > 0.0 ? v / length : glm::dvec3(0.0);
}

double angle_between(glm::dvec3 a, glm::dvec3 b) { return std::acos(glm::clamp(glm::dot(unit_or_zero(a), unit_or_zero(b)), -1.0, 1.0)); }

struct FaceTangent {
    glm::dvec3 direction{0.0};  // along +u, not unit; zero: degenerate UVs
    bool mirrored = false;      // the UV triangle is the mirror image of the triangle
};

FaceTangent face_tangent(const glm::vec3 (&p)[3], const glm::vec2 (&uv)[3]) {
    const glm::dvec3 e1 = glm::dvec3(p[1]) - glm::dvec3(p[0]), e2 = glm::dvec3(p[2]) - glm::dvec3(p[0]);
    const glm::dvec2 d1 = glm::dvec2(uv[1]) - glm::dvec2(uv[0]), d2 = glm::dvec2(uv[2]) - glm::dvec2(uv[0]);
    const double area = d1.x * d2.y - d2.x * d1.y;
    if (area == 0.0) return {};
    // v points down in the image: a UV triangle that is not mirrored runs clockwise in (u, v), with negative area.
    const bool mirrored = area > 0.0;
    return {(e1 * d2.y - e2 * d1.y) * (mirrored ? 1.0 : -1.0), mirrored};
}

class TangentSums {
public:
    explicit TangentSums(size_t corner_count) { sums_.reserve(corner_count); }
    uint32_t group(const CornerKey& key) {
        const auto [entry, added] = sums_by_key_.try_emplace(key, static_cast<uint32_t>(sums_.size()));
        if (added) sums_.emplace_back(0.0);
        return entry->second;
    }
    void add(uint32_t group, glm::dvec3 tangent) { sums_[group] += tangent; }
    glm::dvec3 sum(uint32_t group) const { return sums_[group]; }

private:
    std::unordered_map<CornerKey, uint32_t, CornerHash> sums_by_key_;
    std::vector<glm::dvec3> sums_;
};

constexpr uint32_t kNoGroup = 0xFFFFFFFFu;

}  // namespace

void unshare_with_flat_normals(Primitive& primitive) {
    std::vector<uint32_t> sources;
    sources.reserve(primitive.triangles.size() * 3);
    for (glm::uvec3& t : primitive.triangles) {
        const uint32_t base = static_cast<uint32_t>(sources.size());
        sources.insert(sources.end(), {t.x, t.y, t.z});
        t = glm::uvec3(base, base + 1, base + 2);
    }
    rearrange_vertices(primitive, sources);
    primitive.normals.assign(primitive.positions.size(), glm::vec3(0.0f));
    for (const glm::uvec3& t : primitive.triangles) {
        const glm::dvec3 a(primitive.positions[t.x]), b(primitive.positions[t.y]), c(primitive.positions[t.z]);
        const glm::vec3 normal(unit_or_zero(glm::cross(b - a, c - a)));
        primitive.normals[t.x] = primitive.normals[t.y] = primitive.normals[t.z] = normal;
    }
}

void generate_tangents(Primitive& primitive, uint32_t uv_set) {
    const std::vector<glm::vec2>& uvs = uv_set == 0 ? primitive.uv0 : primitive.uv1;
    primitive.tangents.clear();
    if (uvs.empty() || primitive.normals.empty()) return;

    const size_t vertex_count = primitive.positions.size();
    TangentSums sums(vertex_count);
    // A vertex belongs to at most two groups: one for each handedness.
    std::vector<uint32_t> groups[2] = {std::vector<uint32_t>(vertex_count, kNoGroup), std::vector<uint32_t>(vertex_count, kNoGroup)};
    std::vector<uint8_t> triangle_mirrored;
    triangle_mirrored.reserve(primitive.triangles.size());
    for (const glm::uvec3& t : primitive.triangles) {
        const glm::vec3 p[3] = {primitive.positions[t.x], primitive.positions[t.y], primitive.positions[t.z]};
        const glm::vec2 uv[3] = {uvs[t.x], uvs[t.y], uvs[t.z]};
        const FaceTangent face = face_tangent(p, uv);
        triangle_mirrored.push_back(face.mirrored ? 1 : 0);
        for (int corner = 0; corner < 3; ++corner) {
            const uint32_t vertex = t[corner];
            uint32_t& group = groups[face.mirrored ? 1 : 0][vertex];
            if (group == kNoGroup) group = sums.group(make_key(p[corner], primitive.normals[vertex], uv[corner], face.mirrored));
            const glm::dvec3 n(primitive.normals[vertex]);
            const auto in_plane = [&](glm::dvec3 v) { return v - n * glm::dot(n, v); };
            const glm::dvec3 here(p[corner]), next(p[(corner + 1) % 3]), previous(p[(corner + 2) % 3]);
            sums.add(group, unit_or_zero(in_plane(face.direction)) * angle_between(in_plane(next - here), in_plane(previous - here)));
        }
    }

    std::vector<uint32_t> sources(vertex_count), split(vertex_count, kNoGroup);
    for (uint32_t i = 0; i < vertex_count; ++i) sources[i] = i;
    std::vector<glm::vec4> tangents(vertex_count, glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
    const auto tangent_of = [&](uint32_t group, bool mirrored) {
        return glm::vec4(glm::vec3(unit_or_zero(sums.sum(group))), mirrored ? -1.0f : 1.0f);
    };
    for (size_t i = 0; i < primitive.triangles.size(); ++i) {
        const bool mirrored = triangle_mirrored[i] != 0;
        for (int corner = 0; corner < 3; ++corner) {
            uint32_t& vertex = primitive.triangles[i][corner];
            const uint32_t group = groups[mirrored ? 1 : 0][vertex];
            if (mirrored && groups[0][vertex] != kNoGroup) {
                if (split[vertex] == kNoGroup) {
                    split[vertex] = static_cast<uint32_t>(sources.size());
                    sources.push_back(vertex);
                    tangents.push_back(tangent_of(group, true));
                }
                vertex = split[vertex];
            } else {
                tangents[vertex] = tangent_of(group, mirrored);
            }
        }
    }
    if (sources.size() != vertex_count) rearrange_vertices(primitive, sources);
    primitive.tangents = std::move(tangents);
}

}  // namespace parhelion
