// Skins (3.7.3) and animations (3.11).
#include <map>

#include "scene/gltf/write_parts.h"

namespace parhelion::gltf {

namespace {

// Of a node's own properties the name, of others what follows the object's number in a pointer (KHR_animation_pointer).
const char* path_name(AnimatedPath path) {
    switch (path) {
        case AnimatedPath::Translation:
            return "translation";
        case AnimatedPath::Rotation:
            return "rotation";
        case AnimatedPath::Scale:
            return "scale";
        case AnimatedPath::Weights:
            return "weights";
        case AnimatedPath::Visible:
            return "extensions/KHR_node_visibility/visible";
        case AnimatedPath::Color:
            return "color";
        case AnimatedPath::Intensity:
            return "intensity";
        case AnimatedPath::InnerCone:
            return "spot/innerConeAngle";
        case AnimatedPath::OuterCone:
            return "spot/outerConeAngle";
        case AnimatedPath::Yfov:
            return "perspective/yfov";
        case AnimatedPath::Xmag:
            return "orthographic/xmag";
        case AnimatedPath::Ymag:
            break;
    }
    return "orthographic/ymag";
}

const char* interpolation_name(Interpolation interpolation) {
    return interpolation == Interpolation::Step ? "STEP" : interpolation == Interpolation::Linear ? "LINEAR" : "CUBICSPLINE";
}

// Weights are one number after the other, however many targets there are (3.11).
Json write_sampler(Writer& writer, const AnimationChannel& channel) {
    Elements times = vectors(channel.times, "SCALAR", Target::None);
    times.with_bounds = true;
    Elements values = vectors(channel.values, "SCALAR", Target::None);
    if (channel.path == AnimatedPath::Visible) {
        std::vector<uint8_t> bytes;
        for (const float value : channel.values) bytes.push_back(value != 0.0f);
        values.bytes = writer.buffer.keep(bytes);
        values.component = Component::UnsignedByte;
    } else if (channel.path != AnimatedPath::Weights) {
        values.type = channel.width == 4 ? "VEC4" : channel.width == 3 ? "VEC3" : "SCALAR";
        values.count /= channel.width;
    }
    return {{"input", writer.buffer.add_accessor(times)},
            {"interpolation", interpolation_name(channel.interpolation)},
            {"output", writer.buffer.add_accessor(values)}};
}

// What a channel moves in the file: weights are those of the node's instances, each of which may have a node of its own there.
std::vector<uint32_t> targets_of(const Writer& writer, const AnimationChannel& channel) {
    const auto carriers = writer.instance_nodes.find(channel.node.index);
    if (channel.path == AnimatedPath::Weights && carriers != writer.instance_nodes.end()) return carriers->second;
    if (object_of(channel.path) == AnimatedObject::Light) return {writer.lights.of(channel.light)};
    if (object_of(channel.path) == AnimatedObject::Camera) return {writer.cameras.of(channel.camera)};
    return {writer.nodes.of(channel.node)};
}

Json write_target(Writer& writer, const AnimationChannel& channel, uint32_t number) {
    if (channel.path <= AnimatedPath::Weights) return {{"node", number}, {"path", path_name(channel.path)}};
    const AnimatedObject object = object_of(channel.path);
    const char* table = object == AnimatedObject::Node ? "/nodes" : object == AnimatedObject::Light ? "/extensions/KHR_lights_punctual/lights" : "/cameras";
    Json target{{"path", "pointer"}};
    writer.extend(target, "KHR_animation_pointer", {{"pointer", fmt::format("{}/{}/{}", table, number, path_name(channel.path))}});
    return target;
}

}  // namespace

void write_skins(Writer& writer) {
    for (const auto& [handle, skin] : writer.scene.skins())  // those of no node come last
        if (writer.skins.of(handle) == kNotWritten) writer.skin_order.push_back(handle);
    for (const Handle<Skin> handle : writer.skin_order) {
        const Skin& skin = writer.scene.get(handle);
        Json json = named(skin.name);
        json["inverseBindMatrices"] = writer.buffer.add_accessor(vectors(skin.inverse_bind, "MAT4", Target::None));
        for (const Handle<Node> joint : skin.joints) json["joints"].push_back(writer.nodes.of(joint));
        writer.push("skins", std::move(json));
    }
}

void write_animations(Writer& writer) {
    for (const auto& [handle, animation] : writer.scene.animations()) {
        if (animation.channels.empty()) {
            writer.warn(fmt::format("animation '{}' moves nothing, which glTF does not have", escape_name(animation.name)));
            continue;
        }
        Json samplers = Json::array(), channels = Json::array();
        for (const AnimationChannel& channel : animation.channels) {
            for (const uint32_t number : targets_of(writer, channel)) channels.push_back({{"sampler", samplers.size()}, {"target", write_target(writer, channel, number)}});
            samplers.push_back(write_sampler(writer, channel));
        }
        Json json = named(animation.name);
        json["channels"] = std::move(channels);
        json["samplers"] = std::move(samplers);
        writer.push("animations", std::move(json));
    }
}

}  // namespace parhelion::gltf
