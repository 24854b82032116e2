// Rays that leave what was drawn must not begin behind the proxy, so it is measured how far that rises over each triangle.
#include "scene_gpu/proxies.h"

#include <bit>
#include <cmath>

#include "base/parallel.h"
#include "bvh/trace_host.h"
#include "scene/simplify.h"
#include "scene_gpu/state.h"

namespace parhelion {

namespace {

constexpr size_t kHeightGrain = 1024;
// How far off a proxy is looked for: error quadrics know a mean, of which single points were found to be up to ten times as far.
constexpr float kReachOverMean = 16.0f, kReachOverLimit = 4.0f;
constexpr float kBetweenPoints = 1.25f;  // what it may rise more between the points where that is measured

glm::vec3 cross_of(const std::vector<glm::vec3>& positions, glm::uvec3 t) { return glm::cross(positions[t.y] - positions[t.x], positions[t.z] - positions[t.x]); }

// A proxy as rays meet it, in the space of its object.
class ProxySurface {
public:
    ProxySurface(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles) : positions_(positions), triangles_(triangles) {
        const bvh::BottomGeometry geometry{positions, triangles};
        const bvh::TopItem item = bvh::make_top_item(bottoms_, bvh::add_bottom(bottoms_, std::span(&geometry, 1)), glm::mat4(1.0f), 0, 0xFFu, shared::kBvhOpaque);
        top_ = bvh::build_top(std::span(&item, 1), bottoms_.nodes.layout);
    }

    // How far the proxy lies off `point` along unit `direction`, if that is in reach: only by the side that it shows to those who come from
    // behind it, or from before it. Whatever else is met first belongs to another part of the object.
    float distance(glm::vec3 point, glm::vec3 direction, float reach, bool from_behind) const {
        const shared::TraversalRay ray{.origin_ws = point, .t_min = 0.0f, .direction_ws = direction, .t_max = reach, .mask = 0xFFu, .alpha_key = 0};
        shared::TraversalHit hit;
        if (!bvh::trace_closest_host(bottoms_, top_, ray, hit)) return 0.0f;
        return (glm::dot(cross_of(positions_, triangles_[hit.primitive]), direction) > 0.0f) == from_behind ? hit.t : 0.0f;
    }

private:
    const std::vector<glm::vec3>& positions_;
    const std::vector<glm::uvec3>& triangles_;
    bvh::Bottoms bottoms_;
    bvh::Top top_;
};

// The upper half of a float, rounded up.
uint32_t upper_half(float value) { return (std::bit_cast<uint32_t>(value) + 0xFFFFu) >> 16; }

// How far a proxy rises over a point along the surface's normal, and along the opposite.
struct Rise {
    float before = 0.0f, behind = 0.0f;
};
Rise highest(const Rise& a, const Rise& b) { return {std::max(a.before, b.before), std::max(a.behind, b.behind)}; }
uint32_t pack_rise(const Rise& rise) { return upper_half(kBetweenPoints * rise.before) << 16 | upper_half(kBetweenPoints * rise.behind); }

// `normal` has any length; none without one.
Rise rise_over(const ProxySurface& proxy, glm::vec3 point, glm::vec3 normal, float reach) {
    const float length = glm::length(normal);
    if (!(length > 0.0f)) return {};
    const glm::vec3 n = normal / length;
    return {proxy.distance(point, n, reach, true), proxy.distance(point, -n, reach, false)};
}

// Over each vertex, along the mean normal of its triangles. Where a surface has an edge, each side has vertices of its own.
std::vector<Rise> rise_over_vertices(const Primitive& primitive, const ProxySurface& proxy, float reach) {
    std::vector<glm::vec3> normals(primitive.positions.size(), glm::vec3(0.0f));
    for (const glm::uvec3& t : primitive.triangles)
        for (int corner = 0; corner < 3; ++corner) normals[t[corner]] += cross_of(primitive.positions, t);
    std::vector<Rise> rises(normals.size());
    parallel_for(rises.size(), kHeightGrain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) rises[i] = rise_over(proxy, primitive.positions[i], normals[i], reach);
    });
    return rises;
}

// Proxy::heights: the most of a triangle's corners and its middle.
std::vector<uint32_t> measure_heights(const Primitive& primitive, const std::vector<glm::uvec3>& triangles, float reach) {
    const ProxySurface proxy(primitive.positions, triangles);
    const std::vector<Rise> corners = rise_over_vertices(primitive, proxy, reach);
    std::vector<uint32_t> heights(primitive.triangles.size());
    parallel_for(heights.size(), kHeightGrain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const glm::uvec3 t = primitive.triangles[i];
            const glm::vec3 middle = (primitive.positions[t.x] + primitive.positions[t.y] + primitive.positions[t.z]) / 3.0f;
            const Rise rise = rise_over(proxy, middle, cross_of(primitive.positions, t), reach);
            heights[i] = pack_rise(highest(rise, highest(corners[t.x], highest(corners[t.y], corners[t.z]))));
        }
    });
    return heights;
}

float longest_side(const Bounds& bounds) {
    const glm::vec3 size = bounds.max - bounds.min;
    return std::max({size.x, size.y, size.z, 0.0f});
}

// What deforms keeps its triangles: its forms have them too, elsewhere.
bool is_rigid(const Primitive& primitive) { return primitive.targets.empty() && primitive.joints.empty(); }

}  // namespace

Proxy make_proxy(const Primitive& primitive, float ratio, float deviation) {
    SimplifiedTriangles simplified = simplify_triangles(primitive, {.ratio = ratio, .deviation = deviation});
    if (simplified.triangles.empty()) return {};
    const float reach = std::min(kReachOverMean * simplified.deviation, kReachOverLimit * deviation);
    Proxy proxy{.triangles = std::move(simplified.triangles), .heights = {}};
    proxy.heights = measure_heights(primitive, proxy.triangles, reach);
    return proxy;
}

bool takes_proxies(const Material& material) { return material.alpha_mode == AlphaMode::Opaque && material.emission == glm::vec3(0.0f) && (material.transmission == 0.0f || material.unlit); }

uint64_t MeshOnDevice::traced_triangles() const {
    uint64_t count = triangle_count;
    for (size_t i = 0; i < parts.size(); ++i)
        if (has_proxy(i)) count -= parts[i].triangle_count - parts[i].proxy_count;
    return count;
}

// The next meshes', as many as the slice has triangles for, of every part that could ever have one: which ones rays meet follows the
// materials of the moment, and triangles keep their numbers.
void SceneGpu::State::make_proxies(Slice& slice) {
    if (!uses_proxies()) return;
    struct Job {
        const Primitive& primitive;
        float deviation;
        Proxy& proxy;
    };
    std::vector<Job> jobs;
    for (const Handle<Mesh> handle : resident_meshes) {
        MeshOnDevice& mesh = meshes.at(handle);
        if (!mesh.proxies.empty() || mesh.made_here || !needs_geometry(mesh)) continue;
        if (!slice.has_triangles()) break;
        const Mesh& source = scene->get(handle);
        slice.take_triangles(mesh.triangle_count);
        mesh.proxies.resize(source.primitives.size());
        if (mesh.rest) continue;
        for (size_t i = 0; i < source.primitives.size(); ++i)
            if (is_rigid(source.primitives[i])) jobs.push_back({source.primitives[i], options.proxy_error * longest_side(source.bounds), mesh.proxies[i]});
    }
    parallel_for(jobs.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) jobs[i].proxy = make_proxy(jobs[i].primitive, options.proxy_ratio, jobs[i].deviation);
    });
}

// Bottom levels follow the materials, and whether anything is a deformed form of the mesh.
void SceneGpu::State::choose_proxies() {
    if (!uses_proxies()) return;
    for (const Handle<Mesh> handle : resident_meshes) {
        MeshOnDevice& mesh = meshes.at(handle);
        const Mesh& source = scene->get(handle);
        std::vector<bool> chosen(mesh.proxies.size());
        for (size_t i = 0; i < chosen.size(); ++i) chosen[i] = !mesh.has_forms && !mesh.proxies[i].triangles.empty() && takes_proxies(scene->get(source.primitives[i].material));
        if (chosen == mesh.traces_proxy) continue;
        mesh.traces_proxy = std::move(chosen);
        mesh.blas = {};
        retire_own(mesh);
    }
}

void SceneGpu::State::retire_own(MeshOnDevice& mesh) {
    retired_rows.push_back({mesh.own_nodes, mesh.own_node_count, mesh.own_triangles, mesh.own_triangle_count, mesh.drawn_at});
    mesh.own_nodes = mesh.own_node_count = mesh.own_triangles = mesh.own_triangle_count = mesh.own_done_rows = 0;
    mesh.own_host.reset();
    mesh.own_ready = false;
}

void SceneGpu::State::forget_retired() {
    std::erase_if(retired_rows, [&](const RetiredRows& rows) {
        if (rows.drawn_at + 1 >= published && rows.drawn_at != 0) return false;
        bottom_nodes.give(rows.nodes, rows.node_count);
        bottom_triangles.give(rows.triangles, rows.triangle_count);
        return true;
    });
}

}  // namespace parhelion
