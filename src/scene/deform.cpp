#include "scene/deform.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace parhelion {

namespace {

constexpr size_t kVerticesAtOnce = 4096;

glm::dvec3 unit_or(glm::dvec3 v, glm::dvec3 otherwise) {
    const double length = glm::length(v);
    return length > 0.0 ? v / length : otherwise;
}

// Without what deforms it.
Primitive plain_copy(const Primitive& p) {
    return {.positions = p.positions, .normals = p.normals, .tangents = p.tangents, .uv0 = p.uv0, .uv1 = p.uv1, .colors = p.colors,
            .triangles = p.triangles, .material = p.material, .variant_materials = p.variant_materials};
}

void morph(const Primitive& rest, const std::vector<float>& weights, Primitive& out) {
    std::vector<std::pair<const MorphTarget*, double>> active;
    for (size_t i = 0; i < std::min(weights.size(), rest.targets.size()); ++i)
        if (weights[i] != 0.0f) active.emplace_back(&rest.targets[i], weights[i]);
    if (active.empty()) return;
    const auto moved = [&](glm::dvec3 v, std::vector<glm::vec3> MorphTarget::*deltas, size_t i) {
        for (const auto& [target, weight] : active)
            if (!(target->*deltas).empty()) v += weight * glm::dvec3((target->*deltas)[i]);
        return v;
    };
    parallel_for(out.positions.size(), kVerticesAtOnce, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            out.positions[i] = glm::vec3(moved(glm::dvec3(rest.positions[i]), &MorphTarget::positions, i));
            if (!out.normals.empty()) {
                const glm::dvec3 n(rest.normals[i]);
                out.normals[i] = glm::vec3(unit_or(moved(n, &MorphTarget::normals, i), n));
            }
            if (!out.tangents.empty()) {
                const glm::dvec3 t(rest.tangents[i]);
                out.tangents[i] = glm::vec4(glm::vec3(unit_or(moved(t, &MorphTarget::tangents, i), t)), rest.tangents[i].w);
            }
        }
    });
}

// `rest` has the joints and weights of the vertices of `out`, which holds them before the skin.
void skin(const Primitive& rest, const std::vector<glm::mat4x3>& object_from_rest, bool may_mirror, Primitive& out) {
    const uint32_t n = rest.influence_count;
    std::vector<uint8_t> mirrored(out.positions.size(), 0);
    parallel_for(out.positions.size(), kVerticesAtOnce, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            glm::dmat4x3 blended(0.0);
            for (size_t k = i * n; k < (i + 1) * n; ++k)
                if (rest.joint_weights[k] != 0.0f) blended += double(rest.joint_weights[k]) * glm::dmat4x3(object_from_rest[rest.joints[k]]);
            out.positions[i] = glm::vec3(blended * glm::dvec4(out.positions[i], 1.0));
            const glm::dmat3 m(blended);
            // The cofactors are the inverse transpose times the determinant, and need no inverse.
            const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
            const double side = may_mirror && glm::dot(m[0], cofactors[0]) < 0.0 ? -1.0 : 1.0;
            mirrored[i] = side < 0.0 ? 1 : 0;
            if (!out.normals.empty()) out.normals[i] = glm::vec3(unit_or(side * (cofactors * glm::dvec3(out.normals[i])), glm::dvec3(0.0)));
            if (!out.tangents.empty()) {
                const glm::vec4 t = out.tangents[i];
                out.tangents[i] = glm::vec4(glm::vec3(unit_or(m * glm::dvec3(t), glm::dvec3(0.0))), t.w * static_cast<float>(side));
            }
        }
    });
    for (glm::uvec3& t : out.triangles)
        if (mirrored[t.x] + mirrored[t.y] + mirrored[t.z] >= 2) std::swap(t.y, t.z);
}

// The box of a box that an affine map takes along; roundings of a float computation, and of weights that sum to 1 but for them, stay inside.
Bounds moved_box(const glm::mat4x3& m, const Bounds& box) {
    constexpr double kSlack = 2e-5;
    const glm::dvec3 center = 0.5 * (glm::dvec3(box.min) + glm::dvec3(box.max)), half = glm::dvec3(box.max) - center;
    const glm::dmat4x3 d(m);
    glm::dvec3 at = d * glm::dvec4(center, 1.0), reach(0.0), size = glm::abs(d[3]);
    for (int column = 0; column < 3; ++column) {
        reach += glm::abs(d[column]) * half[column];
        size += glm::abs(d[column]) * std::max(std::abs(double(box.min[column])), std::abs(double(box.max[column])));
    }
    reach += kSlack * size;
    Bounds out;
    out.add(glm::vec3(at - reach));
    out.add(glm::vec3(at + reach));
    return out;
}

}  // namespace

bool any_mirrors(const MeshDeformation& deformation) {
    return std::ranges::any_of(deformation.object_from_rest, [](const glm::mat4x3& m) { return glm::determinant(glm::dmat3(glm::mat3(m))) < 0.0; });
}

Primitive deformed(const Primitive& rest, const MeshDeformation& deformation) {
    Primitive out = plain_copy(rest);
    morph(rest, deformation.weights, out);
    if (!deformation.object_from_rest.empty() && rest.influence_count != 0) skin(rest, deformation.object_from_rest, any_mirrors(deformation), out);
    return out;
}

Mesh deformed(const Mesh& rest, Handle<Mesh> handle, const MeshDeformation& deformation) {
    Mesh out{.name = rest.name};
    out.rest = handle;
    for (const Primitive& primitive : rest.primitives) out.primitives.push_back(deformed(primitive, deformation));
    return out;
}

Bounds deformed_bounds(const Primitive& rest, const MeshDeformation& deformation) {
    glm::dvec3 low(0.0), high(0.0);  // how far the morph targets move a vertex at most
    for (size_t i = 0; i < std::min(deformation.weights.size(), rest.targets.size()); ++i) {
        const Bounds& reach = rest.targets[i].reach;
        if (reach.empty()) continue;
        const glm::dvec3 a = double(deformation.weights[i]) * glm::dvec3(reach.min), b = double(deformation.weights[i]) * glm::dvec3(reach.max);
        low += glm::min(a, b), high += glm::max(a, b);
    }
    const auto morphed = [&](const Bounds& box) {
        Bounds out;
        out.add(glm::vec3(glm::dvec3(box.min) + low));
        out.add(glm::vec3(glm::dvec3(box.max) + high));
        return out;
    };
    Bounds out;
    if (rest.bounds.empty()) return out;
    if (deformation.object_from_rest.empty() || rest.influence_count == 0) {
        out.add(moved_box(glm::mat4x3(1.0f), morphed(rest.bounds)));
        return out;
    }
    for (size_t joint = 0; joint < rest.joint_bounds.size(); ++joint)
        if (!rest.joint_bounds[joint].empty()) out.add(moved_box(deformation.object_from_rest[joint], morphed(rest.joint_bounds[joint])));
    return out;
}

const Primitive& drawn_shape(const Scene& scene, const Mesh& mesh, size_t primitive, Primitive& storage) {
    if (!mesh.deformation) return mesh.primitives[primitive];
    storage = deformed(scene.get(mesh.rest).primitives[primitive], *mesh.deformation);
    return storage;
}

void detail::keep_bounds(Primitive& primitive) {
    primitive.bounds = {};
    for (const glm::vec3& p : primitive.positions) primitive.bounds.add(p);
    for (MorphTarget& target : primitive.targets) {
        target.reach = {};
        if (!target.positions.empty()) target.reach.add(glm::vec3(0.0f));
        for (const glm::vec3& delta : target.positions) target.reach.add(delta);
    }
    primitive.joint_bounds.clear();
    const uint32_t n = primitive.influence_count;
    for (size_t k = 0; k < primitive.joints.size(); ++k) {
        if (primitive.joint_weights[k] == 0.0f) continue;
        const uint16_t joint = primitive.joints[k];
        if (joint >= primitive.joint_bounds.size()) primitive.joint_bounds.resize(joint + size_t(1));
        primitive.joint_bounds[joint].add(primitive.positions[k / n]);
    }
}

}  // namespace parhelion
