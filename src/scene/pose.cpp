#include "scene/pose.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <unordered_set>

#include "base/log.h"
#include "base/parallel.h"
#include "scene/animation.h"

namespace parhelion {

namespace {

using Affine = glm::dmat4x3;  // three rows of four: the last row of an affine matrix is known

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

uint64_t copied_bytes(const Mesh& mesh) {
    uint64_t bytes = sizeof(Mesh);
    for (const Primitive& p : mesh.primitives)
        bytes += sizeof(Primitive) + (p.positions.size() + p.normals.size() + p.triangles.size()) * sizeof(glm::vec3) +
                 (p.tangents.size() + p.colors.size()) * sizeof(glm::vec4) + (p.uv0.size() + p.uv1.size()) * sizeof(glm::vec2) +
                 p.variant_materials.size() * sizeof(Handle<Material>);
    return bytes;
}

size_t target_count(const Mesh& mesh) { return mesh.primitives.empty() ? 0 : mesh.primitives[0].targets.size(); }
bool has_joints(const Mesh& mesh) {
    return std::any_of(mesh.primitives.begin(), mesh.primitives.end(), [](const Primitive& p) { return p.influence_count != 0; });
}

// ---- morph targets: glTF 2.0, 3.7.2.2 ----

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

Mesh morphed(const Mesh& rest, const std::vector<float>& weights) {
    Mesh out{.name = rest.name};
    for (const Primitive& primitive : rest.primitives) {
        out.primitives.push_back(plain_copy(primitive));
        morph(primitive, weights, out.primitives.back());
    }
    return out;
}

// ---- skins: glTF 2.0, 3.7.3.3 ----

void check_joints(const Mesh& mesh, const Primitive& primitive, size_t joint_count) {
    for (const uint16_t joint : primitive.joints)
        if (joint >= joint_count)
            throw Error(ErrorCode::Failed, fmt::format("names joint {}, but its skin has {}", joint, joint_count),
                        fmt::format("mesh '{}'", escape_name(mesh.name)));
}

// `joints` has the joints and weights of the vertices of `out`, which holds them at rest.
void skin(const Primitive& joints, const std::vector<Affine>& world_from_rest, const glm::dmat4& object_from_world, Primitive& out) {
    const uint32_t n = joints.influence_count;
    std::vector<uint8_t> mirrored(out.positions.size(), 0);
    parallel_for(out.positions.size(), kVerticesAtOnce, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            Affine blended(0.0);
            for (size_t k = i * n; k < (i + 1) * n; ++k)
                if (joints.joint_weights[k] != 0.0f) blended += double(joints.joint_weights[k]) * world_from_rest[joints.joints[k]];
            const glm::dvec3 world = blended * glm::dvec4(out.positions[i], 1.0);
            out.positions[i] = glm::vec3(object_from_world * glm::dvec4(world, 1.0));
            const glm::dmat3 m = glm::dmat3(object_from_world) * glm::dmat3(blended);
            // The cofactors are the inverse transpose times the determinant, and need no inverse.
            const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
            const double side = glm::dot(m[0], cofactors[0]) < 0.0 ? -1.0 : 1.0;
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

// ---- the scene ----

class Poser {
public:
    Poser(const Scene& scene, std::function<void(uint64_t)> charge) : scene_(scene), charge_(std::move(charge)) {}

    SceneEdit run(double seconds, std::string_view animation) {
        play(seconds, animation);
        for (const auto& [handle, node] : scene_.nodes())
            if (const auto found = locals_.find(handle); found != locals_.end()) edit_.set_transform(handle, found->second);
        find_places();
        deform();
        return std::move(edit_);
    }

    glm::mat4 place_at(const Placement& place, double seconds, std::string_view animation) {
        play(seconds, animation);
        find_places();
        return place_of(place);
    }

private:
    // Instances that look alike before a skin takes them apart.
    struct Group {
        Handle<Mesh> rest_handle;
        const Mesh* rest = nullptr;
        std::vector<float> weights;
        std::vector<Handle<Instance>> rigid, skinned;
    };

    void play(double seconds, std::string_view animation) {
        for (const Handle<Animation> handle : choose_animations(scene_, animation))
            for (const AnimationChannel& channel : scene_.get(handle).channels) play(scene_.get(handle), channel, seconds);
    }

    void play(const Animation& animation, const AnimationChannel& channel, double seconds) {
        std::vector<float> v(channel.width);
        sample_channel(channel, seconds, v);
        for (const float x : v)
            if (!std::isfinite(x))
                throw Error(ErrorCode::Failed, fmt::format("has no finite value at {} seconds", seconds),
                            fmt::format("animation '{}'", escape_name(animation.name)));
        const Node& node = scene_.get(channel.node);
        if (channel.path == AnimatedPath::Weights) {
            if (charge_) charge_(node.instances.size() * v.size() * 4 * sizeof(float));
            for (const Handle<Instance> instance : node.instances) weights_[instance] = v;
            return;
        }
        if (channel.width != (channel.path == AnimatedPath::Rotation ? 4u : 3u)) return;
        Transform& local = locals_.try_emplace(channel.node, node.local).first->second;
        local.matrix.reset();  // glTF 2.0, 3.11: only nodes without one are animated
        if (channel.path == AnimatedPath::Rotation)
            local.rotation = glm::quat(v[3], v[0], v[1], v[2]);
        else
            (channel.path == AnimatedPath::Scale ? local.scale : local.translation) = glm::vec3(v[0], v[1], v[2]);
    }

    void find_places() {
        worlds_.resize(scene_.nodes().slot_count());
        std::vector<Handle<Node>> stack;
        for (const auto& [handle, node] : scene_.nodes())
            if (!node.parent) stack.push_back(handle);
        while (!stack.empty()) {
            const Handle<Node> handle = stack.back();
            stack.pop_back();
            const Node& node = scene_.get(handle);
            const auto found = locals_.find(handle);
            glm::dmat4& world = worlds_[handle.index];
            world = glm::dmat4(matrix_of(found == locals_.end() ? node.local : found->second));
            if (node.parent) world = worlds_[node.parent.index] * world;
            for (int column = 0; column < 4; ++column)
                for (int row = 0; row < 3; ++row)
                    if (!(std::abs(world[column][row]) <= kLargestCoordinate))
                        throw Error(ErrorCode::Failed, "its place in the world is beyond all measure",
                                    fmt::format("node '{}'", escape_name(node.name)), "look at its animation and its parents' scales");
            stack.insert(stack.end(), node.children.begin(), node.children.end());
        }
    }

    glm::mat4 place_of(const Placement& place) const {
        if (!place.node) return place.node_from_object;
        return glm::mat4(worlds_[place.node.index] * glm::dmat4(place.node_from_object));
    }

    void deform() {
        std::map<std::pair<uint32_t, std::vector<float>>, Group> groups;
        for (const auto& [handle, instance] : scene_.instances()) {
            const Mesh& mesh = scene_.get(instance.mesh);
            const bool skinned = instance.skin && has_joints(mesh);
            if (!skinned && target_count(mesh) == 0) {
                used_.insert({instance.mesh, instance.drawn_mesh()});
                continue;
            }
            used_.insert(instance.mesh);
            if (instance.posed) replaced_.push_back(instance.posed);
            const auto played = weights_.find(handle);
            std::vector<float> weights = played != weights_.end() ? played->second : instance.weights.empty() ? mesh.weights : instance.weights;
            weights.resize(target_count(mesh), 0.0f);
            const bool still = std::all_of(weights.begin(), weights.end(), [](float w) { return w == 0.0f; });
            if ((!skinned && still) || (skinned && !visible(instance))) {
                if (instance.posed || now(handle, instance) != instance.weights) edit_.set_pose(handle, {}, now(handle, instance));
                continue;
            }
            Group& group = groups[{instance.mesh.index, weights}];
            group.rest_handle = mesh.rest ? mesh.rest : instance.mesh;
            group.rest = &mesh;
            group.weights = std::move(weights);
            (skinned ? group.skinned : group.rigid).push_back(handle);
        }
        for (const auto& [key, group] : groups) deform(group);
        remove_replaced();
    }

    // The weights that the instance keeps: those of its own, not its mesh's.
    std::vector<float> now(Handle<Instance> handle, const Instance& instance) const {
        const auto played = weights_.find(handle);
        return played != weights_.end() ? played->second : instance.weights;
    }

    bool visible(const Instance& instance) const {
        if (drawable(place_of(instance.place))) return true;
        log(LogLevel::Warn, "mesh '{}': its node has no size, so that its skin cannot be drawn there", escape_name(scene_.get(instance.mesh).name));
        return false;
    }

    void deform(const Group& group) {
        if (charge_) charge_(copied_bytes(*group.rest));
        Mesh base = morphed(*group.rest, group.weights);
        base.rest = group.rest_handle;
        for (const Handle<Instance> handle : group.skinned) {
            if (charge_) charge_(copied_bytes(base));
            Mesh mesh = base;
            const Instance& instance = scene_.get(handle);
            const std::vector<Affine>& palette = palette_of(instance.skin);
            const glm::dmat4 object_from_world = glm::inverse(glm::dmat4(place_of(instance.place)));
            for (size_t i = 0; i < mesh.primitives.size(); ++i) {
                const Primitive& rest = group.rest->primitives[i];
                check_joints(*group.rest, rest, palette.size());
                if (rest.influence_count != 0) skin(rest, palette, object_from_world, mesh.primitives[i]);
            }
            edit_.set_pose(handle, edit_.add(std::move(mesh)), now(handle, instance));
        }
        if (group.rigid.empty()) return;
        const Handle<Mesh> shared = edit_.add(std::move(base));
        for (const Handle<Instance> handle : group.rigid) edit_.set_pose(handle, shared, now(handle, scene_.get(handle)));
    }

    // world_from_joint x inverse_bind of every joint.
    const std::vector<Affine>& palette_of(Handle<Skin> handle) {
        const auto [entry, added] = palettes_.try_emplace(handle);
        if (added) {
            const Skin& skin = scene_.get(handle);
            for (size_t i = 0; i < skin.joints.size(); ++i)
                entry->second.push_back(Affine(worlds_[skin.joints[i].index] * glm::dmat4(skin.inverse_bind[i])));
        }
        return entry->second;
    }

    void remove_replaced() {
        for (const Handle<Mesh> mesh : replaced_)
            if (used_.insert(mesh).second) edit_.remove(mesh);
    }

    const Scene& scene_;
    const std::function<void(uint64_t)> charge_;
    SceneEdit edit_;
    std::unordered_map<Handle<Node>, Transform> locals_;  // of nodes that an animation moves
    std::unordered_map<Handle<Instance>, std::vector<float>> weights_;
    std::vector<glm::dmat4> worlds_;  // by node slot
    std::unordered_map<Handle<Skin>, std::vector<Affine>> palettes_;
    std::unordered_set<Handle<Mesh>> used_;  // by what this edit leaves as it is
    std::vector<Handle<Mesh>> replaced_;
};

}  // namespace

SceneEdit pose_at(const Scene& scene, double seconds, std::string_view animation, const std::function<void(uint64_t)>& charge) {
    return Poser(scene, charge).run(seconds, animation);
}

glm::mat4 place_at(const Scene& scene, const Placement& place, double seconds, std::string_view animation) {
    return Poser(scene, {}).place_at(place, seconds, animation);
}

}  // namespace parhelion
