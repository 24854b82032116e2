#include "scene/gltf/nodes.h"

#include <cmath>

#include "base/error.h"
#include "scene/gltf/accessors.h"
#include "scene/gltf/skins.h"

namespace parhelion {

namespace {

constexpr uint32_t kNone = 0xFFFFFFFFu;

// parent_of[n]; kNone for roots. Every node must be reachable from a root, which with single parents rules out cycles.
std::vector<uint32_t> find_parents(const JsonRef& root, uint32_t node_count) {
    std::vector<uint32_t> parents(node_count, kNone);
    const std::optional<JsonRef> nodes = root.find_array("nodes");
    for (uint32_t n = 0; n < node_count; ++n) {
        const std::optional<JsonRef> children = (*nodes)[n].find_array("children");
        for (size_t i = 0; children && i < children->size(); ++i) {
            const uint32_t child = (*children)[i].as_index_of("nodes");
            if (parents[child] != kNone)
                (*children)[i].fail(fmt::format("node {} is a child of node {} already", child, parents[child]), "a node has one parent");
            if (child == n) (*children)[i].fail(fmt::format("node {} is its own child", n));
            parents[child] = n;
        }
    }
    return parents;
}

void check_no_cycles(const JsonRef& root, const std::vector<uint32_t>& parents) {
    // 0: not seen, otherwise the number of the walk that came by; meeting one's own trail is a cycle.
    std::vector<uint32_t> seen(parents.size(), 0);
    for (uint32_t start = 0; start < parents.size(); ++start) {
        uint32_t at = start;
        while (at != kNone && seen[at] == 0) {
            seen[at] = start + 1;
            at = parents[at];
        }
        if (at != kNone && seen[at] == start + 1)
            root.at("nodes")[at].fail("is among its own descendants", "the node hierarchy has a cycle");
    }
}

std::vector<uint32_t> root_nodes(GltfDocument& document, const std::vector<uint32_t>& parents) {
    const JsonRef root = document.root();
    const size_t scene_count = root.array_size("scenes");
    const std::optional<JsonRef> chosen = root.find("scene");
    const uint32_t scene_index = chosen ? chosen->as_index_of("scenes") : 0;
    std::vector<uint32_t> out;
    if (scene_count == 0) {
        for (uint32_t n = 0; n < parents.size(); ++n)
            if (parents[n] == kNone) out.push_back(n);
        if (!out.empty()) document.warn("has no scene: all its nodes are drawn");
        return out;
    }
    const std::optional<JsonRef> nodes = root.at("scenes")[scene_index].find_array("nodes");
    std::vector<bool> listed(parents.size(), false);
    for (size_t i = 0; nodes && i < nodes->size(); ++i) {
        const uint32_t node = (*nodes)[i].as_index_of("nodes");
        if (parents[node] != kNone) (*nodes)[i].fail(fmt::format("node {} is not a root: it is a child of node {}", node, parents[node]));
        if (listed[node]) (*nodes)[i].fail(fmt::format("node {} is listed twice", node));
        listed[node] = true;
        out.push_back(node);
    }
    return out;
}

void warn_unless_unit(GltfDocument& document, const JsonRef& node, double length) {
    if (std::abs(length - 1.0) > 1e-3) document.warn(node, "its rotation is not a unit quaternion and was normalised");
}

// The last row, which rounding in exporters may have touched, becomes exact.
void require_affine(const JsonRef& json, glm::mat4& m) {
    constexpr float kRounding = 1e-5f;
    for (int column = 0; column < 4; ++column) {
        const float exact = column == 3 ? 1.0f : 0.0f;
        if (std::abs(m[column][3] - exact) > kRounding)
            json.fail("is not affine", "its last row (elements 3, 7, 11, 15) must be 0, 0, 0, 1");
        m[column][3] = exact;
    }
}

// A number above zero.
float positive(const JsonRef& owner, std::string_view key, std::optional<float> fallback = std::nullopt) {
    if (fallback && !owner.find(key)) return *fallback;
    const JsonRef value = owner.at(key);
    const float number = value.as_float();
    if (!(number > 0.0f)) value.fail(fmt::format("is {}, expected more than 0", number));
    return number;
}

// What gltf_write keeps there; of other writers' extras nothing is known, so that what does not fit is passed over.
float read_angular_radius(const JsonRef& light) {
    constexpr float kMost = 1.5f;
    const std::optional<JsonRef> extras = light.find("extras");
    const std::optional<JsonRef> radius = extras && extras->is_object() ? extras->find(kAngularRadiusKey) : std::nullopt;
    if (!radius || !radius->is_number()) return 0.0f;
    const double value = radius->as_number();
    return value >= 0.0 && value <= kMost ? static_cast<float>(value) : 0.0f;
}

}  // namespace

std::vector<GltfNode> collect_nodes(GltfDocument& document) {
    const JsonRef root = document.root();
    const uint32_t node_count = static_cast<uint32_t>(root.array_size("nodes"));
    document.files().charge(uint64_t(node_count) * 64, root.where());
    const std::vector<uint32_t> parents = find_parents(root, node_count);
    check_no_cycles(root, parents);
    std::vector<GltfNode> out;
    for (const uint32_t node : root_nodes(document, parents)) out.push_back({node, GltfNode::kNoParent});
    for (uint32_t at = 0; at < out.size(); ++at) {
        const std::optional<JsonRef> children = root.at("nodes")[out[at].index].find_array("children");
        for (size_t i = 0; children && i < children->size(); ++i) out.push_back({(*children)[i].as_index_of("nodes"), at});
    }
    return out;
}

void add_joint_nodes(GltfDocument& document, std::vector<GltfNode>& nodes) {
    const JsonRef root = document.root();
    std::set<uint32_t> skins;
    for (const GltfNode& node : nodes)
        if (const std::optional<JsonRef> skin = root.at("nodes")[node.index].find("skin")) skins.insert(skin->as_index_of("skins"));
    if (skins.empty()) return;
    const uint32_t node_count = static_cast<uint32_t>(root.array_size("nodes"));
    std::vector<uint32_t> place(node_count, kNone);  // in the list
    for (uint32_t at = 0; at < nodes.size(); ++at) place[nodes[at].index] = at;
    const std::vector<uint32_t> parents = find_parents(root, node_count);
    for (const uint32_t skin : skins)
        for (const uint32_t joint : joints_of(root.at("skins")[skin])) {
            if (place[joint] != kNone) continue;
            document.warn(root.at("skins")[skin], "has joints that the scene does not have");
            std::vector<uint32_t> path;
            uint32_t up = joint;
            for (; up != kNone && place[up] == kNone; up = parents[up]) path.push_back(up);
            uint32_t parent = up == kNone ? GltfNode::kNoParent : place[up];
            for (auto node = path.rbegin(); node != path.rend(); ++node) {
                place[*node] = static_cast<uint32_t>(nodes.size());
                nodes.push_back({*node, parent, false});
                parent = place[*node];
            }
        }
}

Transform read_transform(GltfDocument& document, const JsonRef& node) {
    Transform out;
    if (const std::optional<JsonRef> matrix = node.find("matrix")) {
        matrix->require_numbers(16);
        glm::mat4 m(1.0f);
        for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = (*matrix)[static_cast<size_t>(i)].as_float();
        require_affine(*matrix, m);
        if (node.find("translation") || node.find("rotation") || node.find("scale"))
            document.warn(node, "has a matrix and translation, rotation or scale; the matrix counts");
        out.matrix = m;
        return out;
    }
    out.translation = node.vec<3>("translation", glm::vec3(0.0f));
    out.scale = node.vec<3>("scale", glm::vec3(1.0f));
    const glm::dvec4 q(node.vec<4>("rotation", glm::vec4(0.0f, 0.0f, 0.0f, 1.0f)));
    const double length = glm::length(q);
    if (!(length > 0.0)) node.at("rotation").fail("has no length", "a rotation is a unit quaternion x, y, z, w");
    warn_unless_unit(document, node, length);
    const glm::dvec4 unit = is_unit(length) ? q : q / length;
    out.rotation = glm::quat(float(unit.w), float(unit.x), float(unit.y), float(unit.z));
    return out;
}

Camera read_camera(GltfDocument& document, const JsonRef& json) {
    Camera camera;
    camera.name = json.string("name");
    const JsonRef type = json.at("type");
    if (type.as_string() == "perspective") {
        const JsonRef p = json.at("perspective");
        camera.yfov = positive(p, "yfov");
        constexpr float kPi = 3.14159265f;
        if (camera.yfov >= kPi) p.at("yfov").fail(fmt::format("is {} radians, expected less than pi", camera.yfov));
        camera.near_plane = positive(p, "znear");
        if (p.find("zfar")) camera.far_plane = positive(p, "zfar");
        if (p.find("aspectRatio")) positive(p, "aspectRatio");
    } else if (type.as_string() == "orthographic") {
        const JsonRef o = json.at("orthographic");
        camera.kind = CameraKind::Orthographic;
        camera.xmag = o.at("xmag").as_float();
        camera.ymag = o.at("ymag").as_float();
        if (camera.xmag == 0.0f || camera.ymag == 0.0f) o.fail("xmag and ymag must not be 0");
        if (camera.xmag < 0.0f || camera.ymag < 0.0f) document.warn(o, "negative xmag or ymag was made positive");
        camera.xmag = std::abs(camera.xmag);
        camera.ymag = std::abs(camera.ymag);
        camera.near_plane = o.at("znear").as_float();
        if (camera.near_plane < 0.0f) o.at("znear").fail("is negative");
        camera.far_plane = positive(o, "zfar");
    } else {
        type.fail(fmt::format("'{}' is no kind of camera", escape_name(type.as_string(), 20)), "perspective or orthographic");
    }
    if (camera.far_plane && *camera.far_plane <= camera.near_plane) json.fail("its zfar is not beyond its znear");
    return camera;
}

Light read_light(GltfDocument& document, const JsonRef& json) {
    Light light;
    light.name = json.string("name");
    light.color = json.vec<3>("color", glm::vec3(1.0f));
    light.intensity = json.number("intensity", 1.0f);
    if (light.intensity < 0.0f || glm::any(glm::lessThan(light.color, glm::vec3(0.0f)))) json.fail("its intensity or colour is negative");
    if (json.find("range")) light.range = positive(json, "range");
    const JsonRef type = json.at("type");
    if (type.as_string() == "directional") {
        light.kind = LightKind::Directional;
        light.range = 0.0f;
        light.angular_radius = read_angular_radius(json);
    } else if (type.as_string() == "point") {
        light.kind = LightKind::Point;
    } else if (type.as_string() == "spot") {
        light.kind = LightKind::Spot;
        if (const std::optional<JsonRef> spot = json.find("spot")) {
            light.inner_cone = spot->number("innerConeAngle", light.inner_cone);
            light.outer_cone = spot->number("outerConeAngle", light.outer_cone);
        }
        constexpr float kHalfPi = 1.5707964f;
        if (!(light.inner_cone >= 0.0f && light.inner_cone <= light.outer_cone && light.outer_cone <= kHalfPi && light.outer_cone > 0.0f))
            json.fail(fmt::format("its cone angles {} and {} are out of order", light.inner_cone, light.outer_cone),
                      "0 <= inner <= outer <= pi/2");
        if (light.inner_cone == light.outer_cone) document.warn(json, "its inner and outer cone angles are equal");
    } else {
        type.fail(fmt::format("'{}' is no kind of light", escape_name(type.as_string(), 20)), "directional, point or spot");
    }
    return light;
}

}  // namespace parhelion
