#include "scene/gltf/animation.h"

#include <cmath>

#include "scene/gltf/accessors.h"

namespace parhelion {

namespace {

std::optional<AnimatedPath> read_path(GltfDocument& document, const JsonRef& json) {
    const std::string_view name = json.as_string();
    if (name == "translation") return AnimatedPath::Translation;
    if (name == "rotation") return AnimatedPath::Rotation;
    if (name == "scale") return AnimatedPath::Scale;
    if (name == "weights") return AnimatedPath::Weights;
    if (name == "pointer")
        document.warn("what KHR_animation_pointer animates stands still");
    else
        document.warn(json, fmt::format("'{}' cannot be animated", escape_name(name, 20)));
    return std::nullopt;
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
            break;
    }
    return {3, 3, NumberKind::Float};
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
    AnimationReader(GltfDocument& document, const std::map<uint32_t, AnimatedNode>& nodes) : document_(document), nodes_(nodes) {}

    Animation read(const JsonRef& json) {
        Animation animation{.name = json.string("name")};
        const JsonRef channels = json.at("channels"), samplers = json.at("samplers");
        if (channels.size() == 0) document_.warn(json, "has no channels");
        std::set<std::pair<uint32_t, AnimatedPath>> moved;
        for (size_t i = 0; i < channels.size(); ++i) {
            const JsonRef target = channels[i].at("target");
            const std::optional<AnimatedPath> path = read_path(document_, target.at("path"));
            const std::optional<JsonRef> node_ref = target.find("node");
            if (!path || !node_ref) continue;
            const uint32_t node_index = node_ref->as_index_of("nodes");
            const auto node = nodes_.find(node_index);
            if (node == nodes_.end()) continue;
            if (!moved.insert({node_index, *path}).second)
                target.fail("moves what a channel before it moves", "an animation moves each property of a node once");
            if (fits(target, *path, node->second) && has_keys(channels[i], samplers)) animation.channels.push_back(read_channel(channels[i], samplers, *path, node->second));
        }
        return animation;
    }

private:
    bool fits(const JsonRef& target, AnimatedPath path, const AnimatedNode& node) {
        if (path == AnimatedPath::Weights && node.target_count == 0) {
            document_.warn(target, "animates weights, but its node has no morph targets");
            return false;
        }
        if (path != AnimatedPath::Weights && document_.entry("nodes", target.at("node")).find("matrix"))
            target.at("node").fail("its node has a matrix", "animated nodes have translation, rotation and scale");
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

    AnimationChannel read_channel(const JsonRef& json, const JsonRef& samplers, AnimatedPath path, const AnimatedNode& node) {
        const JsonRef sampler = sampler_of(json, samplers);
        const OutputShape shape = shape_of(path, node.target_count);
        AnimationChannel channel{.node = node.node, .path = path, .interpolation = read_interpolation(sampler), .width = shape.width};
        document_.files().charge(sizeof(AnimationChannel), json.where());
        channel.times = read_times(document_, sampler.at("input"));
        const JsonRef output = sampler.at("output");
        channel.values = read_numbers(document_, output, shape.components, shape.kind);
        const uint64_t wanted = uint64_t(channel.times.size()) * shape.width * (channel.interpolation == Interpolation::CubicSpline ? 3 : 1);
        if (channel.values.size() != wanted)
            output.fail(fmt::format("has {} elements, but {} keys need {}", channel.values.size() / shape.components, channel.times.size(),
                                    wanted / shape.components));
        if (path == AnimatedPath::Rotation) warn_unless_unit(document_, output, channel);
        return channel;
    }

    GltfDocument& document_;
    const std::map<uint32_t, AnimatedNode>& nodes_;
};

}  // namespace

void add_animations(GltfDocument& document, SceneEdit& edit, const std::map<uint32_t, AnimatedNode>& nodes) {
    const std::optional<JsonRef> animations = document.root().find_array("animations");
    if (!animations) return;
    AnimationReader reader(document, nodes);
    for (size_t i = 0; i < animations->size(); ++i) edit.add(reader.read((*animations)[i]));
}

}  // namespace parhelion
