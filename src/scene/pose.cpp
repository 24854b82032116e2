#include "scene/pose.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <unordered_set>

#include "base/log.h"
#include "scene/animation.h"
#include "scene/deform.h"

namespace parhelion {

namespace {

// What a form takes: on the host, or of the device's memory.
uint64_t shape_bytes(const Mesh& mesh) {
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

void check_joints(const Mesh& mesh, size_t joint_count) {
    for (const Primitive& primitive : mesh.primitives)
        if (primitive.joint_bounds.size() > joint_count)
            throw Error(ErrorCode::Failed, fmt::format("names joint {}, but its skin has {}", primitive.joint_bounds.size() - 1, joint_count),
                        fmt::format("mesh '{}'", escape_name(mesh.name)));
}

constexpr float kLeastExtent = 1e-4f;  // radians of a cone or a picture, metres of a picture

uint32_t width_of(const AnimationChannel& channel) {
    switch (channel.path) {
        case AnimatedPath::Weights:
            return channel.width;
        case AnimatedPath::Rotation:
            return 4;
        case AnimatedPath::Translation:
        case AnimatedPath::Scale:
        case AnimatedPath::Color:
            return 3;
        default:
            return 1;
    }
}

// In all that an animation can change.
bool alike(const Light& a, const Light& b) { return a.color == b.color && a.intensity == b.intensity && a.inner_cone == b.inner_cone && a.outer_cone == b.outer_cone; }
bool alike(const Camera& a, const Camera& b) { return a.yfov == b.yfov && a.xmag == b.xmag && a.ymag == b.ymag; }

// A form of the mesh `handle`, or, of a mesh that is one itself, another of that. Joints that mirror turn triangles over, which only a
// shape that is made here can show.
Mesh make_form(const Mesh& rest, Handle<Mesh> handle, MeshDeformation&& deformation) {
    if (rest.rest || any_mirrors(deformation)) return deformed(rest, handle, deformation);
    Mesh out{.name = rest.name};
    out.rest = handle;
    for (const Primitive& p : rest.primitives) out.primitives.push_back({.material = p.material, .variant_materials = p.variant_materials});
    out.deformation = std::move(deformation);
    return out;
}

// ---- the scene ----

class Poser {
public:
    Poser(const Scene& scene, std::function<void(uint64_t)> charge) : scene_(scene), charge_(std::move(charge)) {}

    SceneEdit run(double seconds, std::string_view animation) {
        play(seconds, animation);
        for (const auto& [handle, node] : scene_.nodes())
            if (const auto found = locals_.find(handle); found != locals_.end()) edit_.set_transform(handle, found->second);
        for (const auto& [handle, visible] : visible_)
            if (visible != scene_.get(handle).visible) edit_.set_visible(handle, visible);
        for (const auto& [handle, light] : lights_)
            if (!alike(light, scene_.get(handle))) edit_.set_light(handle, light);
        for (const auto& [handle, camera] : cameras_)
            if (!alike(camera, scene_.get(handle))) edit_.set_camera(handle, camera);
        find_places();
        deform();
        return std::move(edit_);
    }

    Camera camera_at(Handle<Camera> handle, double seconds, std::string_view animation) {
        play(seconds, animation);
        find_places();
        const auto found = cameras_.find(handle);
        Camera camera = found == cameras_.end() ? scene_.get(handle) : found->second;
        camera.place.world_from_object = place_of(camera.place);
        return camera;
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
        for (const Handle<Light> handle : cones_) {
            Light& light = lights_.at(handle);
            light.inner_cone = std::clamp(light.inner_cone, 0.0f, light.outer_cone);
        }
    }

    void play(const Animation& animation, const AnimationChannel& channel, double seconds) {
        std::vector<float> v(channel.width);
        sample_channel(channel, seconds, v);
        for (const float x : v)
            if (!std::isfinite(x))
                throw Error(ErrorCode::Failed, fmt::format("has no finite value at {} seconds", seconds),
                            fmt::format("animation '{}'", escape_name(animation.name)));
        if (channel.width != width_of(channel)) return;
        if (object_of(channel.path) == AnimatedObject::Light) return play_light(channel, v);
        if (object_of(channel.path) == AnimatedObject::Camera) return play_camera(channel, v[0]);
        if (channel.path == AnimatedPath::Visible) {
            visible_[channel.node] = v[0] != 0.0f;
            return;
        }
        const Node& node = scene_.get(channel.node);
        if (channel.path == AnimatedPath::Weights) {
            if (charge_) charge_(node.instances.size() * v.size() * 4 * sizeof(float));
            for (const Handle<Instance> instance : node.instances) weights_[instance] = v;
            return;
        }
        Transform& local = locals_.try_emplace(channel.node, node.local).first->second;
        local.matrix.reset();  // glTF 2.0, 3.11: only nodes without one are animated
        if (channel.path == AnimatedPath::Rotation)
            local.rotation = glm::quat(v[3], v[0], v[1], v[2]);
        else
            (channel.path == AnimatedPath::Scale ? local.scale : local.translation) = glm::vec3(v[0], v[1], v[2]);
    }

    // Splines may leave the range between their keys: such values are pulled to its end.
    void play_light(const AnimationChannel& channel, std::span<const float> v) {
        constexpr float kHalfPi = 1.5707963f;
        Light& light = lights_.try_emplace(channel.light, scene_.get(channel.light)).first->second;
        if (channel.path == AnimatedPath::Color) light.color = glm::max(glm::vec3(v[0], v[1], v[2]), glm::vec3(0.0f));
        if (channel.path == AnimatedPath::Intensity) light.intensity = std::max(v[0], 0.0f);
        if (channel.path == AnimatedPath::OuterCone) light.outer_cone = std::clamp(v[0], kLeastExtent, kHalfPi);
        if (channel.path == AnimatedPath::InnerCone) light.inner_cone = v[0];
        // The other of both may follow in a later channel; in the end the inner one gives way.
        if (channel.path == AnimatedPath::InnerCone || channel.path == AnimatedPath::OuterCone) cones_.insert(channel.light);
    }

    void play_camera(const AnimationChannel& channel, float value) {
        constexpr float kMostAngle = 3.14159f;
        Camera& camera = cameras_.try_emplace(channel.camera, scene_.get(channel.camera)).first->second;
        if (channel.path == AnimatedPath::Yfov) camera.yfov = std::clamp(value, kLeastExtent, kMostAngle);
        if (channel.path == AnimatedPath::Xmag) camera.xmag = std::max(std::abs(value), kLeastExtent);
        if (channel.path == AnimatedPath::Ymag) camera.ymag = std::max(std::abs(value), kLeastExtent);
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
        for (const Handle<Instance> handle : group.skinned) {
            const std::vector<glm::dmat4x3>& palette = palette_of(scene_.get(handle).skin);
            check_joints(*group.rest, palette.size());
            MeshDeformation deformation{.weights = group.weights};
            const glm::dmat4 object_from_world = glm::inverse(glm::dmat4(place_of(scene_.get(handle).place)));
            for (const glm::dmat4x3& m : palette) deformation.object_from_rest.emplace_back(glm::mat4(object_from_world * glm::dmat4(m)));
            give_form({&handle, 1}, group, std::move(deformation));
        }
        if (!group.rigid.empty()) give_form(group.rigid, group, {.weights = group.weights});
    }

    // One form for them all: the one that they have, if it is the same.
    void give_form(std::span<const Handle<Instance>> instances, const Group& group, MeshDeformation&& deformation) {
        const Handle<Mesh> present = scene_.get(instances.front()).posed;
        const bool stays = present && scene_.get(present).deformation == deformation &&
                           std::ranges::all_of(instances, [&](Handle<Instance> i) { return scene_.get(i).posed == present; });
        Handle<Mesh> form = present;
        if (stays) used_.insert(present);
        else {
            if (charge_) charge_(shape_bytes(*group.rest));
            form = edit_.add(make_form(*group.rest, group.rest_handle, std::move(deformation)));
        }
        for (const Handle<Instance> handle : instances) {
            std::vector<float> weights = now(handle, scene_.get(handle));
            if (!stays || weights != scene_.get(handle).weights) edit_.set_pose(handle, form, std::move(weights));
        }
    }

    // world_from_joint x inverse_bind of every joint.
    const std::vector<glm::dmat4x3>& palette_of(Handle<Skin> handle) {
        const auto [entry, added] = palettes_.try_emplace(handle);
        if (added) {
            const Skin& skin = scene_.get(handle);
            for (size_t i = 0; i < skin.joints.size(); ++i)
                entry->second.push_back(glm::dmat4x3(worlds_[skin.joints[i].index] * glm::dmat4(skin.inverse_bind[i])));
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
    std::unordered_map<Handle<Node>, bool> visible_;
    std::unordered_map<Handle<Light>, Light> lights_;
    std::unordered_set<Handle<Light>> cones_;  // of which a cone moves
    std::unordered_map<Handle<Camera>, Camera> cameras_;
    std::unordered_map<Handle<Instance>, std::vector<float>> weights_;
    std::vector<glm::dmat4> worlds_;  // by node slot
    std::unordered_map<Handle<Skin>, std::vector<glm::dmat4x3>> palettes_;
    std::unordered_set<Handle<Mesh>> used_;  // by what this edit leaves as it is
    std::vector<Handle<Mesh>> replaced_;
};

}  // namespace

SceneEdit pose_at(const Scene& scene, double seconds, std::string_view animation, const std::function<void(uint64_t)>& charge) {
    return Poser(scene, charge).run(seconds, animation);
}

Camera camera_at(const Scene& scene, Handle<Camera> camera, double seconds, std::string_view animation) {
    return Poser(scene, {}).camera_at(camera, seconds, animation);
}

}  // namespace parhelion
