// The node hierarchy (3.5) with what stands on it, in the order in which read_gltf reads it: breadth first. A glTF node carries one mesh, one
// camera and one light (KHR_lights_punctual), all at its own origin; whatever has no room there gets a nameless child.
#include <cstring>
#include <optional>

#include "scene/gltf/nodes.h"
#include "scene/gltf/write_parts.h"

namespace parhelion::gltf {

namespace {

struct OutNode {
    const Node* node = nullptr;  // none: a helper for what it carries
    std::optional<glm::mat4> matrix;
    const Instance* instance = nullptr;
    const Camera* camera = nullptr;
    const Light* light = nullptr;
    std::vector<uint32_t> children;
};

// Bits are compared: a zero has a sign too.
template <class V>
bool same_bits(const V& a, const V& b) {
    return std::memcmp(&a, &b, sizeof(V)) == 0;
}
bool is_identity(const glm::mat4& matrix) { return same_bits(matrix, glm::mat4(1.0f)); }

// glTF's matrices are products of translation, rotation and scale (3.5.3): orthogonal columns.
bool sheared(const glm::mat4& matrix) {
    const glm::dvec3 c[3] = {glm::dvec3(matrix[0]), glm::dvec3(matrix[1]), glm::dvec3(matrix[2])};
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 &a = c[i], &b = c[(i + 1) % 3];
        if (std::abs(glm::dot(a, b)) > 1e-4 * glm::length(a) * glm::length(b)) return true;
    }
    return false;
}

class NodeWriter {
public:
    explicit NodeWriter(Writer& writer) : writer_(writer) {}

    void write() {
        lay_out();
        Json scene = Json::object();
        for (uint32_t root = 0; root < root_count_; ++root) scene["nodes"].push_back(root);
        for (const auto& [handle, animation] : writer_.scene.animations())
            for (const AnimationChannel& channel : animation.channels)
                if (channel.path == AnimatedPath::Visible) shown_and_hidden_.insert(&writer_.scene.get(channel.node));
        for (const OutNode& node : nodes_) writer_.push("nodes", node_json(node));
        note_numbers(camera_numbers_, writer_.cameras);
        note_numbers(light_numbers_, writer_.lights);
        if (!lights_.empty()) writer_.extend(writer_.root, "KHR_lights_punctual", {{"lights", std::move(lights_)}});
        writer_.root["scene"] = 0;
        writer_.push("scenes", std::move(scene));
    }

private:
    void lay_out() {
        std::vector<Handle<Node>> handles;
        for (const auto& [handle, node] : writer_.scene.nodes())
            if (!node.parent) add_node(handle, handles);
        add_homeless<Instance>(&OutNode::instance);
        add_homeless<Camera>(&OutNode::camera);
        add_homeless<Light>(&OutNode::light);
        root_count_ = static_cast<uint32_t>(nodes_.size());
        handles.resize(nodes_.size());
        for (uint32_t at = 0; at < nodes_.size(); ++at) {
            if (nodes_[at].node == nullptr) continue;
            const Node& node = *nodes_[at].node;
            for (const Handle<Node> child : node.children) {
                nodes_[at].children.push_back(static_cast<uint32_t>(nodes_.size()));
                add_node(child, handles);
            }
            place(at, node.instances, &OutNode::instance);
            place(at, node.cameras, &OutNode::camera);
            place(at, node.lights, &OutNode::light);
            handles.resize(nodes_.size());
        }
        for (uint32_t i = 0; i < nodes_.size(); ++i)
            if (handles[i]) writer_.nodes.set(handles[i], i);
        for (uint32_t i = 0; i < nodes_.size(); ++i)
            if (const Instance* instance = nodes_[i].instance; instance != nullptr && instance->place.node)
                writer_.instance_nodes[instance->place.node.index].push_back(i);
    }

    void add_node(Handle<Node> handle, std::vector<Handle<Node>>& handles) {
        nodes_.push_back({.node = &writer_.scene.get(handle)});
        handles.resize(nodes_.size());
        handles.back() = handle;
    }

    template <class T>
    bool shows(const T& value) const {
        if constexpr (std::is_same_v<T, Instance>) return writer_.meshes.of(value.mesh) != kNotWritten;
        return true;
    }

    template <class T>
    void add_helper(const T& value, const T* OutNode::*slot) {
        OutNode& helper = nodes_.emplace_back();
        helper.*slot = &value;
        if (!is_identity(value.place.node_from_object)) helper.matrix = value.place.node_from_object;
    }

    template <class T>
    void add_homeless(const T* OutNode::*slot) {
        for (const auto& [handle, value] : writer_.scene.all<T>())
            if (!value.place.node && shows(value)) add_helper(value, slot);
    }

    template <class T>
    void place(uint32_t at, const std::vector<Handle<T>>& handles, const T* OutNode::*slot) {
        for (const Handle<T> handle : handles) {
            const T& value = writer_.scene.get(handle);
            if (!shows(value)) continue;
            if (nodes_[at].*slot == nullptr && is_identity(value.place.node_from_object)) {
                nodes_[at].*slot = &value;
            } else {
                nodes_[at].children.push_back(static_cast<uint32_t>(nodes_.size()));
                add_helper(value, slot);
            }
        }
    }

    void write_matrix(const glm::mat4& matrix, Json& out, const std::string& name) {
        out["matrix"] = numbers(&matrix[0][0], 16);
        if (sheared(matrix))
            writer_.warn(fmt::format("node '{}' is sheared by its matrix, which glTF forbids: some programs will not take it", escape_name(name)));
    }

    void write_transform(const Transform& local, Json& out, const std::string& name) {
        if (local.matrix) {
            write_matrix(*local.matrix, out, name);
            return;
        }
        const Transform none;
        const glm::vec4 rotation(local.rotation.x, local.rotation.y, local.rotation.z, local.rotation.w);
        if (!same_bits(local.translation, none.translation)) out["translation"] = numbers(local.translation);
        if (!same_bits(rotation, glm::vec4(0.0f, 0.0f, 0.0f, 1.0f))) out["rotation"] = numbers(rotation);
        if (!same_bits(local.scale, none.scale)) out["scale"] = numbers(local.scale);
    }

    Json node_json(const OutNode& out) {
        Json json = Json::object();
        const std::string name = out.node != nullptr ? out.node->name : std::string{};
        if (!name.empty()) json["name"] = name;
        if (out.node != nullptr) write_transform(out.node->local, json, name);
        if (out.matrix) write_matrix(*out.matrix, json, name);
        if (!out.children.empty()) json["children"] = out.children;
        if (out.instance != nullptr) {
            json["mesh"] = writer_.meshes.of(out.instance->mesh);
            if (out.instance->skin) json["skin"] = skin_number(out.instance->skin);
            if (!out.instance->weights.empty()) json["weights"] = numbers(out.instance->weights.data(), out.instance->weights.size());
        }
        if (out.node != nullptr && (!out.node->visible || shown_and_hidden_.contains(out.node)))
            writer_.extend(json, "KHR_node_visibility", {{"visible", out.node->visible}});
        if (out.camera != nullptr) json["camera"] = camera_numbers_[out.camera] = writer_.push("cameras", camera_json(*out.camera, name));
        if (out.light != nullptr) {
            light_numbers_[out.light] = static_cast<uint32_t>(lights_.size());
            writer_.extend(json, "KHR_lights_punctual", {{"light", lights_.size()}});
            lights_.push_back(light_json(*out.light, name));
        }
        return json;
    }

    template <class T>
    void note_numbers(const std::map<const T*, uint32_t>& numbers, Numbers<T>& out) const {
        for (const auto& [handle, ignored] : writer_.scene.all<T>())
            if (const auto found = numbers.find(&writer_.scene.get(handle)); found != numbers.end()) out.set(handle, found->second);
    }

    // Skins are written after the nodes, whose numbers they need, in the order in which nodes use them.
    uint32_t skin_number(Handle<Skin> skin) {
        if (writer_.skins.of(skin) == kNotWritten) {
            writer_.skins.set(skin, static_cast<uint32_t>(writer_.skin_order.size()));
            writer_.skin_order.push_back(skin);
        }
        return writer_.skins.of(skin);
    }

    // Readers call what has no name of its own after its node; it is written that way.
    static Json named_after(const std::string& own, const std::string& node) { return named(own.empty() ? node : own); }

    Json camera_json(const Camera& camera, const std::string& node_name) {
        Json json = named_after(camera.name, node_name);
        if (camera.kind == CameraKind::Perspective) {
            json["type"] = "perspective";
            json["perspective"] = {{"yfov", number(camera.yfov)}, {"znear", number(camera.near_plane)}};
            if (camera.far_plane) json["perspective"]["zfar"] = number(*camera.far_plane);
        } else {
            json["type"] = "orthographic";
            // Without end there is only perspective (3.10.3).
            json["orthographic"] = {{"xmag", number(camera.xmag)},
                                    {"ymag", number(camera.ymag)},
                                    {"znear", number(camera.near_plane)},
                                    {"zfar", number(camera.far_plane.value_or(kLargestCoordinate))}};
        }
        return json;
    }

    Json light_json(const Light& light, const std::string& node_name) {
        Json json = named_after(light.name, node_name);
        json["type"] = light.kind == LightKind::Directional ? "directional" : light.kind == LightKind::Point ? "point" : "spot";
        if (light.color != glm::vec3(1.0f)) json["color"] = numbers(light.color);
        json["intensity"] = number(light.intensity);
        if (light.range > 0.0f && light.kind != LightKind::Directional) json["range"] = number(light.range);
        if (light.kind == LightKind::Spot)
            json["spot"] = {{"innerConeAngle", number(light.inner_cone)}, {"outerConeAngle", number(light.outer_cone)}};
        if (light.kind == LightKind::Directional && light.angular_radius > 0.0f) {
            json["extras"][kAngularRadiusKey] = number(light.angular_radius);
            writer_.warn(fmt::format("light '{}' has a size, which glTF does not have: other programs will give it sharp shadows",
                                     escape_name(light.name)));
        }
        return json;
    }

    Writer& writer_;
    std::vector<OutNode> nodes_;
    uint32_t root_count_ = 0;
    Json lights_ = Json::array();
    std::map<const Camera*, uint32_t> camera_numbers_;
    std::map<const Light*, uint32_t> light_numbers_;
    std::set<const Node*> shown_and_hidden_;  // by an animation, whose pointer needs something to point to
};

}  // namespace

void write_nodes(Writer& writer) { NodeWriter(writer).write(); }

}  // namespace parhelion::gltf
