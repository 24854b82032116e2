#include "scene/gltf/animation.h"

#include <cmath>

#include "scene/gltf/accessors.h"
#include "scene/gltf/animation_pointer.h"

namespace parhelion {

namespace {

std::optional<AnimatedPath> read_path(GltfDocument& document, const JsonRef& json) {
    const std::string_view name = json.as_string();
    if (name == "translation") return AnimatedPath::Translation;
    if (name == "rotation") return AnimatedPath::Rotation;
    if (name == "scale") return AnimatedPath::Scale;
    if (name == "weights") return AnimatedPath::Weights;
    document.warn(json, fmt::format("'{}' cannot be animated", escape_name(name, 20)));
    return std::nullopt;
}

// What a channel moves; nothing: what stands still.
std::optional<AnimatedProperty> read_property(GltfDocument& document, const JsonRef& target) {
    if (target.at("path").as_string() == "pointer") return read_animation_pointer(document, target);
    const std::optional<AnimatedPath> path = read_path(document, target.at("path"));
    const std::optional<JsonRef> node = target.find("node");
    if (!path || !node) return std::nullopt;
    return AnimatedProperty{*path, node->as_index_of("nodes")};
}

Interpolation read_interpolation(const JsonRef& sampler) {
    const std::optional<JsonRef> json = sampler.find("interpolation");
    if (!json || json->as_string() == "LINEAR") return Interpolation::Linear;
    if (json->as_string() == "STEP") return Interpolation::Step;
    if (json->as_string() == "CUBICSPLINE") return Interpolation::CubicSpline;
    json->fail(fmt::format("'{}' is no interpolation", escape_name(json->as_string(), 20)), "LINEAR, STEP or CUBICSPLINE");
}

std::vector<float> read_times(GltfDocument& document, const JsonRef& use) {
    std::vector<float> times = read_numbers(document, use, 1, NumberKind::Float);
    if (times.empty()) use.fail("has no keys");
    if (times[0] < 0.0f) use.fail(fmt::format("its first key is at {} seconds", times[0]), "times are 0 or more");
    for (size_t i = 1; i < times.size(); ++i)
        if (!(times[i] > times[i - 1]))
            use.fail(fmt::format("key {} at {} seconds does not follow key {} at {}", i, times[i], i - 1, times[i - 1]),
                     "times increase from key to key");
    return times;
}

// How many numbers an element of the output has, and how many of them are a key's value.
struct OutputShape {
    uint32_t components, width;
    NumberKind kind;
};

OutputShape shape_of(AnimatedPath path, uint32_t target_count) {
    switch (path) {
        case AnimatedPath::Rotation:
            return {4, 4, NumberKind::FloatOrNormalized};
        case AnimatedPath::Weights:
            return {1, target_count, NumberKind::FloatOrNormalized};
        case AnimatedPath::Translation:
        case AnimatedPath::Scale:
            return {3, 3, NumberKind::Float};
        case AnimatedPath::Color:
            return {3, 3, NumberKind::Any};
        default:
            break;
    }
    return {1, 1, NumberKind::Any};
}

void warn_unless_unit(GltfDocument& document, const JsonRef& use, const AnimationChannel& channel) {
    const bool spline = channel.interpolation == Interpolation::CubicSpline;
    for (size_t key = 0; key < channel.times.size(); ++key) {
        const float* q = channel.values.data() + (spline ? 3 * key + 1 : key) * 4;
        const float length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
        if (std::abs(length - 1.0f) < 0.02f) continue;  // integers are that coarse
        document.warn(use, fmt::format("the rotation of key {} is not a unit quaternion and was normalised", key));
        return;
    }
}

class AnimationReader {
public:
    AnimationReader(GltfDocument& document, const AnimatedObjects& objects) : document_(document), objects_(objects) {}

    Animation read(const JsonRef& json) {
        Animation animation{.name = json.string("name")};
        const JsonRef channels = json.at("channels"), samplers = json.at("samplers");
        if (channels.size() == 0) document_.warn(json, "has no channels");
        std::set<std::pair<uint32_t, AnimatedPath>> moved;
        for (size_t i = 0; i < channels.size(); ++i) {
            const JsonRef target = channels[i].at("target");
            const std::optional<AnimatedProperty> property = read_property(document_, target);
            if (!property) continue;
            std::vector<AnimationChannel> copies = channels_of(*property);
            if (copies.empty()) continue;
            if (!moved.insert({property->object, property->path}).second)
                target.fail("moves what a channel before it moves", "an animation moves each property of an object once");
            if (!fits(target, *property) || !has_keys(channels[i], samplers)) continue;
            for (AnimationChannel& channel : copies) {
                read_keys(channels[i], samplers, property->object, channel);
                animation.channels.push_back(std::move(channel));
            }
        }
        return animation;
    }

private:
    // One for each object of the scene that the file's is; without keys yet.
    std::vector<AnimationChannel> channels_of(const AnimatedProperty& property) const {
        std::vector<AnimationChannel> out;
        const auto add = [&](const auto& table, auto&& set) {
            const auto found = table.find(property.object);
            if (found == table.end()) return;
            for (const auto handle : found->second) set(out.emplace_back(AnimationChannel{.path = property.path}), handle);
        };
        switch (object_of(property.path)) {
            case AnimatedObject::Light:
                add(objects_.lights, [](AnimationChannel& channel, Handle<Light> light) { channel.light = light; });
                break;
            case AnimatedObject::Camera:
                add(objects_.cameras, [](AnimationChannel& channel, Handle<Camera> camera) { channel.camera = camera; });
                break;
            case AnimatedObject::Node:
                if (const auto node = objects_.nodes.find(property.object); node != objects_.nodes.end()) out.push_back({.node = node->second.node, .path = property.path});
        }
        return out;
    }

    uint32_t target_count(uint32_t node) const {
        const auto found = objects_.nodes.find(node);
        return found == objects_.nodes.end() ? 0 : found->second.target_count;
    }

    bool fits(const JsonRef& target, const AnimatedProperty& property) {
        if (property.path == AnimatedPath::Weights && target_count(property.object) == 0) {
            document_.warn(target, "animates weights, but its node has no morph targets");
            return false;
        }
        const bool moves = property.path == AnimatedPath::Translation || property.path == AnimatedPath::Rotation || property.path == AnimatedPath::Scale;
        if (moves && document_.root().at("nodes")[property.object].find("matrix"))
            target.fail("its node has a matrix", "animated nodes have translation, rotation and scale");
        return true;
    }

    static JsonRef sampler_of(const JsonRef& channel, const JsonRef& samplers) {
        const JsonRef ref = channel.at("sampler");
        const uint64_t index = ref.as_uint(0xFFFFFFFFull);
        if (index >= samplers.size()) ref.fail(fmt::format("names sampler {}, but there are {}", index, samplers.size()));
        return samplers[index];
    }

    // An accessor without data is one of zeros (glTF 2.0, 3.6.2.1), which as times say nothing.
    bool has_keys(const JsonRef& channel, const JsonRef& samplers) {
        const JsonRef times = document_.entry("accessors", sampler_of(channel, samplers).at("input"));
        if (times.find("bufferView") || times.find("sparse")) return true;
        document_.warn(channel, "has times without data and is left out");
        return false;
    }

    void read_keys(const JsonRef& json, const JsonRef& samplers, uint32_t object, AnimationChannel& channel) {
        const JsonRef sampler = sampler_of(json, samplers);
        const OutputShape shape = shape_of(channel.path, target_count(object));
        channel.interpolation = read_interpolation(sampler);
        channel.width = shape.width;
        if (channel.path == AnimatedPath::Visible && channel.interpolation != Interpolation::Step)
            json.at("sampler").fail("what is there or not is not interpolated", "its sampler is of STEP");
        document_.files().charge(sizeof(AnimationChannel), json.where());
        channel.times = read_times(document_, sampler.at("input"));
        const JsonRef output = sampler.at("output");
        channel.values = read_numbers(document_, output, shape.components, shape.kind);
        const uint64_t wanted = uint64_t(channel.times.size()) * shape.width * (channel.interpolation == Interpolation::CubicSpline ? 3 : 1);
        if (channel.values.size() != wanted)
            output.fail(fmt::format("has {} elements, but {} keys need {}", channel.values.size() / shape.components, channel.times.size(),
                                    wanted / shape.components));
        if (channel.path == AnimatedPath::Rotation) warn_unless_unit(document_, output, channel);
    }

    GltfDocument& document_;
    const AnimatedObjects& objects_;
};

}  // namespace

void add_animations(GltfDocument& document, SceneEdit& edit, const AnimatedObjects& objects) {
    const std::optional<JsonRef> animations = document.root().find_array("animations");
    if (!animations) return;
    AnimationReader reader(document, objects);
    for (size_t i = 0; i < animations->size(); ++i) edit.add(reader.read((*animations)[i]));
}

}  // namespace parhelion
