#include "scene/gltf/skins.h"

#include <algorithm>
#include <cmath>

#include "scene/gltf/accessors.h"

namespace parhelion {

namespace {

constexpr size_t kMostSets = 16;  // of four joints: more are no skin, but work without end

struct InfluenceSet {
    std::vector<uint16_t> joints;
    std::vector<float> weights;
};

std::vector<InfluenceSet> read_sets(GltfDocument& document, const JsonRef& attributes, size_t vertex_count) {
    std::vector<InfluenceSet> sets;
    for (size_t n = 0;; ++n) {
        const std::string joints_name = fmt::format("JOINTS_{}", n), weights_name = fmt::format("WEIGHTS_{}", n);
        const std::optional<JsonRef> joints = attributes.find(joints_name), weights = attributes.find(weights_name);
        if (!joints && !weights) return sets;
        if (!joints || !weights) {
            document.warn(attributes, fmt::format("{} has no {} with it and is left out", joints ? joints_name : weights_name,
                                                  joints ? weights_name : joints_name));
            return sets;
        }
        if (n == kMostSets) joints->fail(fmt::format("is one set too many: at most {} joints move a vertex", 4 * kMostSets));
        InfluenceSet set{read_joint_numbers(document, *joints), read_numbers(document, *weights, 4, NumberKind::FloatOrNormalized)};
        if (set.joints.size() != 4 * vertex_count || set.weights.size() != 4 * vertex_count)
            (set.joints.size() != 4 * vertex_count ? joints : weights)
                ->fail(fmt::format("has {} elements, but there are {} positions",
                                   (set.joints.size() != 4 * vertex_count ? set.joints.size() : set.weights.size()) / 4, vertex_count));
        sets.push_back(std::move(set));
    }
}

// Makes the weights of each vertex sum to 1 and the joints of zero weights 0, whose numbers mean nothing.
void normalize_influences(GltfDocument& document, const JsonRef& attributes, Primitive& out) {
    const uint32_t n = out.influence_count;
    size_t off = 0;
    for (size_t vertex = 0; vertex < out.positions.size(); ++vertex) {
        float* weights = out.joint_weights.data() + vertex * n;
        uint16_t* joints = out.joints.data() + vertex * n;
        double sum = 0.0;
        bool negative = false;
        for (uint32_t i = 0; i < n; ++i) {
            negative = negative || weights[i] < 0.0f;
            weights[i] = std::max(weights[i], 0.0f);
            sum += weights[i];
        }
        if (negative || std::abs(sum - 1.0) > 1e-3) ++off;
        if (!(sum > 0.0)) weights[0] = 1.0f, sum = 1.0;
        for (uint32_t i = 0; i < n; ++i) {
            if (!is_unit(sum)) weights[i] = static_cast<float>(weights[i] / sum);
            if (weights[i] == 0.0f) joints[i] = 0;
        }
    }
    if (off != 0) document.warn(attributes, fmt::format("the joint weights of {} vertices did not sum to 1 and were scaled", off));
}

void read_deltas(GltfDocument& document, const JsonRef& target, std::string_view name, const Primitive& primitive,
                 std::vector<glm::vec3>& deltas) {
    const std::optional<JsonRef> use = target.find(name);
    if (!use) return;
    deltas = read_vectors<3>(document, *use);
    if (deltas.size() != primitive.positions.size())
        use->fail(fmt::format("has {} elements, but there are {} positions", deltas.size(), primitive.positions.size()));
}

void warn_of_other_deltas(GltfDocument& document, const JsonRef& target) {
    for (const std::string_view name : {"TEXCOORD_0", "TEXCOORD_1", "COLOR_0"})
        if (target.find(name)) document.warn(fmt::format("morph targets of {} are not drawn", name));
}

// The last row of an affine matrix; exporters round it.
void make_affine(const JsonRef& use, size_t index, glm::mat4& m) {
    const glm::vec4 last(m[0][3], m[1][3], m[2][3], m[3][3] - 1.0f);
    if (!(glm::length(last) <= 1e-3f)) use.fail(fmt::format("matrix {} is not affine", index), "its last row must be 0, 0, 0, 1");
    m[0][3] = m[1][3] = m[2][3] = 0.0f;
    m[3][3] = 1.0f;
}

}  // namespace

void read_influences(GltfDocument& document, const JsonRef& attributes, Primitive& out) {
    const std::vector<InfluenceSet> sets = read_sets(document, attributes, out.positions.size());
    if (sets.empty()) return;
    out.influence_count = static_cast<uint32_t>(4 * sets.size());
    const uint64_t count = uint64_t(out.influence_count) * out.positions.size();
    document.files().charge(count * (sizeof(uint16_t) + sizeof(float)), attributes.where());
    out.joints.reserve(count);
    out.joint_weights.reserve(count);
    for (size_t vertex = 0; vertex < out.positions.size(); ++vertex)
        for (const InfluenceSet& set : sets) {
            out.joints.insert(out.joints.end(), set.joints.begin() + ptrdiff_t(4 * vertex), set.joints.begin() + ptrdiff_t(4 * vertex + 4));
            out.joint_weights.insert(out.joint_weights.end(), set.weights.begin() + ptrdiff_t(4 * vertex),
                                     set.weights.begin() + ptrdiff_t(4 * vertex + 4));
        }
    normalize_influences(document, attributes, out);
}

void read_targets(GltfDocument& document, const JsonRef& primitive, Primitive& out) {
    const std::optional<JsonRef> targets = primitive.find_array("targets");
    if (!targets) return;
    document.files().charge(targets->size() * sizeof(MorphTarget), targets->where());
    for (size_t i = 0; i < targets->size(); ++i) {
        const JsonRef json = (*targets)[i];
        MorphTarget target;
        read_deltas(document, json, "POSITION", out, target.positions);
        if (!out.normals.empty()) read_deltas(document, json, "NORMAL", out, target.normals);
        if (!out.tangents.empty()) read_deltas(document, json, "TANGENT", out, target.tangents);
        warn_of_other_deltas(document, json);
        out.targets.push_back(std::move(target));
    }
}

uint64_t deformation_bytes(const Primitive& primitive) {
    uint64_t bytes = uint64_t(primitive.influence_count) * (sizeof(uint16_t) + sizeof(float));
    for (const MorphTarget& target : primitive.targets)
        bytes += sizeof(glm::vec3) * (!target.positions.empty() + !target.normals.empty() + !target.tangents.empty());
    return bytes;
}

void read_target_list(GltfDocument& document, const JsonRef& json, Mesh& mesh) {
    if (mesh.primitives.empty()) return;
    const size_t count = mesh.primitives[0].targets.size();
    for (const Primitive& primitive : mesh.primitives)
        if (primitive.targets.size() != count)
            json.at("primitives").fail(fmt::format("one has {} morph targets, another {}", count, primitive.targets.size()),
                                       "all primitives of a mesh have the same morph targets");
    mesh.weights = read_weights(document, json, count);
    const std::optional<JsonRef> extras = json.find("extras");
    if (count == 0 || !extras || !extras->is_object()) return;
    const std::optional<JsonRef> names = extras->find("targetNames");  // a custom of many exporters, no part of glTF
    if (!names || !names->is_array() || names->size() != count) return;
    for (size_t i = 0; i < count; ++i) mesh.target_names.emplace_back((*names)[i].is_string() ? (*names)[i].as_string() : std::string_view());
}

std::vector<float> read_weights(GltfDocument& document, const JsonRef& owner, size_t target_count) {
    const std::optional<JsonRef> json = owner.find_array("weights");
    if (!json) return {};
    if (json->size() != target_count)
        json->fail(fmt::format("has {} numbers, but there are {} morph targets", json->size(), target_count));
    document.files().charge(target_count * sizeof(float), json->where());
    std::vector<float> out;
    for (size_t i = 0; i < target_count; ++i) out.push_back((*json)[i].as_float());
    return out;
}

uint32_t joints_needed(const Mesh& mesh) {
    uint32_t needed = 0;
    for (const Primitive& primitive : mesh.primitives)
        for (const uint16_t joint : primitive.joints) needed = std::max(needed, joint + 1u);
    return needed;
}

std::vector<uint32_t> joints_of(const JsonRef& skin) {
    const JsonRef joints = skin.at("joints");
    if (joints.size() == 0) joints.fail("is empty");
    std::vector<uint32_t> out;
    for (size_t i = 0; i < joints.size(); ++i) out.push_back(joints[i].as_index_of("nodes"));
    return out;
}

Skin read_skin(GltfDocument& document, const JsonRef& json, const std::map<uint32_t, Handle<Node>>& nodes) {
    Skin skin{.name = json.string("name")};
    const std::vector<uint32_t> joints = joints_of(json);
    document.files().charge(joints.size() * (sizeof(Handle<Node>) + 2 * sizeof(glm::mat4)), json.where());
    for (const uint32_t joint : joints) skin.joints.push_back(nodes.at(joint));
    if (const std::optional<JsonRef> use = json.find("inverseBindMatrices")) {
        skin.inverse_bind = read_matrices(document, *use);
        if (skin.inverse_bind.size() < joints.size())
            use->fail(fmt::format("has {} matrices, but there are {} joints", skin.inverse_bind.size(), joints.size()));
        skin.inverse_bind.resize(joints.size());
        for (size_t i = 0; i < joints.size(); ++i) make_affine(*use, i, skin.inverse_bind[i]);
    } else {
        skin.inverse_bind.assign(joints.size(), glm::mat4(1.0f));
    }
    return skin;
}

}  // namespace parhelion
